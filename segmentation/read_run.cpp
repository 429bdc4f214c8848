#include "segmentation/read_run.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/statistics.hpp"
#include "core/text.hpp"
#include "segmentation/detail/dicom_pictures.hpp"
#include "segmentation/detail/dicom_series.hpp"
#include "segmentation/detail/projection_angles.hpp"
#include "segmentation/detail/rotational_run.hpp"
#include "segmentation/detail/volume_file.hpp"

namespace angio::segmentation {
namespace {

namespace fs = std::filesystem;
using detail::DicomHeader;
using detail::DicomSeries;

/// A series that is one run that turns.
struct Candidate {
  std::size_t series = 0;
  const DicomHeader* header = nullptr;
  ProjectionRun run;
};

std::optional<Candidate> candidate(const DicomSeries& series, std::size_t index,
                                   const ReadOptions& options, RunGeometry geometry) {
  if (series.headers.size() != 1) return {};
  const DicomHeader& header = series.headers.front();
  if (header.kind != detail::DicomKind::projection || !header.projection || !header.problem.empty())
    return {};
  Candidate found{index, &header, *header.projection};
  detail::settle_angles(found.run, int(header.frames.size()), options.angles);
  if (geometry == RunGeometry::by_header && !detail::turns(found.run)) return {};
  return found;
}

std::vector<Candidate> candidates(const std::vector<DicomSeries>& all, const ReadOptions& options,
                                  RunGeometry geometry) {
  std::vector<Candidate> found;
  for (std::size_t s = 0; s < all.size(); ++s)
    if (auto one = candidate(all[s], s, options, geometry)) found.push_back(std::move(*one));
  return found;
}

bool same_angles(const std::vector<double>& a, const std::vector<double>& b) {
  constexpr double kDegree = 1.0;
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) {
           return std::abs(x - y) <= kDegree;
         });
}

/// Whether two runs show the same from the same sides, frame by frame.
bool are_alike(const Candidate& one, const Candidate& other) {
  return one.header->pixels.columns == other.header->pixels.columns &&
         one.header->pixels.rows == other.header->pixels.rows &&
         one.header->frames.size() == other.header->frames.size() &&
         same_angles(one.run.primary_angles_degrees, other.run.primary_angles_degrees) &&
         same_angles(one.run.secondary_angles_degrees, other.run.secondary_angles_degrees);
}

/// How far the darkest pixels of one run against another, and the brightest, are from their median:
/// logarithms of beams, summed over some frames.
struct Tails {
  double darker = 0.0, brighter = 0.0;
};

Tails compare_pixels(const Candidate& one, const Candidate& other) {
  constexpr int kFrames = 7;
  constexpr double kTail = 0.002;  // of the pixels
  std::vector<int> frames;
  const auto count = int(one.header->frames.size());
  for (int n = 0; n < kFrames; ++n) frames.push_back((2 * n + 1) * count / (2 * kFrames));
  const std::vector<float> a = detail::DicomPictures(*one.header).read_some(frames);
  const std::vector<float> b = detail::DicomPictures(*other.header).read_some(frames);
  const bool is_log = one.run.pixel_relation == "LOG";
  Tails tails;
  const std::size_t per_frame = a.size() / frames.size();
  for (std::size_t f = 0; f < frames.size(); ++f) {
    std::vector<double> against;
    for (std::size_t i = f * per_frame; i < (f + 1) * per_frame; ++i)
      if (is_log || (a[i] > 0.0F && b[i] > 0.0F))
        against.push_back(is_log ? double(a[i]) - double(b[i]) : std::log(double(a[i]) / b[i]));
    if (against.empty()) continue;
    const double middle = quantile(against, 0.5);
    tails.darker += middle - quantile(against, kTail);
    tails.brighter += quantile(against, 1.0 - kTail) - middle;
  }
  return tails;
}

/// Whether the first of two runs that are alike is filled, and the other its mask: by their headers
/// where only one names a contrast medium, else by their pixels: vessels are darker in it by far
/// more than anything is brighter.
bool fills(const Candidate& one, const Candidate& other) {
  constexpr double kFarMore = 2.0;
  if (one.run.has_contrast_medium != other.run.has_contrast_medium)
    return one.run.has_contrast_medium;
  try {  // of damaged pixels the run that is taken tells
    const Tails tails = compare_pixels(one, other);
    return tails.darker > kFarMore * tails.brighter;
  } catch (const InputError&) {
    return false;
  }
}

