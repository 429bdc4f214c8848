#include "segmentation/read_volume.hpp"

#include <algorithm>
#include <cmath>
#include <system_error>

#include "core/error.hpp"
#include "segmentation/detail/dicom_pixels.hpp"
#include "segmentation/detail/dicom_series.hpp"
#include "segmentation/detail/volume_file.hpp"

namespace angio::segmentation {
namespace fs = std::filesystem;
using detail::DicomSeries;
namespace {

void check_exists(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error))
    throw InputError("there is no " + path.string() + ". Check the path", ExitCode::no_input);
  if (fs::is_directory(path, error) ? fs::is_empty(path, error)
                                    : fs::file_size(path, error) == 0 && !error)
    throw InputError(path.string() + " is empty. Give a DICOM folder or a volume file");
}

/// A DICOMDIR stands for the folder that it lies in.
fs::path dicom_root(const fs::path& path) {
  if (path.filename() == "DICOMDIR" && fs::is_regular_file(path))
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
  return path;
}

std::vector<fs::path> volume_files_in(const fs::path& path) {
  if (detail::is_volume_file_name(path) && fs::is_regular_file(path)) return {path};
  std::vector<fs::path> files;
  if (fs::is_directory(path))
    for (const auto& entry : fs::directory_iterator(path))
      if (entry.is_regular_file() && detail::is_volume_file_name(entry.path()))
        files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

[[noreturn]] void fail_without_dicom(const fs::path& path) {
  if (!fs::is_directory(path))
    throw InputError(path.filename().string() +
                     " is neither DICOM nor a volume file (.nrrd .nhdr .mha .mhd .nii .nii.gz "
                     ".vti). Give one of these");
  const auto files = volume_files_in(path);
  if (!files.empty())
    throw InputError("the folder " + path.string() + " holds no DICOM, but " +
                     files.front().filename().string() + ". Give that file");
  throw InputError("the folder " + path.string() + " holds no DICOM. Give the folder of a series");
}

std::string describe(const DicomSeries& series, std::size_t number) {
  const auto& first = series.headers.front();
  return "series " + std::to_string(number + 1) + " (" + series.key + ", " + first.sop_class_name +
         ", " + std::to_string(series.headers.size()) +
         (series.headers.size() == 1 ? " file" : " files") + ")";
}

std::size_t find_wanted(const std::vector<DicomSeries>& all, const std::string& wanted) {
  for (std::size_t s = 0; s < all.size(); ++s)
    if (all[s].key == wanted || std::to_string(s + 1) == wanted) return s;
  std::string known;
  for (std::size_t s = 0; s < all.size(); ++s)
    known += (s > 0 ? ", " : "") + std::to_string(s + 1) + " (" + all[s].key + ")";
  throw InputError("there is no series \"" + wanted + "\". Choose one of " + known);
}

/// By rule: the largest of a kind that could be a volume, even if it is then refused; a smaller
/// one must not stand in for it unasked.
std::size_t choose(const std::vector<DicomSeries>& all, const ReadOptions& options) {
  if (!options.series.empty()) return find_wanted(all, options.series);
  for (std::size_t s = 0; s < all.size(); ++s)
    if (all[s].is_volume_kind) return s;
  return 0;
}

void check_usable(const std::vector<DicomSeries>& all, std::size_t chosen,
                  const ReadOptions& options) {
  const DicomSeries& series = all[chosen];
  if (!series.usable) {
    std::string other;
    for (std::size_t s = 0; s < all.size() && other.empty(); ++s)
      if (all[s].usable) other = ". Or choose " + describe(all[s], s) + " with --series";
    throw InputError(describe(series, chosen) + " cannot be used: " + series.verdict + other);
  }
  const bool lossy = std::any_of(series.headers.begin(), series.headers.end(),
                                 [](const auto& header) { return header.lossy; });
  if (lossy && !options.allow_lossy)
    throw InputError(describe(series, chosen) +
                     " was compressed with loss (edges may have moved, and so would every "
                     "diameter). Export it without loss, or measure all the same with "
                     "--allow-lossy");
}

void warn_of_others(const std::vector<DicomSeries>& all, std::size_t chosen,
                    std::vector<std::string>& warnings) {
  for (std::size_t s = 0; s < all.size(); ++s)
    if (s != chosen)
      warnings.push_back(
          describe(all[s], s) + " was left out: " +
          (all[s].usable ? "it has fewer voxels, or another was asked for" : all[s].verdict));
}

LoadedVolume read_dicom(const fs::path& path, const ReadOptions& options,
                        const Progress& progress) {
  LoadedVolume loaded;
  const auto all = detail::find_series(dicom_root(path), loaded.warnings, progress);
  if (all.empty()) fail_without_dicom(path);
  const std::size_t chosen = choose(all, options);
  check_usable(all, chosen, options);
  const DicomSeries& series = all[chosen];
  warn_of_others(all, chosen, loaded.warnings);
  loaded.warnings.insert(loaded.warnings.end(), series.warnings.begin(), series.warnings.end());
  loaded.volume.geometry = series.geometry;
  loaded.volume.values = detail::decode_series(series, progress);
  loaded.source_description = series.headers.front().sop_class_name + ", " +
                              std::to_string(series.slices.size()) + " slices";
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

SeriesSummary summarize(const DicomSeries& series) {
  const auto& first = series.headers.front();
  SeriesSummary summary;
  summary.key = series.key;
  summary.kind = first.sop_class_name;
  summary.transfer_syntax = first.transfer_syntax_name;
  summary.geometry = series.geometry;
  summary.file_count = int(series.headers.size());
  for (const auto& header : series.headers) {
    summary.frame_count += int(header.frames.size());
    if (header.lossy && series.usable)
      summary.verdict = "regular grid, but compressed with loss; needs --allow-lossy";
  }
  summary.usable = series.usable;
  if (summary.verdict.empty()) summary.verdict = series.verdict;
  return summary;
}

SeriesSummary summarize(const fs::path& path) {
  SeriesSummary summary;
  summary.key = detail::volume_file_format(path);
  summary.kind = "volume file";
  summary.transfer_syntax = "none";
  summary.file_count = 1;
  try {
    const auto file = detail::load_volume_file(path, detail::VolumePart::header);
    summary.geometry = file.volume.geometry;
    summary.frame_count = summary.geometry.size[2];
    summary.usable = true;
    summary.verdict = "regular grid";
  } catch (const InputError& error) {
    summary.verdict = error.what();
  }
  return summary;
}

}  // namespace

LoadedVolume read_volume(const fs::path& path, const ReadOptions& options,
                         const Progress& progress) {
  check_exists(path);
  LoadedVolume loaded;
  if (detail::is_volume_file_name(path) && !fs::is_directory(path)) {
    auto file = detail::load_volume_file(path, detail::VolumePart::whole);
    loaded = {std::move(file.volume), detail::volume_file_format(path) + " file",
              std::move(file.warnings)};
  } else {
    loaded = read_dicom(path, options, progress);
  }
  replace_non_finite(loaded);
  progress.report(1.0, "volume read");
  return loaded;
}

std::vector<SeriesSummary> inspect(const fs::path& path) {
  check_exists(path);
  std::vector<SeriesSummary> summaries;
  const bool one_volume_file = detail::is_volume_file_name(path) && !fs::is_directory(path);
  if (!one_volume_file) {
    std::vector<std::string> ignored;
    for (const auto& series : detail::find_series(dicom_root(path), ignored))
      summaries.push_back(summarize(series));
  }
  for (const auto& file : volume_files_in(path)) summaries.push_back(summarize(file));
  if (summaries.empty()) fail_without_dicom(path);
  return summaries;
}

Volume<float> read_volume_file(const fs::path& path) {
  check_exists(path);
  return detail::load_volume_file(path, detail::VolumePart::whole).volume;
}

}  // namespace angio::segmentation
