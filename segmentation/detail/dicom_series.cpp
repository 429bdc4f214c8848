#include "segmentation/detail/dicom_series.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include "core/error.hpp"
#include "segmentation/detail/dicom_repeats.hpp"
#include "segmentation/detail/format_number.hpp"
#include "segmentation/detail/given_spacing.hpp"
#include "segmentation/detail/projection_angles.hpp"
#include "segmentation/detail/rotational_run.hpp"

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

/// Objects whose frames may form one stack share this. A multi-frame object is a stack by itself,
/// or with the other parts of its concatenation.
std::string object_key(const DicomHeader& header) {
  std::string key = header.series_uid + "|" + header.sop_class_uid + "|" +
                    std::to_string(header.pixels.columns) + "x" +
                    std::to_string(header.pixels.rows);
  if (!header.multi_frame_object) return key;
  if (!header.concatenation_uid.empty()) return key + "|" + header.concatenation_uid;
  if (!header.instance_uid.empty()) return key + "|" + header.instance_uid;
  return key + "|" + header.source.path.string() + "|" + std::to_string(header.source.entry);
}

/// Localisers share the series now and then but not the orientation: 0.01 tells them apart.
std::string orientation_key(const DicomFrame& frame) {
  std::string key;
  if (!frame.has_orientation) return key;
  for (const Vec3& axis : {frame.axis_i, frame.axis_j})
    for (int c = 0; c < 3; ++c)
      key.append("|").append(
          std::to_string(int(std::lround(std::clamp(axis[c], -2.0, 2.0) * 50.0))));
  return key;
}

bool is_damaged(const DicomHeader& header) {
  return header.pixels.rows == 0 && !header.problem.empty();
}

void add_header(DicomSeries& series, const DicomHeader& header, const std::vector<int>& frames) {
  series.headers.push_back(header);
  for (int f : frames) series.members.push_back({int(series.headers.size()) - 1, f});
}

/// Damaged objects join every stack of their series, so that a hole cannot go unseen.
void add_damaged(const DicomHeader& header, std::map<std::string, DicomSeries>& stacks,
                 std::vector<std::string>& warnings) {
  bool placed = false;
  for (auto& [key, stack] : stacks) {
    if (header.series_uid.empty() || stack.headers.front().series_uid != header.series_uid)
      continue;
    add_header(stack, header, {});
    placed = true;
  }
  if (placed) return;
  if (!header.series_uid.empty() || stacks.empty())
    add_header(stacks[header.series_uid + "|damaged"], header, {});
  else
    warnings.push_back("a file of no known series was left out: " + header.problem);
}

std::vector<DicomSeries> group_by_stack(const std::vector<DicomHeader>& headers,
                                        std::vector<std::string>& warnings) {
  std::map<std::string, DicomSeries> stacks;
  for (const auto& header : headers) {
    if (is_damaged(header)) continue;
    std::map<std::string, std::vector<int>> frames;
    for (std::size_t f = 0; f < header.frames.size(); ++f)
      frames[orientation_key(header.frames[f])].push_back(int(f));
    const std::string key = object_key(header);
    if (frames.empty()) frames[""] = {};  // an object that could not be understood
    for (const auto& [orientation, members] : frames)
      add_header(stacks[key + orientation], header, members);
  }
  for (const auto& header : headers)
    if (is_damaged(header)) add_damaged(header, stacks, warnings);
  std::vector<DicomSeries> found;
  for (auto& [key, series] : stacks) found.push_back(std::move(series));
  return found;
}

/// Of a run that turns: it is no volume, but one may be made of it.
std::string refusal_of_run(const DicomHeader& header, const ReadOptions& options) {
  ProjectionRun run = *header.projection;
  settle_angles(run, int(header.frames.size()), options.angles);
  const std::string why = refusal_of_turn(header, run);
  return why.empty() ? "it is a rotational run, no volume: `angio run` makes one of it" : why;
}

