#include "segmentation/detail/label_lumen.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "segmentation/detail/boundary.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/format_number.hpp"
#include "segmentation/detail/plausibility.hpp"
#include "segmentation/detail/seeds.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kMarginMm = 5.0;
constexpr double kToldDifference = 0.01;  ///< of the volume
constexpr double kTreeOfItsOwn = 0.05;    ///< of the largest piece

/// "1 (3.2 ml), 2 (0.4 ml), ..."
std::string list_of(const std::vector<Label>& labels, const VolumeGeometry& grid) {
  constexpr std::size_t kMost = 8;
  std::string text;
  for (std::size_t n = 0; n < labels.size() && n < kMost; ++n)
    text += (n > 0 ? ", " : "") + format_number(labels[n].value) + " (" +
            format_number(double(labels[n].voxel_count) * voxel_volume(grid) / 1000.0) + " ml)";
  return text + (labels.size() > kMost ? ", ..." : "");
}

/// What was taken, for people.
std::string note_of(const std::vector<Label>& labels, const SegmentationOptions& options,
                    const VolumeGeometry& grid) {
  std::string note = "the volume is a label map, no image: its lumen is that of label ";
  if (!options.labels.empty()) {
    for (std::size_t n = 0; n < options.labels.size(); ++n)
      note += (n > 0 ? ", " : "") + format_number(options.labels[n]);
    return note + " of " + list_of(labels, grid);
  }
  note += list_of(labels, grid);
  return labels.size() < 2 ? note
                           : note + ", all of them in one; segmentation.labels takes only some";
}

/// Whether a label holds more than all blood that a scan could show: a body, a liver, a lung.
bool is_no_vessel(const Label& label, const VolumeGeometry& grid) {
  return double(label.voxel_count) * voxel_volume(grid) > kMostBlood;
}

/// Nobody has said which labels are wanted: what cannot be blood is left out.
/// @throws InputError if the others cannot be, either
std::vector<Label> plausible_labels(const std::vector<Label>& labels, const VolumeGeometry& grid,
                                    std::vector<std::string>& warnings) {
  std::vector<Label> kept, left_out;
  for (const Label& label : labels) (is_no_vessel(label, grid) ? left_out : kept).push_back(label);
  double sum = 0.0;
  for (const Label& label : kept) sum += double(label.voxel_count) * voxel_volume(grid);
  if (kept.empty() || sum > kMostBlood)
    throw InputError(
        "the labels hold more than heart, lungs and all arteries do (about 1.5 l): they are those "
        "of organs, or of a whole body. It is a label map of label " +
        list_of(labels, grid) + ". Name those of the vessels: --set segmentation.labels=[1,2]");
  if (!left_out.empty())
    warnings.push_back("label " + list_of(left_out, grid) +
                       " is left out: no vessel is that large. segmentation.labels names what is "
                       "wanted");
  return kept;
}

/// 1 in the labels that are wanted.
Volume<std::uint8_t> wanted_mask(const Volume<float>& volume, const std::vector<Label>& labels,
                                 const SegmentationOptions& options) {
  std::vector<float> wanted;
  for (const Label& label : labels)
    if (options.labels.empty() || std::find(options.labels.begin(), options.labels.end(),
                                            label.value) != options.labels.end())
      wanted.push_back(float(label.value));
  for (const double label : options.labels)
    if (std::find(wanted.begin(), wanted.end(), float(label)) == wanted.end())
      throw InputError("segmentation.labels holds " + format_number(label) +
                       ", which the label map does not (it holds " +
                       list_of(labels, volume.geometry) + "). Choose from these");
  Volume<std::uint8_t> mask(volume.geometry, 0);
  for (std::size_t v = 0; v < mask.values.size(); ++v)
    mask.values[v] = std::find(wanted.begin(), wanted.end(), volume.values[v]) != wanted.end();
  return mask;
}

