#include "segmentation/read_volume.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>
#include <utility>

#include "core/error.hpp"
#include "core/text.hpp"
#include "segmentation/detail/available_memory.hpp"
#include "segmentation/detail/dicom_pixels.hpp"
#include "segmentation/detail/dicom_series.hpp"
#include "segmentation/detail/label_map.hpp"
#include "segmentation/detail/projection_angles.hpp"
#include "segmentation/detail/rotational_run.hpp"
#include "segmentation/detail/volume_file.hpp"
#include "segmentation/detail/volume_unit.hpp"

namespace angio::segmentation {
namespace fs = std::filesystem;
using detail::DicomSeries;
namespace {

void check_exists(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error))
    throw InputError("there is no " + path.string() + ". Check the path", ExitCode::no_input);
  if (fs::is_directory(path, error)) {
    const bool empty = fs::is_empty(path, error);
    if (error)
      throw InputError("the folder " + path.string() + " cannot be opened (" + error.message() +
                           "). Check its permissions",
                       ExitCode::no_input);
    if (empty) throw InputError(path.string() + " is empty. Give a DICOM folder or a volume file");
    return;
  }
  if (!fs::is_regular_file(path, error))
    throw InputError(path.string() +
                     " is neither a file nor a folder (a pipe or a device cannot be read twice). "
                     "Give a DICOM folder or a volume file");
  if (fs::file_size(path, error) == 0 && !error)
    throw InputError(path.string() + " is empty. Give a DICOM folder or a volume file");
}

/// A voxel size that is given is in mm.
std::optional<LengthUnit> unit_of(const ReadOptions& options) {
  return options.spacing_mm[0] > 0.0 && !options.unit ? LengthUnit::mm : options.unit;
}

