#include "segmentation/detail/vessel_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/statistics.hpp"
#include "segmentation/detail/blood_pools.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/format_number.hpp"
#include "segmentation/detail/gaps.hpp"
#include "segmentation/detail/seeds.hpp"
#include "segmentation/detail/vesselness.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr float kWeakShare = 0.15f;        ///< of the typical contrast: counts for the half level
constexpr float kBridgeShare = 0.2f;       ///< joins the tree even below the half level
constexpr float kBridgeLevel = 0.25f;      ///< of the way from tissue to blood, among organs
constexpr float kStrongShare = 0.4f;       ///< sure to be a vessel
constexpr float kGlare = 0.75f;            ///< contrasts above blood: cortex
constexpr double kLeastBesideBone = 0.03;  ///< of a bone's score: a vessel's
constexpr double kLevelSpacing = 1.0;      ///< [mm] grid of the half level
constexpr double kLevelSigma = 2.5;        ///< [mm] reach of the half level
constexpr double kLeastContrastToNoise = 2.0;
constexpr double kSeveralTissues = 0.7;  ///< of the tubes' contrast, from tissue to blood: less, if
                                         ///< others lie in something darker, as lung
constexpr double kTubularShare = 0.4;    ///< of the smallest piece: noise has a voxel or two of C
constexpr double kToleratedNoise = 0.05;
constexpr double kLeastJoined = 20.0;  ///< [mm^3] of a vessel that a stenosis may have cut
constexpr double kLeastTrunk = 10.0;   ///< [mm] of trunks that tells a tree: a heart has less

const char* const kAdvice =
    "Check that the vessels are filled with contrast and brighter than their surroundings, or give "
    "seeds, intensity bounds or other vessel radii";

/// Doubles in [smallest, largest] at even ratios.
std::vector<double> scale_radii(const SegmentationOptions& options) {
  std::vector<double> radii;
  for (int s = 0; s < options.scale_count; ++s) {
    const double t = options.scale_count > 1 ? double(s) / (options.scale_count - 1) : 0.5;
    radii.push_back(options.smallest_radius_mm *
                    std::pow(options.largest_radius_mm / options.smallest_radius_mm, t));
  }
  return radii;
}

/// What C reaches on the axes of the vessels: the 0.9 quantile weighted by C^2, which neither the
/// many weak responses nor a few bright spots move.
double typical_contrast(const Volume<float>& contrast) {
  constexpr std::size_t kBinCount = 4096;
  const float highest = *std::max_element(contrast.values.begin(), contrast.values.end());
  if (!(highest > 0.0f)) return 0.0;
  std::vector<double> weight(kBinCount, 0.0);
  double total = 0.0;
  for (float c : contrast.values) {
    const auto bin = std::min(kBinCount - 1, std::size_t(c / highest * float(kBinCount)));
    const double w = double(c) * double(c);
    weight[bin] += w;
    total += w;
  }
  double sum = 0.0;
  std::size_t bin = 0;
  while (bin + 1 < kBinCount && (sum += weight[bin]) < 0.9 * total) ++bin;
  return (double(bin) + 0.5) / double(kBinCount) * double(highest);
}

/// Averages of weight C^2, and of C^2 (I - C / 2), around each place.
struct HalfLevel {
  CoarseField weight;
  CoarseField weighted_level;
};

HalfLevel half_level(const Volume<float>& smoothed, const Volume<float>& contrast, float typical) {
  Volume<float> weight(smoothed.geometry);
  Volume<float> level(smoothed.geometry);
  const float weak = kWeakShare * typical;
  parallel_for(smoothed.geometry.size[2], [&](std::ptrdiff_t k) {
    const std::size_t slice = smoothed.values.size() / std::size_t(smoothed.geometry.size[2]);
    for (std::size_t v = std::size_t(k) * slice; v < (std::size_t(k) + 1) * slice; ++v) {
      const float c = contrast.values[v];
      weight.values[v] = c < weak ? 0.0f : (c / typical) * (c / typical);
      level.values[v] = weight.values[v] * (smoothed.values[v] - 0.5f * c);
    }
  });
  const auto factor = block_size(smoothed.geometry, kLevelSpacing);
  return {{smooth(block_average(weight, factor), kLevelSigma), factor},
          {smooth(block_average(level, factor), kLevelSigma), factor}};
}