std::string refusal_by_kind(const DicomHeader& header, const ReadOptions& options) {
  switch (header.kind) {
    case DicomKind::projection:
      if (is_damaged(header)) return header.problem;
      if (header.frames.size() < 2)
        return "it is a projection (" + header.sop_class_name +
               "), not a volume: one picture holds no third axis. Give the 3D reconstruction that "
               "the workstation made (a CT or X-Ray 3D Angiographic series)";
      if (header.projection && turns(*header.projection)) return refusal_of_run(header, options);
      return "it is a projection run (" + header.sop_class_name +
             "), not a volume: its third axis is time, not a length, and it does not say "
             "that it turns (the increments of its angles are missing, all alike, or no numbers). "
             "Give a rotational run, its geometry with --geometry, two or more such runs of the "
             "same "
             "vessel from sides 30 degrees apart in one folder, or the 3D reconstruction that the "
             "workstation made of it (a CT or X-Ray 3D Angiographic series); `angio "
             "inspect` shows the run's angles and distances";
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
    if (header.pixels.is_signed != first.pixels.is_signed ||
        header.pixels.bits_allocated != first.pixels.bits_allocated ||
        header.pixels.is_monochrome1 != first.pixels.is_monochrome1)
      return "its slices have different pixel formats (two series may be mixed). Export it again";
  }
  if (series.pixel_count() > kMaxVoxelCount)
    return "it has more than 2^31 voxels (too many for this program). Crop it first";
  return {};
}

std::string verdict_on(const StackGeometry& stack) {
  if (!stack.problem.empty()) return stack.problem;
  if (stack.places.empty()) return "regular grid";
  return stack.tilt_degrees > 0.0 && stack.even_heights
             ? "tilted by " + format_number(stack.tilt_degrees) +
                   " degrees; resampled onto an upright grid"
             : "no regular grid; resampled onto one";
}

void warn_of_pixels(DicomSeries& series) {
  const DicomHeader& first = series.headers.front();
  const auto any = [&](const auto& has) {
    return std::any_of(series.headers.begin(), series.headers.end(), has);
  };
  if (first.kind == DicomKind::capture)
    series.warnings.push_back("the series is a secondary capture: its intensities may be edited");
  if (first.pixels.is_monochrome1)
    series.warnings.push_back("the pixels are MONOCHROME1 (bright is low); they were inverted");
  if (any([](const DicomHeader& header) { return header.pixels.has_modality_lut; }))
    series.warnings.push_back("the modality look-up table was not applied");
  if (any([](const DicomHeader& header) { return header.burned_in; }))
    series.warnings.push_back(
        "text is burned into the pixels (it may be taken for a vessel, and may name the patient)");
}

/// Whether the members form a volume, and where they lie.
void judge_stack(DicomSeries& series, const ReadOptions& options) {
  series.verdict = refusal_by_objects(series);
  if (!series.verdict.empty()) return;
  std::vector<DicomFrame> frames;
  for (const auto& member : series.members) frames.push_back(series.frame(member));
  const DicomHeader& first = series.headers.front();
  series.stack = stack_geometry(frames, first.pixels.columns, first.pixels.rows,
                                options.resample ? UnevenSlices::resample : UnevenSlices::refuse);
  if (series.stack.problem.empty())
    series.stack.problem = contradiction(series.stack.geometry, options);
  series.verdict = verdict_on(series.stack);
  series.usable = series.stack.problem.empty();
  if (!series.usable) return;
  for (int f : series.stack.order) series.slices.push_back(series.members[std::size_t(f)]);
  series.warnings.insert(series.warnings.end(), series.stack.warnings.begin(),
                         series.stack.warnings.end());
  warn_of_pixels(series);
}