/// The one that is asked for, or the largest; null: it is not a run that is wanted.
const Candidate* choose(const std::vector<DicomSeries>& all, const std::vector<Candidate>& runs,
                        const ReadOptions& options) {
  if (options.series.empty()) {
    if (runs.empty() || std::any_of(all.begin(), all.end(), [](const DicomSeries& series) {
          return series.is_volume_kind;
        }))
      return nullptr;
    const Candidate* chosen = &runs.front();
    for (const Candidate& run : runs)
      if (run.run.has_contrast_medium && !chosen->run.has_contrast_medium &&
          all[run.series].pixel_count() == all[chosen->series].pixel_count())
        chosen = &run;
    // Of a run and its mask run the filled one.
    for (const Candidate& run : runs)
      if (run.series != chosen->series && are_alike(run, *chosen) && fills(run, *chosen))
        chosen = &run;
    return chosen;
  }
  for (const Candidate& run : runs)
    if (all[run.series].key == options.series || std::to_string(run.series + 1) == options.series)
      return &run;
  return nullptr;
}

const Candidate* mask_run(const std::vector<Candidate>& runs, const Candidate& filled) {
  for (const Candidate& other : runs)
    if (other.series != filled.series && are_alike(filled, other) && fills(filled, other))
      return &other;
  return nullptr;
}

/// An angle a frame.
void spread(std::vector<double>& angles, int frames) {
  if (angles.empty()) angles.push_back(0.0);
  if (angles.size() == 1) angles.assign(std::size_t(frames), angles.front());
}

/// The slices of a volume file.
class StackPictures : public RunPictures {
 public:
  explicit StackPictures(Volume<float> stack) : stack_(std::move(stack)) {}
  void read_into(int first, int count, float* pixels) const override {
    std::copy_n(stack_.values.data() + stack_.geometry.offset(0, 0, first),
                stack_.geometry.offset(0, 0, count), pixels);
  }
  [[nodiscard]] std::vector<float> read_some(const std::vector<int>& frames) const override {
    std::vector<float> pixels(frames.size() * per_frame());
    for (std::size_t n = 0; n < frames.size(); ++n)
      read_into(frames[n], 1, pixels.data() + n * per_frame());
    return pixels;
  }
  [[nodiscard]] const VolumeGeometry& geometry() const { return stack_.geometry; }

 protected:
  [[nodiscard]] std::size_t per_frame() const override { return stack_.geometry.offset(0, 0, 1); }

 private:
  Volume<float> stack_;
};

/// Zero is what a header has that does not say it: then, or in the middle, the picture's middle is
/// the detector's.
void place_first_pixel(const VolumeGeometry& g, LoadedRun& loaded) {
  constexpr double kSame = 0.05;  // of a pixel
  const std::array<double, 2> first{g.origin.x, g.origin.y};
  const double columns = g.spacing.x, rows = g.spacing.y;
  if (first[0] == 0.0 && first[1] == 0.0) return;
  if (std::abs(first[0] + 0.5 * (g.size[0] - 1) * columns) < kSame * columns &&
      std::abs(first[1] + 0.5 * (g.size[1] - 1) * rows) < kSame * rows)
    return;
  loaded.first_pixel_mm = first;
}

LoadedRun read_stack(const fs::path& path, ReadOptions options, const Progress& progress) {
  if (!options.unit)
    options.unit = LengthUnit::mm;  // a detector's pixels may be as fine as they are
  const bool has_spacing =
      detail::volume_file_format(path) != "TIFF" || options.spacing_mm[0] > 0.0;
  if (!has_spacing) options.spacing_mm = {1.0, 1.0, 1.0};  // matrices in pixels need none
  LoadedVolume file = read_volume(path, options, progress);
  const auto stack = std::make_shared<StackPictures>(std::move(file.volume));
  LoadedRun loaded;
  const VolumeGeometry& g = stack->geometry();
  loaded.columns = g.size[0];
  loaded.rows = g.size[1];
  loaded.frame_count = g.size[2];
  if (has_spacing) loaded.run.detector_spacing_mm = {g.spacing.x, g.spacing.y};
  place_first_pixel(g, loaded);
  if (has_spacing && g.spacing.x == 1.0 && g.spacing.y == 1.0)
    loaded.warnings.emplace_back(
        "the stack's pixels are said to be 1 x 1 mm on the detector. If that is only what its "
        "writer "
        "puts where nothing is known, put the detector's into its header: RTK's geometry rests on "
        "it");
  loaded.run.pixel_relation = "LIN";
  loaded.pictures = stack;
  loaded.source_description =
      "stack of " + std::to_string(loaded.frame_count) + " frames, " + file.source_description;
  loaded.warnings = std::move(file.warnings);
  loaded.warnings.emplace_back(
      "the stack's pixels were taken to be linear in the beam's intensity");
  return loaded;
}

}  // namespace