/// @return kBridge, kLumen or 0
Volume<std::uint8_t> candidates(const Volume<float>& smoothed, const Tubes& tubes, float typical,
                                const BloodLevel& blood, const SegmentationOptions& options) {
  constexpr float kLeastWeight = 1e-4f;  // farther than about four reaches from any tube
  const HalfLevel half = half_level(smoothed, tubes.contrast, typical);
  const auto lowest = float(options.intensity_min.value_or(-1e30));
  const auto highest = float(options.intensity_max.value_or(1e30));
  // Among organs a tube may be a fold of bowel, or the edge of a liver.
  const float least_bridge =
      blood.is_even ? blood.tissue + kBridgeLevel * blood.contrast() : -1e30f;
  Volume<std::uint8_t> mask(smoothed.geometry, 0);
  const auto [ni, nj, nk] = smoothed.geometry.size;
  parallel_for(nk, [&, ni = ni, nj = nj](std::ptrdiff_t k) {
    const auto width = std::size_t(ni);
    std::vector<float> weight(width), level(width);
    for (int j = 0; j < nj; ++j) {
      half.weight.row(j, int(k), ni, weight.data());
      half.weighted_level.row(j, int(k), ni, level.data());
      for (int i = 0; i < ni; ++i) {
        const float value = smoothed.at(i, j, int(k));
        const float w = weight[std::size_t(i)];
        const bool above =
            w > kLeastWeight && value * w > level[std::size_t(i)] &&
            (value > blood.half() || (!blood.is_even && tubes.is_near.at(i, j, int(k))));
        const bool tube =
            tubes.contrast.at(i, j, int(k)) > kBridgeShare * typical && value > least_bridge;
        mask.at(i, j, int(k)) = value < lowest || value > highest ? 0
                                : above                           ? kLumen
                                : tube                            ? kBridge
                                                                  : 0;
      }
    }
  });
  return mask;
}

/// The sum of C over each piece's strong voxels.
std::vector<double> score_pieces(const Components& pieces, const Volume<float>& contrast,
                                 float typical) {
  std::vector<double> score(std::size_t(pieces.count()) + 1, 0.0);
  for (std::size_t v = 0; v < pieces.label.size(); ++v)
    if (pieces.label[v] > 0 && contrast.values[v] >= kStrongShare * typical)
      score[std::size_t(pieces.label[v])] += double(contrast.values[v]);
  return score;
}

/// Whether a piece is a bone: a tenth of it and more is brighter than blood by most of the
/// contrast, as cortex is, and a tenth darker than tissue, as marrow is.
bool is_bone(const Components& pieces, int piece, const Volume<float>& volume,
             const BloodLevel& level) {
  if (!level.is_told) return false;
  const float bright = level.lumen + kGlare * level.contrast();
  std::size_t all = 0, brighter = 0, darker = 0;
  for (std::size_t v = 0; v < pieces.label.size(); ++v) {
    if (pieces.label[v] != piece) continue;
    ++all;
    brighter += volume.values[v] > bright;
    darker += volume.values[v] < level.tissue;
  }
  return 10 * brighter > all && 10 * darker > all;
}

/// The scores without those of bones, as long as vessels of a fair size are left.
std::vector<double> without_bones(const Components& pieces, std::vector<double> score,
                                  const Volume<float>& volume, const BloodLevel& level) {
  const double most = *std::max_element(score.begin(), score.end());
  std::vector<double> vessels = score;
  for (std::size_t p = 1; p < score.size(); ++p)
    if (score[p] >= kLeastBesideBone * most && is_bone(pieces, int(p), volume, level))
      vessels[p] = 0.0;
  const double left = *std::max_element(vessels.begin(), vessels.end());
  return left >= kLeastBesideBone * most ? vessels : score;
}

/// The length of trunks in each piece [mm].
std::vector<double> score_trunks(const Components& pieces, const std::vector<TubeAxis>& trunks) {
  std::vector<double> length(std::size_t(pieces.count()) + 1, 0.0);
  for (const TubeAxis& trunk : trunks)
    for (const std::size_t v : trunk.voxels)
      if (pieces.label[v] > 0) length[std::size_t(pieces.label[v])] += trunk.length_share;
  return length;
}