std::vector<fs::path> volume_files_in(const fs::path& path) {
  if (is_volume_file(path)) return {path};
  std::vector<fs::path> files;
  std::error_code ignored;
  if (fs::is_directory(path))
    for (const auto& entry : fs::directory_iterator(path))
      if (entry.is_regular_file(ignored) && detail::is_volume_file_name(entry.path()))
        files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

[[noreturn]] void fail_without_dicom(const fs::path& path) {
  if (!fs::is_directory(path))
    throw InputError(
        path.filename().string() +
        " holds no DICOM, and is no volume file (.nrrd .nhdr .mha .mhd .nii .nii.gz "
        ".vti .vtk .tif .tiff). Give one of these, a zip archive of DICOM files, or a surface "
        "(.stl .vtp .vtk .vtu .ply .obj .off .msh .mesh .glb .gltf)");
  const auto files = volume_files_in(path);
  if (!files.empty())
    throw InputError("the folder " + path.string() + " holds no DICOM, but " +
                     files.front().filename().string() + ". Give that file");
  throw InputError("the folder " + path.string() + " holds no DICOM. Give the folder of a series");
}

void warn_of_others(const std::vector<DicomSeries>& all, std::size_t chosen,
                    std::vector<std::string>& warnings) {
  std::vector<std::pair<std::string, std::vector<std::string>>> left_out;  // by reason
  for (std::size_t s = 0; s < all.size(); ++s) {
    if (s == chosen) continue;
    const std::string reason =
        all[s].usable ? "it has fewer voxels, or another was asked for" : all[s].verdict;
    auto same = std::find_if(left_out.begin(), left_out.end(),
                             [&](const auto& one) { return one.first == reason; });
    if (same == left_out.end()) same = left_out.insert(same, {reason, {}});
    same->second.push_back(detail::describe(all[s], s));
  }
  for (const auto& [reason, series] : left_out)
    warnings.push_back(list_a_few(series, "series") +
                       (series.size() == 1 ? " was left out: " : " were left out, each because ") +
                       reason);
}

/// Slices as floats, their resampled copy with as much again in between, and the largest object
/// as it is stored and as it is decoded.
std::uint64_t memory_needed(const DicomSeries& series) {
  std::uint64_t largest = 0;
  for (const auto& header : series.headers)
    largest = std::max<std::uint64_t>(
        largest, std::uint64_t(header.pixels.per_frame()) * header.frames.size());
  const std::uint64_t slices = std::uint64_t(series.pixel_count()) * sizeof(float);
  const std::uint64_t resampled =
      series.stack.places.empty() ? 0 : 2 * series.stack.geometry.voxel_count() * sizeof(float);
  return slices + resampled + 2 * largest * sizeof(std::uint16_t);
}

LoadedVolume read_dicom(const fs::path& path, const ReadOptions& options,
                        const Progress& progress) {
  LoadedVolume loaded;
  const detail::FoundSeries found = detail::find_series(path, options, progress);
  if (found.all.empty()) fail_without_dicom(path);
  const std::size_t chosen = detail::choose_series(found.all, options);
  const DicomSeries& series = found.all[chosen];
  const detail::DicomHeader& first = series.headers.front();
  loaded.warnings = found.warnings;
  warn_of_others(found.all, chosen, loaded.warnings);
  loaded.warnings.insert(loaded.warnings.end(), series.warnings.begin(), series.warnings.end());
  detail::check_memory(memory_needed(series), options.max_memory_gib,
                       detail::describe(series, chosen));
  loaded.volume.geometry = series.stack.geometry;
  loaded.volume.values = detail::decode_frames(series.headers, series.slices, progress);
  if (!series.stack.places.empty())
    loaded.volume.values = detail::resample_stack(loaded.volume.values, first.pixels.columns,
                                                  first.pixels.rows, series.stack);
  loaded.source_description = first.sop_class_name + ", " + std::to_string(series.slices.size()) +
                              " slices" +
                              (first.is_of_the_heart ? std::string(", ") + kOfTheHeart : "");
  return loaded;
}

/// Values that are not numbers would spread through every filter.
void replace_non_finite(LoadedVolume& loaded) {
  float least = std::numeric_limits<float>::infinity();
  std::size_t bad = 0;
  for (float value : loaded.volume.values) {
    if (std::isfinite(value))
      least = std::min(least, value);
    else
      ++bad;
  }
  if (bad == 0) return;
  if (bad == loaded.volume.values.size())
    throw InputError(
        "the volume holds no numbers (every voxel is NaN or infinite). Export it "
        "again");
  for (float& value : loaded.volume.values)
    if (!std::isfinite(value)) value = least;
  loaded.warnings.push_back(std::to_string(bad) +
                            " voxels were not numbers; they were set to the lowest value");
}

std::string pixel_format(const detail::DicomHeader& header) {
  if (header.pixels.bits_allocated == 0) return {};
  return std::to_string(header.pixels.bits_allocated) + " bits, " +
         std::to_string(header.pixels.bits_stored) + " stored, " +
         (header.pixels.is_signed ? "signed" : "unsigned") + ", MONOCHROME" +
         (header.pixels.is_monochrome1 ? "1" : "2");
}

/// Every syntax in the series, in the order of its files.
std::string transfer_syntaxes(const DicomSeries& series) {
  std::vector<std::string> names;
  for (const auto& header : series.headers)
    if (!header.transfer_syntax_name.empty() &&
        std::find(names.begin(), names.end(), header.transfer_syntax_name) == names.end())
      names.push_back(header.transfer_syntax_name);
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : "; ") + name;
  return text.empty() ? "unknown" : text;
}

SeriesSummary summarize(const DicomSeries& series, const ReadOptions& options) {
  const auto& first = series.headers.front();
  SeriesSummary summary;
  summary.key = series.key;
  summary.kind = first.sop_class_name;
  summary.transfer_syntax = transfer_syntaxes(series);
  summary.pixel_format = pixel_format(first);
  summary.geometry = series.stack.geometry;
  if (!series.usable)
    summary.geometry.size = {first.pixels.columns, first.pixels.rows, int(series.members.size())};
  summary.file_count = int(series.headers.size());
  summary.frame_count = int(series.members.size());
  summary.usable = series.usable;
  summary.lossy = series.lossy();
  summary.resampled = !series.stack.places.empty();
  summary.tilt_degrees = series.stack.tilt_degrees;
  summary.verdict = series.verdict;
  if (summary.usable && summary.lossy && !options.allow_lossy)
    summary.verdict += ", but compressed with loss; needs --allow-lossy";
  summary.warnings = series.warnings;
  summary.projection = first.projection;
  if (summary.projection) {
    detail::settle_angles(*summary.projection, int(first.frames.size()), options.angles);
    summary.is_rotational = summary.frame_count > 1 && detail::turns(*summary.projection) &&
                            detail::refusal_of_turn(first, *summary.projection).empty();
  }
  return summary;
}