/// Keeps the pieces of at least 5 % of the largest, or those with a seed. @return what is to be
/// told
std::vector<std::string> keep_pieces(Volume<std::uint8_t>& mask, const SegmentationOptions& options,
                                     Segmentation& result) {
  const Components pieces = label_components(mask, Connectivity::corners);
  std::vector<bool> kept(pieces.voxel_count.size(), false);
  for (const Vec3& seed : options.seeds_lps_mm)
    kept[std::size_t(piece_at_seed(pieces, mask.geometry, seed))] = true;
  result.seeds_lps_mm = options.seeds_lps_mm;
  const auto largest = std::max_element(pieces.voxel_count.begin() + 1, pieces.voxel_count.end()) -
                       pieces.voxel_count.begin();
  const double least = kTreeOfItsOwn * double(pieces.voxel_count[std::size_t(largest)]);
  for (std::size_t p = 1; p < kept.size(); ++p)
    kept[p] = kept[p] || (options.seeds_lps_mm.empty() && double(pieces.voxel_count[p]) >= least);
  int count = 0;
  double left_out = 0.0;
  for (std::size_t p = 1; p < kept.size(); ++p) {
    const double volume = double(pieces.voxel_count[p]) * voxel_volume(mask.geometry);
    if (kept[p] || volume < options.min_component_mm3) continue;
    ++count;
    left_out += volume;
  }
  for (std::size_t v = 0; v < mask.values.size(); ++v)
    mask.values[v] = kept[std::size_t(pieces.label[v])] && pieces.label[v] > 0;
  if (result.seeds_lps_mm.empty()) {
    const auto first = std::find(mask.values.begin(), mask.values.end(), 1);
    result.seeds_lps_mm.push_back(
        place_of_voxel(mask.geometry, std::size_t(first - mask.values.begin())));
  }
  if (count == 0) return {};
  return {std::to_string(count) + (count == 1 ? " piece" : " pieces") +
          " of the labels without a connection to what was taken, " + format_number(left_out) +
          " mm3 in all, were left out; give a seed in each that you want"};
}

double inside_mm3(const Volume<std::uint8_t>& mask) {
  const auto count = std::count(mask.values.begin(), mask.values.end(), 1);
  return double(count) * voxel_volume(mask.geometry);
}

}  // namespace

Segmentation segment_label_map(const Volume<float>& volume, const std::vector<Label>& labels,
                               const SegmentationOptions& options, const Progress& progress) {
  Segmentation result;
  const std::vector<Label> plausible =
      options.labels.empty() ? plausible_labels(labels, volume.geometry, result.warnings) : labels;
  Volume<std::uint8_t> mask = wanted_mask(volume, plausible, options);
  result.warnings.push_back(note_of(plausible, options, volume.geometry));
  const auto of_pieces = keep_pieces(mask, options, result);
  result.warnings.insert(result.warnings.end(), of_pieces.begin(), of_pieces.end());
  const double labelled = inside_mm3(mask);
  if (labelled < options.min_component_mm3)
    throw InputError("the labels hold less than segmentation.min_component_mm3 in one piece (" +
                     format_number(labelled) + " mm3). Choose other labels, or lower it");
  const Volume<std::uint8_t> around = crop(mask, bounding_box(mask, kMarginMm));
  result.level_set = find_label_boundary(around, options, progress);
  result.mask = Volume<std::uint8_t>(result.level_set.geometry);
  for (std::size_t v = 0; v < result.mask.values.size(); ++v)
    result.mask.values[v] = result.level_set.values[v] < 0.0f;
  result.lumen_intensity = 1.0;
  const double difference = inside_mm3(result.mask) / labelled - 1.0;
  if (std::abs(difference) > kToldDifference)
    result.warnings.push_back(
        "the lumen's volume is " + format_number(std::round(1000.0 * std::abs(difference)) / 10.0) +
        (difference < 0.0 ? " % smaller" : " % larger") +
        " than that of the labels (parts of them are thinner than two voxels)");
  progress.report(1.0, "labels smoothed");
  return result;
}

}  // namespace angio::segmentation::detail
