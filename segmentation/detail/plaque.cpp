#include "segmentation/detail/plaque.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/statistics.hpp"
#include "segmentation/detail/take_out.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr int kReachVoxels = 4;      ///< voxels around a piece that are looked at
constexpr double kShell = 2.6;       ///< voxels: two blurs of 0.8 voxels and a voxel
constexpr double kOuterShell = 1.5;  ///< voxels: from plaque's threshold to half of blood's
constexpr double kSharp = 0.12;      ///< contrasts a voxel: where blood mixes, it is gentler
constexpr float kBright = 0.5f;      ///< contrasts above blood: half of it, not noise alone
constexpr double kEachSide = 0.2;    ///< of its border: plaque is between wall and blood,
constexpr double kInThroat = 0.05;   ///< of which a tight throat leaves little beside it
constexpr double kSteep = 0.55;      ///< contrasts a voxel
constexpr float kNearBlood = 0.25f;  ///< of the contrast
constexpr double kReachOfAxis = 4.0, kLeastAxis = 4.0;  ///< [mm]; or a wider tube's radius and
constexpr double kReachOfWall = 2.0;                    ///< so much [mm]
constexpr double kThickest = 2.5;                       ///< [mm] radius of a ball in plaque
constexpr double kLongestPlaque = 40.0;                 ///< [mm]

using Index = std::array<int, 3>;

/// The steps to all voxels within a reach, the nearest first.
std::vector<Index> steps_within(double reach) {
  std::vector<Index> steps;
  const int n = int(reach);
  for (int k = -n; k <= n; ++k)
    for (int j = -n; j <= n; ++j)
      for (int i = -n; i <= n; ++i)
        if (i * i + j * j + k * k <= reach * reach) steps.push_back({i, j, k});
  const auto square = [](const Index& s) { return s[0] * s[0] + s[1] * s[1] + s[2] * s[2]; };
  std::stable_sort(steps.begin(), steps.end(),
                   [&](const Index& a, const Index& b) { return square(a) < square(b); });
  return steps;
}

VoxelBox grown(const VoxelBox& box, const VolumeGeometry& grid) {
  VoxelBox result;
  for (std::size_t a = 0; a < 3; ++a) {
    result.first[a] = std::max(box.first[a] - kReachVoxels, 0);
    result.size[a] =
        std::min(box.first[a] + box.size[a] + kReachVoxels, grid.size[a]) - result.first[a];
  }
  return result;
}

double length_of(const VoxelBox& box, const Vec3& h) {
  return std::hypot((box.size[0] - 1) * h.x, (box.size[1] - 1) * h.y, (box.size[2] - 1) * h.z);
}

template <class Visit>
void for_each_voxel(const VoxelBox& box, const Visit& visit) {
  for (int k = box.first[2]; k < box.first[2] + box.size[2]; ++k)
    for (int j = box.first[1]; j < box.first[1] + box.size[1]; ++j)
      for (int i = box.first[0]; i < box.first[0] + box.size[0]; ++i) visit(Index{i, j, k});
}

/// A piece and what surrounds it.
class Surroundings {
 public:
  Surroundings(const Components& pieces, std::size_t piece, const Volume<float>& denoised,
               const PlaqueLevel& level)
      : pieces_(pieces), piece_(std::int32_t(piece)), denoised_(denoised), level_(level) {}

  [[nodiscard]] bool is_piece(const Index& at) const { return pieces_.label[offset(at)] == piece_; }
  [[nodiscard]] float value(const Index& at) const { return denoised_.values[offset(at)]; }
  /// Darker than the half level of blood.
  [[nodiscard]] bool is_tissue(const Index& at) const { return value(at) < level_.half(); }
  /// As bright as blood, and not on the steep way from plaque to tissue.
  [[nodiscard]] bool is_blood(const Index& at) const {
    if (is_piece(at) || std::abs(value(at) - level_.blood) > kNearBlood * level_.contrast)
      return false;
    return slope(at) < kSteep;
  }
  /// Of the image [contrasts a voxel].
  [[nodiscard]] double slope(const Index& at) const {
    double square = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Index before = at, behind = at;
      --before[axis];
      ++behind[axis];
      if (!contains(before) || !contains(behind)) continue;
      const double along = 0.5 * (value(behind) - value(before));
      square += along * along;
    }
    return std::sqrt(square) / level_.contrast;
  }
  /// A voxel at a step; none beyond the border.
  [[nodiscard]] bool contains(const Index& at) const {
    return denoised_.geometry.contains(at[0], at[1], at[2]);
  }
  [[nodiscard]] std::size_t offset(const Index& at) const {
    return denoised_.geometry.offset(at[0], at[1], at[2]);
  }

 private:
  const Components& pieces_;
  std::int32_t piece_;
  const Volume<float>& denoised_;
  const PlaqueLevel& level_;
};