/// The voxel of the piece with the greatest C: an automatic seed.
Vec3 strongest_point(const Components& pieces, int piece, const Volume<float>& contrast) {
  std::size_t best = 0;
  float highest = -1.0f;
  for (std::size_t v = 0; v < pieces.label.size(); ++v)
    if (pieces.label[v] == piece && contrast.values[v] > highest) {
      highest = contrast.values[v];
      best = v;
    }
  return place_of_voxel(contrast.geometry, best);
}

/// Whether a piece is the same in every slice: from the first to the last, over 15 cm or more, and
/// slices 5 cm apart overlap by 90 %.
bool is_extruded(const Components& pieces, int piece, const VolumeGeometry& grid) {
  constexpr double kLeastLength = 150.0, kApart = 50.0;  // [mm]
  constexpr double kOverlap = 0.9;
  const int slices = grid.size[2], apart = int(std::lround(kApart / grid.spacing.z));
  if (slices * grid.spacing.z < kLeastLength || apart < 1) return false;
  const std::size_t slice = grid.voxel_count() / std::size_t(slices);
  std::vector<std::size_t> count(std::size_t(slices), 0);
  std::size_t both = 0, all = 0;
  for (std::size_t v = 0; v < pieces.label.size(); ++v) {
    if (pieces.label[v] != piece) continue;
    const std::size_t k = v / slice;
    ++count[k];
    if (k + std::size_t(apart) >= count.size()) continue;
    ++all;
    both += pieces.label[v + std::size_t(apart) * slice] == piece;
  }
  return count.front() > 0 && count.back() > 0 && double(both) > kOverlap * double(all);
}

/// Whether what lies 4 mm beside a piece, in its slices, is air for the most part.
bool is_in_air(const Components& pieces, int piece, const Volume<float>& volume,
               const BloodLevel& level) {
  constexpr double kBeside = 4.0;    // [mm]
  constexpr float kAirBelow = 1.5f;  // contrasts below tissue: fat and organs are above
  const float air = level.tissue - kAirBelow * level.contrast();
  const VolumeGeometry& grid = volume.geometry;
  const std::array<int, 2> step{std::max(1, int(std::lround(kBeside / grid.spacing.x))),
                                std::max(1, int(std::lround(kBeside / grid.spacing.y)))};
  std::size_t beside = 0, in_air = 0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        if (pieces.label[grid.offset(i, j, k)] != piece) continue;
        for (const auto& [x, y] :
             {std::pair{i - step[0], j}, {i + step[0], j}, {i, j - step[1]}, {i, j + step[1]}}) {
          if (!grid.contains(x, y, k) || pieces.label[grid.offset(x, y, k)] == piece) continue;
          ++beside;
          in_air += volume.at(x, y, k) < air;
        }
      }
  return 2 * in_air > beside;
}

/// Whether a piece is the couch under the patient.
bool is_couch(const Components& pieces, int piece, const Volume<float>& volume,
              const BloodLevel& level) {
  return level.is_told && is_extruded(pieces, piece, volume.geometry) &&
         is_in_air(pieces, piece, volume, level);
}

/// More than any region of the body has trees of vessels as wide as the one that was taken.
constexpr int kManyPieces = 20;

void warn_of_dropped(const Components& pieces, const std::vector<double>& score,
                     const std::vector<bool>& kept, const Volume<float>& contrast,
                     const SegmentationOptions& options, VesselTree& tree) {
  std::vector<std::size_t> lumen(kept.size(), 0);
  for (std::size_t v = 0; v < pieces.label.size(); ++v)
    lumen[std::size_t(pieces.label[v])] += tree.mask.values[v] == kLumen;
  int count = 0, largest = 0;
  double volume = 0.0, taken = 0.0;
  std::vector<bool> is_told(kept.size(), false);
  for (std::size_t p = 1; p < kept.size(); ++p) {
    const double piece = double(lumen[p]) * voxel_volume(tree.mask.geometry);
    taken += kept[p] ? piece : 0.0;
    // A vessel is tubular all along; a cloud of noise holds a voxel or two that look so.
    const double tubular = score[p] / tree.contrast * voxel_volume(tree.mask.geometry);
    if (kept[p] || tubular < options.min_component_mm3) continue;
    ++count;
    volume += piece;
    if (largest == 0 || lumen[p] > lumen[std::size_t(largest)]) largest = int(p);
    is_told[p] = true;
  }
  tree.seen = Volume<std::uint8_t>(tree.mask.geometry, 0);
  for (std::size_t v = 0; v < pieces.label.size(); ++v) {
    const auto p = std::size_t(pieces.label[v]);
    tree.seen.values[v] = p > 0 && !is_told[p];
  }
  if (options.seeds_lps_mm.empty() && count >= kManyPieces && volume > taken)
    tree.warnings.push_back(
        kOutweighedLumen + std::to_string(count) + " pieces, " + format_number(volume) +
        " mm3 in all, have no connection to the " + format_number(taken) +
        " mm3 of the tree. Organs and veins beside it may be that; where there is no contrast "
        "medium the tree itself may be bone, bowel or muscle. Look at it. " +
        kAdvice);
  else if (count > 0)
    tree.warnings.push_back(std::to_string(count) + (count == 1 ? " piece" : " pieces") +
                            " of vessel without a connection to the tree, " +
                            format_number(volume) + " mm3 in all, " +
                            (count == 1 ? "at " : "the largest at ") +
                            format_place(strongest_point(pieces, largest, contrast)) +
                            ", were left out; give a seed in each that you want "
                            "(segmentation.seeds_lps_mm)");
}