std::vector<float> RunPictures::read(int first, int count) const {
  std::vector<float> pixels(std::size_t(count) * per_frame());
  read_into(first, count, pixels.data());
  return pixels;
}

std::optional<LoadedRun> read_run(const fs::path& path, const ReadOptions& options,
                                  RunGeometry geometry, const Progress& progress) {
  options.validate();
  if (geometry == RunGeometry::given && detail::is_volume_file_name(path) &&
      !fs::is_directory(path))
    return read_stack(path, options, progress);
  if (detail::is_volume_file_name(path) && !fs::is_directory(path)) return {};
  const detail::FoundSeries found = detail::find_series(path, options, progress);
  const std::vector<Candidate> runs = candidates(found.all, options, geometry);
  const Candidate* chosen = choose(found.all, runs, options);
  if (!chosen) return {};
  const DicomHeader& header = *chosen->header;
  if (const std::string why = geometry == RunGeometry::given
                                  ? std::string()
                                  : detail::refusal_of_turn(header, chosen->run);
      !why.empty())
    throw InputError(detail::describe(found.all[chosen->series], chosen->series) + ": " + why);
  if (header.lossy && !options.allow_lossy)
    throw InputError(detail::describe(found.all[chosen->series], chosen->series) +
                     " was compressed with loss (edges may have moved, and so would every "
                     "diameter). Export it without loss, or measure all the same with "
                     "--allow-lossy");
  LoadedRun loaded;
  loaded.run = chosen->run;
  loaded.columns = header.pixels.columns;
  loaded.rows = header.pixels.rows;
  loaded.frame_count = int(header.frames.size());
  spread(loaded.run.primary_angles_degrees, loaded.frame_count);
  spread(loaded.run.secondary_angles_degrees, loaded.frame_count);
  loaded.pictures = std::make_shared<detail::DicomPictures>(header);
  const Candidate* mask = mask_run(runs, *chosen);
  if (mask) loaded.masks = std::make_shared<detail::DicomPictures>(*mask->header);
  loaded.source_description = header.sop_class_name + ", " + std::to_string(loaded.frame_count) +
                              " frames" + (mask ? ", with its mask run" : "") +
                              (header.is_of_the_heart ? std::string(", ") + kOfTheHeart : "");
  loaded.warnings = found.warnings;
  if (mask && mask->run.has_contrast_medium == chosen->run.has_contrast_medium)
    loaded.warnings.push_back(detail::describe(found.all[mask->series], mask->series) +
                              " was taken for the run's mask, by its pixels (" +
                              (mask->run.has_contrast_medium ? "both name" : "neither names") +
                              " a contrast medium). If it is filled, too, give the run alone");
  for (const std::string& note : chosen->run.notes)
    if (!note.starts_with("spacing:")) loaded.warnings.push_back(note);
  for (std::size_t s = 0; s < found.all.size(); ++s)
    if (s != chosen->series && (!mask || s != mask->series))
      loaded.warnings.push_back(detail::describe(found.all[s], s) +
                                " was left out: another run was taken (--series names one)");
  return loaded;
}

bool is_rotational_run(const fs::path& path, const ReadOptions& options) {
  if (detail::is_volume_file_name(path) && !fs::is_directory(path)) return false;
  const detail::FoundSeries found = detail::find_series(path, options);
  const std::vector<Candidate> runs = candidates(found.all, options, RunGeometry::by_header);
  return choose(found.all, runs, options) != nullptr;
}

}  // namespace angio::segmentation
