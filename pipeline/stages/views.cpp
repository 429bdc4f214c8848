#include "pipeline/stages/views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/nrrd.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/stages/loaded_frames.hpp"
#include "pipeline/stages/reconstruction.hpp"
#include "pipeline/stages/standing_picture.hpp"
#include "reconstruction/geometry_file.hpp"
#include "reconstruction/shown_frames.hpp"
#include "reconstruction/views.hpp"

namespace angio::pipeline {
namespace {

using angiogram::ConeBeamFrame;
constexpr std::size_t kOfView = 4;  ///< numbers that name a vessel's ends

/// One picture a view, all of one size.
class ChosenFrames : public reconstruction::FrameReader {
 public:
  void add(std::vector<float> picture) { pictures_.push_back(std::move(picture)); }
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    std::vector<float> pixels;
    for (int f = first; f < first + count; ++f)
      pixels.insert(pixels.end(), pictures_[std::size_t(f)].begin(),
                    pictures_[std::size_t(f)].end());
    return pixels;
  }

 private:
  std::vector<std::vector<float>> pictures_;
};

/// What one view gives: its best filled frame, or the one that is asked for.
struct ChosenView {
  StandingPicture picture;
  int frame = 0;  ///< numbered from 0
  bool is_logarithmic = false;
};

/// What shutter and collimator cover by the header; empty: nothing.
std::vector<char> covered_pixels(const segmentation::LoadedRun& loaded,
                                 const std::optional<reconstruction::OpenField>& field) {
  std::vector<char> covered = loaded.pictures->covered();
  if (!field) return covered;
  covered.resize(std::size_t(loaded.columns) * std::size_t(loaded.rows), 0);
  for (int row = 0; row < loaded.rows; ++row)
    for (int c = 0; c < loaded.columns; ++c)
      if (c < field->first_column || c > field->last_column || row < field->first_row ||
          row > field->last_row)
        covered[std::size_t(row) * std::size_t(loaded.columns) + std::size_t(c)] = 1;
  return covered;
}

/// @param place   among the views that are taken
/// @param number  as `angio inspect` lists it
ChosenView choose_frame(const segmentation::LoadedRun& loaded, std::size_t place, int number,
                        const ReconstructionSettings& settings,
                        std::vector<std::string>& warnings) {
  std::vector<std::string> own;
  reconstruction::RotationalRun run = rotational_run(loaded, {}, own);
  for (const std::string& warning : own)
    warnings.push_back(fmt::format("view {}: {}", number, warning));
  const LoadedFrames pictures(*loaded.pictures);
  run.pictures = &pictures;
  reconstruction::ViewsOptions options = settings.get<&Config::views>();
  options.covered = {covered_pixels(loaded, run.open_field)};
  ChosenView chosen;
  const std::vector<double>& asked = settings.get<&Config::view_frames>();
  if (asked.empty()) {
    constexpr double kPerCent = 100.0;
    chosen.frame =
        reconstruction::find_filled_frame(
            run, options, settings.get<&Config::reconstruction>().phase_percent / kPerCent)
            .best;
  } else if (asked[place] > loaded.frame_count) {
    throw OptionError(fmt::format("views.frames: view {} has {} frames, no {:.0f}", number,
                                  loaded.frame_count, asked[place]));
  } else {
    chosen.frame = int(asked[place]) - 1;
  }
  chosen.picture.frame = run.frames[std::size_t(chosen.frame)];
  chosen.picture.pixels = loaded.pictures->read(chosen.frame, 1);
  chosen.picture.covered = std::move(options.covered.front());
  chosen.is_logarithmic = run.relation == reconstruction::PixelRelation::logarithmic;
  return chosen;
}

/// Where some pictures are logarithmic the others become so, too: contrast is fitted for each view.
reconstruction::PixelRelation same_relation(std::vector<StandingPicture>& pictures,
                                            const std::vector<bool>& is_logarithmic) {
  using reconstruction::PixelRelation;
  if (std::find(is_logarithmic.begin(), is_logarithmic.end(), true) == is_logarithmic.end())
    return PixelRelation::linear;
  for (std::size_t v = 0; v < pictures.size(); ++v)
    if (!is_logarithmic[v])
      for (float& pixel : pictures[v].pixels) pixel = std::log(std::max(pixel, 1.0F));
  return PixelRelation::logarithmic;
}

void require_ends_of_all(const std::vector<double>& numbers, std::size_t view_count) {
  if (!numbers.empty() && numbers.size() != kOfView * view_count)
    throw OptionError(fmt::format(
        "views.ends: {} numbers for {} views. Give column and row of the vessel's proximal "
        "end, then of its distal one, for each view",
        numbers.size(), view_count));
}

/// The wanted vessel's ends, in the pixels of the pictures that are used.
std::vector<reconstruction::VesselEnds> vessel_ends(const std::vector<double>& numbers,
                                                    const std::vector<ConeBeamFrame>& as_given,
                                                    const std::vector<ConeBeamFrame>& used) {
  std::vector<reconstruction::VesselEnds> ends;
  for (std::size_t v = 0; v < used.size() && !numbers.empty(); ++v) {
    const auto moved = [&](std::size_t first) {
      const double column = numbers[kOfView * v + first], row = numbers[kOfView * v + first + 1];
      if (!(column >= 0.0 && column <= as_given[v].columns - 1.0 && row >= 0.0 &&
            row <= as_given[v].rows - 1.0))
        throw OptionError(
            fmt::format("views.ends: {:g}, {:g} lies outside view {}, which has {} "
                        "columns and {} rows of pixels",
                        column, row, v + 1, as_given[v].columns, as_given[v].rows));
      const angiogram::SeenPoint seen =
          angiogram::ConeBeamView(used[v]).see(as_given[v].place(column, row));
      return std::array{seen.column, seen.row};
    };
    ends.push_back({moved(0), moved(2)});
  }
  return ends;
}

nlohmann::json to_json(const Vec3& v) { return nlohmann::json::array({v.x, v.y, v.z}); }

nlohmann::json to_json(const reconstruction::TreeOfViews& result,
                       const segmentation::LoadedViews& loaded, const std::vector<int>& frames) {
  nlohmann::json views = nlohmann::json::array(), used = nlohmann::json::array();
  for (std::size_t v = 0; v < frames.size(); ++v) {
    used.push_back(int(v) + 1);
    views.push_back(
        {{"view", loaded.numbers[v]},
         {"primary_degrees", loaded.views[v].run.primary_angles_degrees.front()},
         {"secondary_degrees", loaded.views[v].run.secondary_angles_degrees.front()},
         {"frame", frames[v] + 1},
         {"shift_mm", to_json(result.shifts_mm[v])},
         {"turn_degrees",
          result.turns_degrees.empty() ? nlohmann::json() : to_json(result.turns_degrees[v])},
         {"lines_explained_percent", 100.0 * result.explained_parts[v]},
         {"contrast_per_mm", result.fit.contrast_per_mm[v]}});
  }
  return {{"method", "views"},
          {"frames", frames.size()},
          {"views", views},
          {"widest_angle_degrees", result.widest_angle_degrees},
          {"doubt", result.doubt.empty() ? nlohmann::json() : nlohmann::json(result.doubt)},
          {"agreement", result.agreement},
          {"skew_mm", result.skew_mm},
          {"measured_view_by_view", result.by_view},
          {"converged", result.fit.converged},
          {"steps", result.fit.steps},
          {"noise", result.fit.noise},
          {"correlation", result.fit.correlation},
          {"blur_pixels", result.fit.blur_pixels},
          {"gating", {{"gated", false}, {"frames_used", used}}}};
}

}  // namespace