/// The volumes that a stack of objects holds: usually itself.
std::vector<DicomSeries> judge(DicomSeries series, const ReadOptions& options) {
  std::sort(series.headers.begin(), series.headers.end(), [](const auto& a, const auto& b) {
    return std::tie(a.source.path, a.source.entry) < std::tie(b.source.path, b.source.entry);
  });
  const DicomHeader& first = series.headers.front();
  const bool is_slice_alone = series.headers.size() == 1 && series.members.size() == 1;
  series.is_volume_kind =
      !is_slice_alone && (first.kind == DicomKind::volume || first.kind == DicomKind::capture);
  series.verdict = give_spacing(series, options);
  if (series.verdict.empty()) series.verdict = refusal_by_kind(first, options);
  if (!series.verdict.empty()) {
    series.is_volume_kind = series.is_volume_kind && first.kind == DicomKind::volume;
    return {std::move(series)};
  }
  if (refusal_by_objects(series).empty()) {
    std::vector<DicomSeries> parts = settle_repeats(std::move(series));
    for (auto& part : parts) judge_stack(part, options);
    return parts;
  }
  judge_stack(series, options);
  return {std::move(series)};
}

std::size_t find_wanted(const std::vector<DicomSeries>& all, const std::string& wanted) {
  for (std::size_t s = 0; s < all.size(); ++s)
    if (all[s].key == wanted || std::to_string(s + 1) == wanted) return s;
  std::string known;
  for (std::size_t s = 0; s < all.size(); ++s)
    known += (s > 0 ? ", " : "") + std::to_string(s + 1) + " (" + all[s].key + ")";
  throw InputError("there is no series \"" + wanted + "\". Choose one of " + known);
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
  if (series.lossy() && !options.allow_lossy)
    throw InputError(describe(series, chosen) +
                     " was compressed with loss (edges may have moved, and so would every "
                     "diameter). Export it without loss, or measure all the same with "
                     "--allow-lossy");
}

}  // namespace

std::size_t DicomSeries::pixel_count() const {
  std::size_t count = 0;
  for (const auto& member : members)
    count += headers[std::size_t(member.header)].pixels.per_frame();
  return count;
}

bool DicomSeries::lossy() const {
  return std::any_of(headers.begin(), headers.end(),
                     [](const DicomHeader& header) { return header.lossy; });
}

FoundSeries find_series(const fs::path& path, const ReadOptions& options,
                        const Progress& progress) {
  FoundSeries found;
  DicomInput input = list_dicom_input(path);
  found.warnings = std::move(input.warnings);
  for (auto& stack : group_by_stack(read_dicom_headers(input.files, progress), found.warnings))
    for (auto& series : judge(std::move(stack), options)) found.all.push_back(std::move(series));
  std::stable_sort(
      found.all.begin(), found.all.end(),
      [](const DicomSeries& a, const DicomSeries& b) { return a.pixel_count() > b.pixel_count(); });
  std::map<std::string, int> seen;
  for (auto& series : found.all) {
    const std::string hash = short_hash(series.headers.front().series_uid);
    const int number = ++seen[hash];
    series.key = number == 1 ? hash : hash + "-" + std::to_string(number);
  }
  return found;
}

std::size_t choose_series(const std::vector<DicomSeries>& all, const ReadOptions& options) {
  std::size_t chosen = 0;
  if (!options.series.empty()) {
    chosen = find_wanted(all, options.series);
  } else {
    const auto first = std::find_if(
        all.begin(), all.end(), [](const DicomSeries& series) { return series.is_volume_kind; });
    if (first != all.end()) chosen = std::size_t(first - all.begin());
  }
  check_usable(all, chosen, options);
  return chosen;
}

std::string describe(const DicomSeries& series, std::size_t index) {
  return "series " + std::to_string(index + 1) + " (" + series.key + ", " +
         series.headers.front().sop_class_name + ", " + std::to_string(series.headers.size()) +
         (series.headers.size() == 1 ? " file" : " files") + ")";
}

}  // namespace angio::segmentation::detail