SeriesSummary summarize(const fs::path& path, const ReadOptions& options) {
  SeriesSummary summary;
  summary.key = detail::volume_file_format(path);
  summary.kind = "volume file";
  summary.transfer_syntax = "none";
  summary.file_count = 1;
  try {
    auto file = detail::load_volume_file(path, detail::VolumePart::header, options);
    detail::bring_to_mm(file, path, unit_of(options));
    summary.geometry = file.volume.geometry;
    summary.frame_count = summary.geometry.size[2];
    summary.usable = true;
    summary.verdict = "regular grid";
    summary.warnings = file.warnings;
    summary.labels = detail::find_labels(
        detail::load_volume_file(path, detail::VolumePart::whole, options).volume);
    if (!summary.labels.empty()) summary.kind = "label map";
  } catch (const InputError& error) {
    summary.usable = false;
    summary.verdict = error.what();
  }
  return summary;
}

}  // namespace

std::vector<int> ReadOptions::view_numbers() const {
  std::vector<int> numbers;
  for (const char *at = views.data(), *end = at + views.size(); at < end;) {
    int number = 0;
    const auto [after, error] = std::from_chars(at, end, number);
    const bool is_last = after == end;
    if (error != std::errc() || number < 1 || (!is_last && (*after != ',' || after + 1 == end)))
      throw OptionError("input.views: must be numbers of views, as 1,3 (see `angio inspect`)");
    if (std::find(numbers.begin(), numbers.end(), number) == numbers.end())
      numbers.push_back(number);
    at = is_last ? end : after + 1;
  }
  if (numbers.size() == 1)
    throw OptionError("input.views: one view tells no depth. Name two or more, as 1,3");
  return numbers;
}

bool is_volume_file(const fs::path& path) {
  return detail::is_volume_file_name(path) && !fs::is_directory(path);
}

bool holds_dicom(const fs::path& folder, const ReadOptions& options) {
  return !detail::find_series(folder, options).all.empty();
}

void ReadOptions::validate() const {
  (void)view_numbers();
  const bool none = spacing_mm == std::array<double, 3>{0.0, 0.0, 0.0};
  for (const double spacing : spacing_mm)
    if (!none && !(spacing > 1e-4 && spacing < 100.0))
      throw OptionError(
          "input.spacing_mm: each of the three must be above 0.0001 and below 100 mm");
  if (!(max_memory_gib >= 0.0 && max_memory_gib <= 65536.0))
    throw OptionError("input.max_memory_gib: must be in [0, 65536]; 0 is what the computer has");
}

LoadedVolume read_volume(const fs::path& path, const ReadOptions& options,
                         const Progress& progress) {
  options.validate();
  check_exists(path);
  LoadedVolume loaded;
  if (is_volume_file(path)) {
    auto file = detail::load_volume_file(path, detail::VolumePart::whole, options);
    detail::bring_to_mm(file, path, unit_of(options));
    loaded = {std::move(file.volume), detail::volume_file_format(path) + " file",
              std::move(file.warnings)};
  } else {
    if (options.unit && *options.unit != LengthUnit::mm)
      throw OptionError(
          "input.unit is of a surface or a volume file; DICOM is in mm. Leave it out");
    loaded = read_dicom(path, options, progress);
  }
  replace_non_finite(loaded);
  progress.report(1.0, "volume read");
  return loaded;
}

std::vector<SeriesSummary> inspect(const fs::path& path, const ReadOptions& options) {
  options.validate();
  check_exists(path);
  std::vector<SeriesSummary> summaries;
  if (!is_volume_file(path))
    for (const auto& series : detail::find_series(path, options).all)
      summaries.push_back(summarize(series, options));
  for (const auto& file : volume_files_in(path)) summaries.push_back(summarize(file, options));
  if (summaries.empty()) fail_without_dicom(path);
  return summaries;
}

Volume<float> read_volume_file(const fs::path& path) {
  check_exists(path);
  return detail::load_volume_file(path, detail::VolumePart::whole, {}).volume;
}

}  // namespace angio::segmentation