Index moved(const Index& at, const Index& step) {
  return {at[0] + step[0], at[1] + step[1], at[2] + step[2]};
}

/// What a voxel in plaque or in its blurred shell is next to.
enum class Side { neither, blood, tissue };

Side side_of(const Surroundings& around, const Index& at, const std::vector<Index>& steps) {
  const auto square = [](const Index& s) { return s[0] * s[0] + s[1] * s[1] + s[2] * s[2]; };
  int to_tissue = std::numeric_limits<int>::max();
  for (const Index& step : steps) {
    if (square(step) > to_tissue) break;
    const Index there = moved(at, step);
    if (!around.contains(there)) continue;
    if (around.is_blood(there)) return Side::blood;
    if (around.is_tissue(there)) to_tissue = square(step);
  }
  return to_tissue < std::numeric_limits<int>::max() ? Side::tissue : Side::neither;
}

/// The median of the tissue around a piece.
float tissue_around(const Surroundings& around, const VoxelBox& box, float otherwise) {
  std::vector<float> values;
  for_each_voxel(box, [&](const Index& at) {
    if (around.is_tissue(at)) values.push_back(around.value(at));
  });
  return values.empty() ? otherwise : median(std::move(values));
}

/// The nearest voxel of the piece, and the brightest within reach, which is brighter than blood.
struct Nearness {
  double distance = std::numeric_limits<double>::infinity();  ///< voxels; none within reach
  float peak = 0.0f;
};

Nearness nearness(const Surroundings& around, const Index& at, const std::vector<Index>& steps) {
  Nearness near;
  for (const Index& step : steps) {
    const Index there = moved(at, step);
    if (!around.contains(there) || !around.is_piece(there)) continue;
    near.distance = std::min(near.distance, std::hypot(step[0], step[1], step[2]));
    near.peak = std::max(near.peak, around.value(there));
  }
  return near;
}

/// A place on the axis of a tube of blood.
struct AxisPlace {
  Index at;
  double length;  ///< that it stands for [mm]
  double reach;   ///< from it to a piece in its wall [mm]
};

std::vector<AxisPlace> places_of_blood(const std::vector<TubeAxis>& axes,
                                       const Volume<float>& denoised, const PlaqueLevel& level) {
  std::vector<AxisPlace> places;
  for (const TubeAxis& axis : axes)
    for (const std::size_t v : axis.voxels)
      if (std::abs(denoised.values[v] - level.blood) <= kNearBlood * level.contrast)
        places.push_back({voxel_of(denoised.geometry, v), axis.length_share,
                          std::max(kReachOfAxis, axis.radius_mm + kReachOfWall)});
  return places;
}

/// The length of the axes of blood within reach of a piece [mm].
double length_near(const std::vector<AxisPlace>& places, const VoxelBox& box, const Vec3& h) {
  double length = 0.0;
  for (const AxisPlace& place : places) {
    bool is_near = true;
    for (std::size_t a = 0; a < 3; ++a) {
      const double reach = place.reach / h[int(a)];
      is_near = is_near && place.at[a] >= box.first[a] - reach &&
                place.at[a] < box.first[a] + box.size[a] + reach;
    }
    if (is_near) length += place.length;
  }
  return length;
}

/// A piece's border, of faces of its voxels. One is at tissue that is reached within three voxels
/// straight on, else at blood.
struct Border {
  double slope = 0.0;         ///< mean at blood [contrasts a voxel]
  double blood_share = 0.0;   ///< of the faces
  double tissue_share = 0.0;  ///< likewise
};

Border border_of(const Surroundings& around, const VoxelBox& box) {
  constexpr int kAhead = 3;
  double slopes = 0.0;
  int at_blood = 0, at_tissue = 0;
  const auto look = [&](const Index& at, const Index& step) {
    Index there = moved(at, step);
    if (!around.contains(there) || around.is_piece(there)) return;
    for (int n = 0; n < kAhead && around.contains(there); ++n, there = moved(there, step)) {
      if (around.is_blood(there)) break;
      if (around.is_tissue(there)) {
        ++at_tissue;
        return;
      }
    }
    ++at_blood;
    slopes += around.slope(at);
  };
  for_each_voxel(box, [&](const Index& at) {
    if (!around.is_piece(at)) return;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) {
        Index step{0, 0, 0};
        step[axis] = side;
        look(at, step);
      }
  });
  if (at_blood == 0) return {};
  const double all = at_blood + at_tissue;
  return {slopes / at_blood, at_blood / all, at_tissue / all};
}

