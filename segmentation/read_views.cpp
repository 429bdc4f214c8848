#include "segmentation/read_views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "angiogram/c_arm.hpp"
#include "core/error.hpp"
#include "segmentation/detail/available_memory.hpp"
#include "segmentation/detail/dicom_pictures.hpp"
#include "segmentation/detail/dicom_series.hpp"
#include "segmentation/detail/projection_angles.hpp"
#include "segmentation/detail/rotational_run.hpp"
#include "segmentation/detail/volume_file.hpp"

namespace angio::segmentation {
namespace {

namespace fs = std::filesystem;
using angiogram::kLeastViewAngle;
using detail::DicomHeader;
constexpr double kSameSide = 10.0;  ///< [degrees]

/// An object that is a view.
struct ViewCandidate {
  const DicomHeader* header = nullptr;
  std::string series;
  ProjectionRun run;
  std::string problem;
};

double of(const std::vector<double>& angles) { return angles.empty() ? 0.0 : angles.front(); }

std::string why_not(const DicomHeader& header, const ProjectionRun& run,
                    const ReadOptions& options) {
  if (!header.problem.empty()) return header.problem;
  if (run.primary_angles_degrees.empty() || run.secondary_angles_degrees.empty())
    return "it does not state both of its angles (an anonymiser may have removed them). Export it "
           "again";
  constexpr double kStill = 2.0;
  const auto turn = [](const std::vector<double>& angles) {
    const auto [least, most] = std::minmax_element(angles.begin(), angles.end());
    return *most - *least;
  };
  if (const double degrees =
          std::max(turn(run.primary_angles_degrees), turn(run.secondary_angles_degrees));
      degrees > kStill)
    return fmt::format(
        "it turns by {:.0f} degrees (too much for a view, too little for a volume). Give a run of "
        "a "
        "C-arm that stands still",
        degrees);
  if (std::string why = detail::refusal_of_distances(run); !why.empty()) return why;
  constexpr double kFinest = 0.02, kCoarsest = 5.0;
  for (const double spacing : run.detector_spacing_mm)
    if (!(spacing >= kFinest && spacing <= kCoarsest))
      return fmt::format(
          "its detector's pixels of {:g} mm are none that there are. Export it again", spacing);
  if (header.lossy && !options.allow_lossy)
    return "it was compressed with loss (edges may have moved, and so would every diameter). "
           "Export it without loss, or measure all the same with --allow-lossy";
  return {};
}

/// Every object that is a run of projections which does not turn.
std::vector<ViewCandidate> candidates(const std::vector<detail::DicomSeries>& all,
                                      const ReadOptions& options) {
  std::vector<ViewCandidate> found;
  for (const detail::DicomSeries& series : all)
    for (const DicomHeader& header : series.headers) {
      if (header.kind != detail::DicomKind::projection || !header.projection ||
          header.frames.empty())
        continue;
      ViewCandidate view{&header, series.key, *header.projection, {}};
      detail::settle_angles(view.run, int(header.frames.size()), options.angles);
      if (detail::turns(view.run)) continue;
      view.problem = why_not(header, view.run, options);
      found.push_back(std::move(view));
    }
  return found;
}

bool holds_something_else(const std::vector<detail::DicomSeries>& all, const ReadOptions& options) {
  return std::any_of(all.begin(), all.end(), [&](const detail::DicomSeries& series) {
    if (series.is_volume_kind) return true;
    return std::any_of(series.headers.begin(), series.headers.end(),
                       [&](const DicomHeader& header) {
                         if (!header.projection || !header.problem.empty()) return false;
                         ProjectionRun run = *header.projection;
                         detail::settle_angles(run, int(header.frames.size()), options.angles);
                         return detail::turns(run);
                       });
  });
}

/// Between two beams, from whichever end [degrees].
double apart(const ProjectionRun& a, const ProjectionRun& b) {
  const auto beam = [](const ProjectionRun& run) {
    return angiogram::c_arm_axes({of(run.primary_angles_degrees), of(run.secondary_angles_degrees)})
        .to_detector;
  };
  return angiogram::angle_between_beams(beam(a), beam(b));
}

std::string in_words(const ViewCandidate& view, std::size_t index) {
  return fmt::format("view {} ({:.0f}/{:.0f} degrees, {} frames)", index + 1,
                     of(view.run.primary_angles_degrees), of(view.run.secondary_angles_degrees),
                     view.header->frames.size());
}

/// The views with these numbers, counted from 0.
std::vector<std::size_t> asked_for(const std::vector<ViewCandidate>& all,
                                   const std::vector<int>& numbers) {
  std::vector<std::size_t> chosen;
  for (const int number : numbers) {
    const std::size_t index = std::size_t(number) - 1;
    if (index >= all.size())
      throw InputError(fmt::format("there is no view {}: the input holds {} (see `angio inspect`)",
                                   number, all.size()));
    if (!all[index].problem.empty())
      throw InputError(in_words(all[index], index) + " cannot be used: " + all[index].problem);
    chosen.push_back(index);
  }
  return chosen;
}

struct Choice {
  std::vector<std::size_t> views;
  std::vector<std::string> warnings;
};

/// All that can be used, but one from each side.
Choice by_rule(const std::vector<ViewCandidate>& all) {
  Choice choice;
  for (std::size_t v = 0; v < all.size(); ++v) {
    if (!all[v].problem.empty()) {
      choice.warnings.push_back(in_words(all[v], v) + " was left out: " + all[v].problem);
      continue;
    }
    const auto same = std::find_if(
        choice.views.begin(), choice.views.end(),
        [&](std::size_t other) { return apart(all[other].run, all[v].run) < kSameSide; });
    if (same == choice.views.end()) {
      choice.views.push_back(v);
      continue;
    }
    std::size_t left_out = v;
    if (all[v].header->frames.size() > all[*same].header->frames.size()) std::swap(*same, left_out);
    choice.warnings.push_back(in_words(all[left_out], left_out) +
                              " was left out: another one is from the same side");
  }
  std::sort(choice.views.begin(), choice.views.end());
  return choice;
}

bool tell_depth(const std::vector<ViewCandidate>& all, const std::vector<std::size_t>& views) {
  for (const std::size_t a : views)
    for (const std::size_t b : views)
      if (apart(all[a].run, all[b].run) >= kLeastViewAngle) return true;
  return false;
}

/// Whether there are views that would tell depth, could all be used.
bool are_views_of(const std::vector<ViewCandidate>& all) {
  std::vector<std::size_t> with_angles;
  for (std::size_t v = 0; v < all.size(); ++v)
    if (!all[v].run.primary_angles_degrees.empty() && !all[v].run.secondary_angles_degrees.empty())
      with_angles.push_back(v);
  return tell_depth(all, with_angles);
}

/// Which are taken; none: the input is not of views.
Choice choose(const std::vector<ViewCandidate>& all, const ReadOptions& options) {
  if (!options.views.empty()) {
    Choice choice{asked_for(all, options.view_numbers()), {}};
    if (!tell_depth(all, choice.views))
      throw InputError(
          fmt::format("the views asked for are less than {:.0f} degrees apart (depth would not be "
                      "told). Give two or more of the same vessel from sides that differ more",
                      kLeastViewAngle));
    return choice;
  }
  Choice choice = by_rule(all);
  if (!tell_depth(all, choice.views)) {
    for (std::size_t v = 0; v < all.size(); ++v)
      if (!all[v].problem.empty() && are_views_of(all))
        throw InputError(in_words(all[v], v) + " cannot be used: " + all[v].problem);
    return {};
  }
  if (int(choice.views.size()) > kMostViews)
    throw InputError(
        fmt::format("the input holds {} angiograms of a C-arm that stood still (they may be of "
                    "several vessels). Name two or more of the same vessel, {:.0f} degrees apart, "
                    "with --views 1,2 (see `angio inspect`)",
                    choice.views.size(), kLeastViewAngle));
  return choice;
}

/// Every view's picture as floats, and what finding the vessels of the largest takes, which is done
/// one after the other.
std::uint64_t memory_needed(const std::vector<ViewCandidate>& all,
                            const std::vector<std::size_t>& views) {
  constexpr std::uint64_t kWorking = 100;  // bytes a pixel
  std::uint64_t pictures = 0, largest = 0;
  for (const std::size_t v : views) {
    const std::uint64_t pixels = all[v].header->pixels.per_frame();
    pictures += pixels * sizeof(float);
    largest = std::max(largest, pixels);
  }
  return pictures + kWorking * largest;
}

LoadedRun load(const ViewCandidate& view) {
  LoadedRun loaded;
  loaded.run = view.run;
  loaded.columns = view.header->pixels.columns;
  loaded.rows = view.header->pixels.rows;
  loaded.frame_count = int(view.header->frames.size());
  loaded.run.primary_angles_degrees.assign(std::size_t(loaded.frame_count),
                                           of(view.run.primary_angles_degrees));
  loaded.run.secondary_angles_degrees.assign(std::size_t(loaded.frame_count),
                                             of(view.run.secondary_angles_degrees));
  loaded.pictures = std::make_shared<detail::DicomPictures>(*view.header);
  return loaded;
}

}  // namespace

std::optional<LoadedViews> read_views(const fs::path& path, const ReadOptions& options,
                                      const Progress& progress) {
  options.validate();
  if (detail::is_volume_file_name(path) && !fs::is_directory(path)) return {};
  const detail::FoundSeries found = detail::find_series(path, options, progress);
  if (options.views.empty() &&
      (!options.series.empty() || holds_something_else(found.all, options)))
    return {};
  const std::vector<ViewCandidate> all = candidates(found.all, options);
  const Choice choice = choose(all, options);
  if (choice.views.empty()) return {};
  detail::check_memory(memory_needed(all, choice.views), options.max_memory_gib,
                       fmt::format("{} views", choice.views.size()));
  LoadedViews loaded;
  loaded.warnings = found.warnings;
  loaded.warnings.insert(loaded.warnings.end(), choice.warnings.begin(), choice.warnings.end());
  for (const std::size_t v : choice.views) {
    loaded.views.push_back(load(all[v]));
    loaded.numbers.push_back(int(v) + 1);
    for (const std::string& note : all[v].run.notes)
      if (!note.starts_with("spacing:"))
        loaded.warnings.push_back(fmt::format("view {}: {}", v + 1, note));
  }
  const DicomHeader& first = *all[choice.views.front()].header;
  loaded.source_description =
      fmt::format("{} views, {}{}", choice.views.size(), first.sop_class_name,
                  first.is_of_the_heart ? std::string(", ") + kOfTheHeart : std::string());
  return loaded;
}

bool are_views(const fs::path& path, const ReadOptions& options) {
  if (detail::is_volume_file_name(path) && !fs::is_directory(path)) return false;
  const detail::FoundSeries found = detail::find_series(path, options);
  if (!options.views.empty()) return true;  // read_views() says what is wrong with them
  if (!options.series.empty() || holds_something_else(found.all, options)) return false;
  return are_views_of(candidates(found.all, options));  // read_views() says which cannot be used
}

std::vector<ViewSummary> list_views(const fs::path& path, const ReadOptions& options) {
  if (detail::is_volume_file_name(path) && !fs::is_directory(path)) return {};
  const detail::FoundSeries found = detail::find_series(path, options);
  std::vector<ViewSummary> list;
  for (const ViewCandidate& view : candidates(found.all, options))
    list.push_back({int(list.size()) + 1, view.series, of(view.run.primary_angles_degrees),
                    of(view.run.secondary_angles_degrees), int(view.header->frames.size()),
                    view.problem});
  return list;
}

}  // namespace angio::segmentation
