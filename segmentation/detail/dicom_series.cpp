#include "segmentation/detail/dicom_series.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <system_error>

#include "core/error.hpp"

namespace angio::segmentation::detail {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMaxVoxelCount = std::size_t(1) << 31;

/// The first 8 hexadecimal digits of SHA-256: names a series without giving its UID away.
std::string short_hash(const std::string& text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  EVP_Digest(text.data(), text.size(), digest.data(), &length, EVP_sha256(), nullptr);
  std::string hash;
  for (std::size_t i = 0; i < 4; ++i) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x", unsigned(digest[i]));
    hash += digits;
  }
  return hash;
}

std::vector<fs::path> list_files(const fs::path& path) {
  if (fs::is_regular_file(path)) return {path};
  std::vector<fs::path> files;
  std::error_code error;
  auto entry =
      fs::recursive_directory_iterator(path, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code ignored;
    if (entry->is_regular_file(ignored)) files.push_back(entry->path());
  }
  if (error)
    throw IoError("cannot read the folder " + path.string() + " (" + error.message() + ")");
  std::sort(files.begin(), files.end());  // the order of a folder is the file system's whim
  return files;
}

std::vector<DicomHeader> read_headers(const std::vector<fs::path>& files,
                                      const Progress& progress) {
  std::vector<DicomHeader> headers;
  for (std::size_t f = 0; f < files.size(); ++f) {
    if (f % 16 == 0) progress.report(0.5 * double(f) / double(files.size()), "reading headers");
    if (auto header = read_dicom_header(files[f])) headers.push_back(std::move(*header));
  }
  return headers;
}

/// Objects of one stack share this. A multi-frame object is a stack by itself.
std::string stack_key(const DicomHeader& header) {
  std::string key = header.series_uid + "|" + header.sop_class_uid + "|" +
                    std::to_string(header.columns) + "x" + std::to_string(header.rows);
  if (header.multi_frame_object)
    return key.append("|").append(header.instance_uid).append(header.path.string());
  if (header.frames.empty() || !header.frames.front().has_orientation) return key;
  // Localisers share the series now and then but not the orientation: 0.01 tells them apart.
  const DicomFrame& frame = header.frames.front();
  for (const Vec3& axis : {frame.axis_i, frame.axis_j})
    for (int c = 0; c < 3; ++c)
      key.append("|").append(
          std::to_string(int(std::lround(std::clamp(axis[c], -2.0, 2.0) * 50.0))));
  return key;
}

/// Damaged objects join the stack of their series, so that a hole cannot go unseen.
std::map<std::string, DicomSeries> group_by_stack(std::vector<DicomHeader> headers,
                                                  std::vector<std::string>& warnings) {
  std::map<std::string, DicomSeries> stacks;
  std::vector<DicomHeader> damaged;
  for (auto& header : headers) {
    if (header.rows == 0 && !header.problem.empty()) {
      damaged.push_back(std::move(header));
    } else {
      auto key = stack_key(header);
      stacks[std::move(key)].headers.push_back(std::move(header));
    }
  }
  for (auto& header : damaged) {
    bool placed = false;
    for (auto& [key, stack] : stacks) {
      if (header.series_uid.empty() || stack.headers.front().series_uid != header.series_uid)
        continue;
      stack.headers.push_back(header);
      placed = true;
    }
    if (placed) continue;
    if (!header.series_uid.empty() || stacks.empty())
      stacks[header.series_uid + "|damaged"].headers.push_back(std::move(header));
    else
      warnings.push_back("a file of no known series was left out: " + header.problem);
  }
  return stacks;
}