void do_views(StageWork& work, const segmentation::LoadedViews& loaded,
              const ReconstructionSettings& settings) {
  keep(work.warnings, loaded.warnings);
  work.input_description = loaded.source_description;
  std::vector<StandingPicture> pictures;
  std::vector<int> chosen_frames;
  std::vector<bool> is_logarithmic;
  if (const std::size_t asked = settings.get<&Config::view_frames>().size();
      asked != 0 && asked != loaded.views.size())
    throw OptionError(
        fmt::format("views.frames names {} frames, and {} views are taken. Name one a "
                    "view",
                    asked, loaded.views.size()));
  require_ends_of_all(settings.get<&Config::view_ends>(), loaded.views.size());
  for (std::size_t v = 0; v < loaded.views.size(); ++v) {
    work.progress.report(
        0.05 + 0.15 * double(v) / double(loaded.views.size()),
        fmt::format("looking for the best filled frame of view {}", loaded.numbers[v]));
    ChosenView chosen =
        choose_frame(loaded.views[v], v, loaded.numbers[v], settings, work.warnings);
    pictures.push_back(std::move(chosen.picture));
    chosen_frames.push_back(chosen.frame);
    is_logarithmic.push_back(chosen.is_logarithmic);
  }
  reconstruction::RotationalRun run;
  run.relation = same_relation(pictures, is_logarithmic);
  std::vector<ConeBeamFrame> as_given;
  for (const StandingPicture& picture : pictures) as_given.push_back(picture.frame);
  even_out(pictures);
  ChosenFrames frames;
  reconstruction::ViewsOptions options = settings.get<&Config::views>();
  for (StandingPicture& picture : pictures) {
    run.frames.push_back(picture.frame);
    options.covered.push_back(std::move(picture.covered));
    frames.add(std::move(picture.pixels));
  }
  run.pictures = &frames;
  options.voxel_mm = settings.get<&Config::reconstruction>().voxel_mm;
  options.ends = vessel_ends(settings.get<&Config::view_ends>(), as_given, run.frames);
  options.largest_side = settings.get<&Config::reconstruction>().largest_side;
  options.max_memory_gib = settings.get<&Config::input>().max_memory_gib;
  const reconstruction::TreeOfViews result =
      reconstruction::reconstruct_views(run, options, part(work.progress, 0.2, 0.95));
  keep(work.warnings, result.warnings);
  work.progress.report(0.95, "writing");
  formats::write_nrrd(work.out / "volume.nrrd", result.volume, formats::NrrdEncoding::raw);
  write_centerlines(work.out / "centerlines.vtp", result.fit.tree, result.fit.radius_sd);
  write_text_atomically(work.out / "geometry.xml", reconstruction::rtk_geometry(result.fit.frames));
  write_text_atomically(work.out / "quality.json",
                        to_json(result, loaded, chosen_frames).dump(2) + "\n");
  std::vector<int> shown(run.frames.size());
  std::iota(shown.begin(), shown.end(), 0);
  write_shown_frames(
      work.out, reconstruction::show_frames(run, result.fit.frames, shown, result.unattenuated),
      false);
}

}  // namespace angio::pipeline