/// How far blood reaches in a box [mm].
double length_of_blood(const Surroundings& around, const VoxelBox& box, const Vec3& h) {
  Index low{1 << 30, 1 << 30, 1 << 30}, high{-1, -1, -1};
  for_each_voxel(box, [&](const Index& at) {
    if (!around.is_blood(at)) return;
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], at[a]);
      high[a] = std::max(high[a], at[a]);
    }
  });
  if (high[0] < 0) return 0.0;
  VoxelBox blood{low, {}};
  for (std::size_t a = 0; a < 3; ++a) blood.size[a] = high[a] - low[a] + 1;
  return length_of(blood, h);
}

/// Half of a piece is brighter.
float middle_of(const Surroundings& around, const VoxelBox& box) {
  std::vector<float> values;
  for_each_voxel(box, [&](const Index& at) {
    if (around.is_piece(at)) values.push_back(around.value(at));
  });
  return median(std::move(values));
}

/// Whether a ball fits into a piece.
bool holds_ball(const Surroundings& around, const VoxelBox& box, double radius, const Vec3& h) {
  std::vector<Index> ball;
  for (const Index& step : steps_within(radius / std::min({h.x, h.y, h.z})))
    if (std::hypot(step[0] * h.x, step[1] * h.y, step[2] * h.z) <= radius) ball.push_back(step);
  std::reverse(ball.begin(), ball.end());  // its shell is left first
  bool holds = false;
  for_each_voxel(box, [&](const Index& at) {
    holds = holds || std::all_of(ball.begin(), ball.end(), [&](const Index& step) {
              const Index there = moved(at, step);
              return around.contains(there) && around.is_piece(there);
            });
  });
  return holds;
}

}  // namespace

std::vector<bool> find_plaque(const Components& pieces, const std::vector<VoxelBox>& boxes,
                              const std::vector<bool>& candidates,
                              const std::vector<TubeAxis>& axes, const Volume<float>& denoised,
                              const PlaqueLevel& level) {
  const std::vector<AxisPlace> places = places_of_blood(axes, denoised, level);
  const Vec3& h = denoised.geometry.spacing;
  std::vector<bool> is_plaque(boxes.size(), false);
  for (std::size_t p = 1; p < boxes.size(); ++p) {
    const double length = candidates[p] ? length_of(boxes[p], h) : 0.0;
    if (!candidates[p] || length > kLongestPlaque) continue;
    const bool is_near_axis = length_near(places, boxes[p], h) >= kLeastAxis;
    if (!is_near_axis && !level.is_sure) continue;
    const Surroundings around(pieces, p, denoised, level);
    if (middle_of(around, boxes[p]) < level.blood + kBright * level.contrast) continue;
    const Border border = border_of(around, boxes[p]);
    const double least_at_blood = is_near_axis ? kInThroat : kEachSide;
    if (border.slope < kSharp || border.tissue_share < kEachSide ||
        border.blood_share < least_at_blood)
      continue;
    if (holds_ball(around, boxes[p], kThickest, h)) continue;
    is_plaque[p] = length_of_blood(around, grown(boxes[p], denoised.geometry), h) >= length;
  }
  return is_plaque;
}

void darken_plaque(const Components& pieces, const std::vector<VoxelBox>& boxes,
                   const std::vector<bool>& is_plaque, const Volume<float>& denoised,
                   const PlaqueLevel& level, Volume<float>& image) {
  const std::vector<Index> steps = steps_within(kReachVoxels), shell = steps_within(kShell);
  for (std::size_t p = 1; p < boxes.size(); ++p) {
    if (!is_plaque[p]) continue;
    const Surroundings around(pieces, p, denoised, level);
    const VoxelBox box = grown(boxes[p], denoised.geometry);
    const float tissue = tissue_around(around, box, level.surroundings());
    for_each_voxel(box, [&](const Index& at) {
      const Nearness near = nearness(around, at, shell);
      if (!std::isfinite(near.distance)) return;
      float& value = image.values[around.offset(at)];
      const Side side = side_of(around, at, steps);
      if (side == Side::blood) {
        const float above = (value - level.blood) / (near.peak - level.blood);
        value -= std::max(value - level.blood, 0.0f) +
                 (level.blood - tissue) * std::clamp(above, 0.0f, 1.0f);
      } else if (near.distance <= kOuterShell) {
        value = std::min(value, tissue);
      }
    });
  }
}

}  // namespace angio::segmentation::detail