/// Of the best piece's tubular part: what has as much is another tree (the left and the right
/// carotid), not a part that noise has cut off.
constexpr double kTreeOfItsOwn = 0.2;

/// Of its own volume a tree is tubular at least in so much; a chamber of the heart is in less.
constexpr double kTubularOfItself = 0.05;

/// The piece with the longest trunks, or with nearly as long ones and more contrast; where none has
/// enough of them, that with most contrast.
int best_piece(const Components& pieces, std::vector<double> score, std::vector<double> trunk,
               const Volume<float>& volume, const BloodLevel& level) {
  constexpr double kAsLong = 0.5;  // and less than kLeastTrunk shorter, which tells nothing
  const bool has_trunks = *std::max_element(trunk.begin(), trunk.end()) >= kLeastTrunk;
  std::vector<double>& measure = has_trunks ? trunk : score;
  const double least = has_trunks ? kLeastTrunk : 0.0;
  for (;;) {
    auto best = std::max_element(measure.begin(), measure.end());
    const double most = *best;
    if (has_trunks)
      for (auto other = trunk.begin(); other != trunk.end(); ++other)
        if (*other >= kAsLong * most && *other > most - kLeastTrunk &&
            score[std::size_t(other - trunk.begin())] > score[std::size_t(best - trunk.begin())])
          best = other;
    const int piece = int(best - measure.begin());
    if (most > 0.0 && is_couch(pieces, piece, volume, level)) {
      *best = 0.0;
    } else if (most >= least) {
      return piece;
    } else {
      throw InputError(
          std::string("no vessel was found (what is wide, even and bright is the couch under the "
                      "patient: a scan without contrast?). ") +
          kAdvice);
    }
  }
}

void keep_pieces(const Components& pieces, const Volume<float>& volume, const BloodLevel& level,
                 const Volume<float>& contrast, const std::vector<TubeAxis>& trunks,
                 const SegmentationOptions& options, VesselTree& tree) {
  const auto score =
      without_bones(pieces, score_pieces(pieces, contrast, float(tree.contrast)), volume, level);
  std::vector<bool> kept(score.size(), false);
  for (const Vec3& seed : options.seeds_lps_mm) {
    kept[std::size_t(piece_at_seed(pieces, contrast.geometry, seed))] = true;
    tree.seeds_lps_mm.push_back(seed);
  }
  if (options.seeds_lps_mm.empty()) {
    const int best = best_piece(pieces, score, score_trunks(pieces, trunks), volume, level);
    const double piece_mm3 =
        double(pieces.voxel_count[std::size_t(best)]) * voxel_volume(contrast.geometry);
    const double tubular =
        score[std::size_t(best)] / tree.contrast * voxel_volume(contrast.geometry);
    if (score[std::size_t(best)] <= 0.0 || piece_mm3 < options.min_component_mm3 ||
        tubular < kTubularShare * options.min_component_mm3)
      throw InputError(std::string("no vessel was found (every bright piece is smaller than "
                                   "segmentation.min_component_mm3 or not tubular). ") +
                       kAdvice);
    kept[std::size_t(best)] = true;
    // Where bones and organs had to be kept out, what else is large may be more of them, or veins.
    const double least = kTreeOfItsOwn * score[std::size_t(best)];
    for (std::size_t p = 1; p < kept.size() && trunks.empty(); ++p)
      kept[p] = kept[p] ||
                (score[p] >= least &&
                 score[p] >= kTubularOfItself * tree.contrast * double(pieces.voxel_count[p]) &&
                 !is_couch(pieces, int(p), volume, level));
    for (std::size_t p = 1; p < kept.size(); ++p)
      if (kept[p]) tree.seeds_lps_mm.push_back(strongest_point(pieces, int(p), contrast));
  }
  warn_of_dropped(pieces, score, kept, contrast, options, tree);
  for (std::size_t v = 0; v < pieces.label.size(); ++v)
    tree.mask.values[v] = kept[std::size_t(pieces.label[v])];
}

}  // namespace