std::string refusal_by_kind(const DicomHeader& header) {
  switch (header.kind) {
    case DicomKind::projection:
      return "it is a projection run (" + header.sop_class_name +
             "), not a volume: its third axis is time. Give the reconstructed 3D series";
    case DicomKind::unsupported:
      return "its kind (" + header.sop_class_name +
             ") is not a volume of intensities. Give a CT, MR or X-Ray 3D series";
    case DicomKind::capture:
      if (std::any_of(header.frames.begin(), header.frames.end(), [](const DicomFrame& f) {
            return !f.has_position || !f.has_orientation || !f.has_spacing;
          }))
        return "it is a secondary capture without geometry (a picture in which no length can be "
               "measured). Export the original series";
      return {};
    case DicomKind::volume:
      return {};
  }
  return {};
}

std::string refusal_by_objects(const DicomSeries& series) {
  const DicomHeader& first = series.headers.front();
  for (std::size_t h = 0; h < series.headers.size(); ++h) {
    const DicomHeader& header = series.headers[h];
    // File names may hold a patient's name, so a file is told by its place.
    if (!header.problem.empty())
      return "in file " + std::to_string(h + 1) + " of " + std::to_string(series.headers.size()) +
             " by name, " + header.problem;
    if (header.is_signed != first.is_signed || header.bits_allocated != first.bits_allocated ||
        header.is_monochrome1 != first.is_monochrome1)
      return "its slices have different pixel formats (two series may be mixed). Export it again";
  }
  if (series.pixel_count() > kMaxVoxelCount)
    return "it has more than 2^31 voxels (too many for this program). Crop it first";
  return {};
}

void judge(DicomSeries& series) {
  std::sort(series.headers.begin(), series.headers.end(),
            [](const DicomHeader& a, const DicomHeader& b) { return a.path < b.path; });
  const DicomHeader& first = series.headers.front();
  series.is_volume_kind = first.kind == DicomKind::volume || first.kind == DicomKind::capture;
  series.verdict = refusal_by_kind(first);
  if (!series.verdict.empty()) {
    series.is_volume_kind = false;
    return;
  }
  series.verdict = refusal_by_objects(series);
  if (!series.verdict.empty()) return;

  std::vector<DicomFrame> frames;
  std::vector<SliceReference> references;
  for (std::size_t h = 0; h < series.headers.size(); ++h)
    for (std::size_t f = 0; f < series.headers[h].frames.size(); ++f) {
      frames.push_back(series.headers[h].frames[f]);
      references.push_back({int(h), int(f)});
    }
  StackGeometry stack = stack_geometry(frames, first.columns, first.rows);
  series.verdict = stack.problem.empty() ? "regular grid" : stack.problem;
  series.usable = stack.problem.empty();
  if (!series.usable) return;
  series.geometry = stack.geometry;
  series.warnings = stack.warnings;
  for (int f : stack.order) series.slices.push_back(references[std::size_t(f)]);
  if (first.kind == DicomKind::capture)
    series.warnings.push_back("the series is a secondary capture: its intensities may be edited");
  if (first.is_monochrome1)
    series.warnings.push_back("the pixels are MONOCHROME1 (bright is low); they were inverted");
  if (first.has_modality_lut)
    series.warnings.push_back("the modality look-up table was not applied");
}

}  // namespace

std::size_t DicomSeries::pixel_count() const {
  std::size_t count = 0;
  for (const auto& header : headers)
    count += std::size_t(header.rows) * std::size_t(header.columns) * header.frames.size();
  return count;
}

std::vector<DicomSeries> find_series(const fs::path& path, std::vector<std::string>& warnings,
                                     const Progress& progress) {
  auto stacks = group_by_stack(read_headers(list_files(path), progress), warnings);
  std::vector<DicomSeries> found;
  for (auto& [key, series] : stacks) {
    judge(series);
    found.push_back(std::move(series));
  }
  std::stable_sort(found.begin(), found.end(), [](const DicomSeries& a, const DicomSeries& b) {
    return a.pixel_count() > b.pixel_count();
  });
  std::map<std::string, int> seen;
  for (auto& series : found) {
    const std::string hash = short_hash(series.headers.front().series_uid);
    const int number = ++seen[hash];
    series.key = number == 1 ? hash : hash + "-" + std::to_string(number);
  }
  return found;
}

}  // namespace angio::segmentation::detail
