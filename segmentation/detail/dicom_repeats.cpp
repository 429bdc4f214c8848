#include "segmentation/detail/dicom_repeats.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "core/error.hpp"
#include "segmentation/detail/dicom_pixels.hpp"

namespace angio::segmentation::detail {
namespace {

std::vector<DicomFrame> frames_of(const DicomSeries& series,
                                  const std::vector<SliceReference>& members) {
  std::vector<DicomFrame> frames;
  for (const auto& member : members) frames.push_back(series.frame(member));
  return frames;
}

/// The members by their value of a phase, if that leaves no place twice and every part is a stack
/// of its own: at least half as long as the longest, so that two slabs do not pass for two phases.
std::vector<std::vector<SliceReference>> split_by(const DicomSeries& series, int phase) {
  std::map<double, std::vector<SliceReference>> parts;
  for (const auto& member : series.members)
    parts[series.frame(member).phase[std::size_t(phase)]].push_back(member);
  if (parts.size() < 2) return {};
  std::size_t longest = 0;
  for (const auto& [value, members] : parts) longest = std::max(longest, members.size());
  std::vector<std::vector<SliceReference>> split;
  for (const auto& [value, members] : parts) {
    if (members.size() < 2 || 2 * members.size() < longest ||
        !repeated_places(frames_of(series, members)).empty())
      return {};
    split.push_back(members);
  }
  return split;
}

/// A series with some of another's members, and the headers these need.
DicomSeries part_of(const DicomSeries& series, const std::vector<SliceReference>& members) {
  DicomSeries part;
  part.is_volume_kind = series.is_volume_kind;
  part.warnings = series.warnings;
  std::map<int, int> new_index;
  for (const auto& member : members) {
    const auto [place, is_new] = new_index.insert({member.header, int(part.headers.size())});
    if (is_new) part.headers.push_back(series.headers[std::size_t(member.header)]);
    part.members.push_back({place->second, member.frame});
  }
  return part;
}

/// The members without those whose pixels and rescale another one at the same place has, too.
std::vector<SliceReference> without_copies(const DicomSeries& series,
                                           const std::vector<std::vector<int>>& groups) {
  std::vector<SliceReference> members;  // of all groups: one child reads them, each file once
  for (const auto& group : groups)
    for (int m : group) members.push_back(series.members[std::size_t(m)]);
  const auto hashes = hash_frames(series.headers, members);
  std::set<int> copies;
  std::size_t head = 0;
  for (const auto& group : groups) {
    const DicomFrame& first = series.frame(members[head]);
    for (std::size_t m = 1; m < group.size(); ++m) {
      const DicomFrame& other = series.frame(members[head + m]);
      if (hashes[head + m] == hashes[head] && first.slope == other.slope &&
          first.intercept == other.intercept)
        copies.insert(group[m]);
    }
    head += group.size();
  }
  std::vector<SliceReference> kept;
  for (std::size_t m = 0; m < series.members.size(); ++m)
    if (!copies.contains(int(m))) kept.push_back(series.members[m]);
  return kept;
}

}  // namespace

std::vector<DicomSeries> settle_repeats(DicomSeries series) {
  const auto groups = repeated_places(frames_of(series, series.members));
  if (groups.empty()) return {std::move(series)};
  for (int phase = 0; phase < kPhaseCount; ++phase) {
    const auto split = split_by(series, phase);
    if (split.empty()) continue;
    std::vector<DicomSeries> parts;
    for (const auto& members : split) {
      parts.push_back(part_of(series, members));
      parts.back().warnings.push_back("this is phase " + std::to_string(parts.size()) + " of " +
                                      std::to_string(split.size()) +
                                      " at the same places, each listed as a series of its own");
    }
    return parts;
  }
  try {
    const auto kept = without_copies(series, groups);
    const std::size_t copy_count = series.members.size() - kept.size();
    if (copy_count > 0 && repeated_places(frames_of(series, kept)).empty()) {
      DicomSeries part = part_of(series, kept);
      part.warnings.push_back(
          std::to_string(copy_count) +
          (copy_count == 1 ? " slice is a copy of another" : " slices are copies of others") +
          " at the same place; left out");
      return {std::move(part)};
    }
  } catch (const InputError&) {  // pixels that cannot be read are no copies
  }
  return {std::move(series)};
}

}  // namespace angio::segmentation::detail