double noise_deviation(const Volume<float>& volume) {
  constexpr double kFromMad = 1.4826;
  const double second_difference = std::sqrt(6.0);  // of unit white noise
  constexpr std::size_t kSampleCount = 300000;
  const auto [ni, nj, nk] = volume.geometry.size;
  const std::size_t step = std::max<std::size_t>(1, volume.values.size() / kSampleCount);
  std::vector<float> sample;
  for (std::size_t v = 0; v < volume.values.size(); v += step) {
    const int i = int(v % std::size_t(ni)), j = int(v / std::size_t(ni) % std::size_t(nj)),
              k = int(v / std::size_t(ni) / std::size_t(nj));
    if (i < 1 || i + 1 >= ni || j < 0 || j >= nj || k >= nk) continue;
    sample.push_back(
        std::abs(volume.at(i - 1, j, k) - 2.0f * volume.at(i, j, k) + volume.at(i + 1, j, k)));
  }
  if (sample.empty()) return 0.0;
  return kFromMad * double(median(std::move(sample))) / second_difference;
}

double denoising_sigma(const Volume<float>& volume, double noise, double contrast) {
  // White noise falls by (2 sqrt(pi) s)^(-3/2) under a Gaussian of s voxels.
  const double excess = noise / (kToleratedNoise * contrast);
  if (excess <= 1.0) return 0.0;
  const double sigma_voxels =
      std::min(1.2, std::pow(excess, 2.0 / 3.0) / (2.0 * std::sqrt(std::numbers::pi)));
  const Vec3& h = volume.geometry.spacing;
  return sigma_voxels * std::cbrt(h.x * h.y * h.z);
}

VesselTree find_vessel_tree(const Volume<float>& volume, const BloodLevel& level,
                            const std::vector<TubeAxis>& trunks, const SegmentationOptions& options,
                            const Progress& progress) {
  const Tubes tubes = find_tubes(volume, scale_radii(options), level, progress);
  const Volume<float>& contrast = tubes.contrast;
  VesselTree tree;
  tree.contrast = typical_contrast(contrast);
  if (level.is_even ||
      (level.is_told && double(level.contrast()) < kSeveralTissues * tree.contrast)) {
    tree.contrast = std::min(tree.contrast, double(level.contrast()));
    tree.blood = level;
  }
  tree.noise = noise_deviation(volume);
  if (tree.contrast <= 0.0 || tree.contrast < kLeastContrastToNoise * tree.noise)
    throw InputError(
        std::string("no vessel was found (nothing tubular stands out of the noise). ") + kAdvice);
  const Volume<float> smoothed = smooth(volume, denoising_sigma(volume, tree.noise, tree.contrast));
  tree.mask = candidates(smoothed, tubes, float(tree.contrast), level, options);
  if (level.is_told) add_pools(smoothed, level, options, tree.mask);
  const double least_mm3 = std::max(kLeastJoined, options.min_component_mm3);
  part_passing_vessels(tree.mask, kBridge, least_mm3);
  join_across_gaps(tree.mask, kBridge, least_mm3);
  progress.report(0.45, "connecting vessels");
  keep_pieces(label_components(tree.mask, Connectivity::faces), volume, level, contrast, trunks,
              options, tree);
  for (std::size_t v = 0; v < tree.seen.values.size(); ++v)
    tree.seen.values[v] = tree.seen.values[v] && tubes.is_thin.values[v];
  progress.report(0.55, "connecting vessels");
  return tree;
}

}  // namespace angio::segmentation::detail
