#include "segmentation/detail/given_spacing.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "segmentation/detail/format_number.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kSameSpacing = 0.01;  ///< relative

std::string in_words(double i, double j, double k) {
  return format_number(i) + " x " + format_number(j) + " x " + format_number(k) + " mm";
}

/// Which slice a member is, counted from 0, by the numbers in the files.
std::vector<int> slice_numbers(const DicomSeries& series) {
  std::vector<int> numbers;
  for (const auto& member : series.members) {
    const DicomHeader& header = series.headers[std::size_t(member.header)];
    numbers.push_back(header.multi_frame_object ? member.frame : header.instance_number);
  }
  const int least = numbers.empty() ? 0 : *std::min_element(numbers.begin(), numbers.end());
  for (int& number : numbers) number -= least;
  return numbers;
}

/// Positions by number, for frames that state none.
std::string give_positions(DicomSeries& series, double step) {
  const std::vector<int> numbers = slice_numbers(series);
  const std::set<int> different(numbers.begin(), numbers.end());
  if (different.size() != numbers.size() || *different.rbegin() != int(numbers.size()) - 1)
    return "the image position is missing, and the slices are not numbered one after another "
           "(their order and number are not known, even with --spacing). Export the series with "
           "its geometry";
  for (std::size_t m = 0; m < series.members.size(); ++m) {
    const auto [h, f] = series.members[m];
    DicomFrame& frame = series.headers[std::size_t(h)].frames[std::size_t(f)];
    const Vec3 normal = cross(frame.axis_i, frame.axis_j);
    frame.position = (step * numbers[m]) * normal;
    frame.has_position = true;
  }
  return {};
}

}  // namespace

bool has_given_spacing(const ReadOptions& options) { return options.spacing_mm[0] > 0.0; }

std::string give_spacing(DicomSeries& series, const ReadOptions& options) {
  const DicomKind kind = series.headers.front().kind;
  const bool may_be_volume = kind == DicomKind::volume || kind == DicomKind::capture;
  if (!has_given_spacing(options) || !may_be_volume || series.members.empty()) return {};
  std::size_t without_position = 0;
  std::size_t incomplete = 0;
  for (const auto& [h, f] : series.members) {
    DicomFrame& frame = series.headers[std::size_t(h)].frames[std::size_t(f)];
    if (!frame.has_position) ++without_position;
    if (!frame.has_position || !frame.has_orientation || !frame.has_spacing) ++incomplete;
    if (!frame.has_orientation) {
      frame.axis_i = {1, 0, 0};
      frame.axis_j = {0, 1, 0};
      frame.has_orientation = true;
    }
    if (!frame.has_spacing) {
      frame.spacing_i = options.spacing_mm[0];
      frame.spacing_j = options.spacing_mm[1];
      frame.has_spacing = true;
    }
  }
  if (incomplete == 0) return {};
  if (without_position > 0 && without_position < series.members.size())
    return "the image position is missing in some slices only (the series is damaged). Export it "
           "again";
  series.warnings.push_back(
      "the series does not state its whole geometry; voxels of " +
      in_words(options.spacing_mm[0], options.spacing_mm[1], options.spacing_mm[2]) +
      " were taken as you gave them, and every length rests on that");
  return without_position > 0 ? give_positions(series, options.spacing_mm[2]) : std::string();
}

std::string contradiction(const VolumeGeometry& geometry, const ReadOptions& options) {
  if (!has_given_spacing(options)) return {};
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(geometry.spacing[axis] - options.spacing_mm[std::size_t(axis)]) >
        kSameSpacing * geometry.spacing[axis])
      return "it states voxels of " +
             in_words(geometry.spacing.x, geometry.spacing.y, geometry.spacing.z) +
             ", not the ones given with --spacing. Leave --spacing out";
  return {};
}

}  // namespace angio::segmentation::detail
