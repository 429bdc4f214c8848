#pragma once

#include <vector>

#include "core/centerline.hpp"
#include "meshing/wall_layers.hpp"

namespace angio::meshing::detail {

/// A box that holds some points and a margin around them [mm].
struct Box {
  Vec3 low, high;
};

/// What the healthy vessel is like around a point.
struct HealthyPlace {
  double distance = 0.0;  ///< from the healthy lumen's surface [mm], negative inside
  Vec3 gradient;          ///< of the distance; unit but where branches meet
  double radius = 0.0;    ///< of the healthy lumen [mm]
  double narrowed = 0.0;  ///< 1 within narrow stretches, falling to 0 beyond them
  Vec3 tangent;           ///< unit, of the nearest line
};

/// A stretch of line with the radius of the healthy lumen.
struct HealthyLine {
  std::vector<Vec3> points;
  std::vector<double> radius;    ///< [mm]
  std::vector<double> narrowed;  ///< 1 within narrow stretches, falling to 0 beyond them
  std::vector<Vec3> tangents;    ///< unit, away from the inlet
};

/// The tubes around a tree's lines that the vessel would be without lesions. Where tubes meet, they
/// blend: the distance is
///
///     d = -w ln( sum_i exp(-d_i / w) ),   w a tenth of the radius
class HealthyVessel {
 public:
  /// @param box  lines further away are left out
  HealthyVessel(const CenterlineTree& tree, const std::vector<NarrowStretch>& stretches,
                const Box& box);
  [[nodiscard]] HealthyPlace evaluate(const Vec3& point) const;

 private:
  std::vector<HealthyLine> lines_;  ///< no stretch is held twice
};

/// A path without its lesions: the line's course and radius as they would be.
struct HealthyPath {
  std::vector<Vec3> points;
  std::vector<double> radius;
  std::vector<double> narrowed;
};
HealthyPath heal_path(const CenterlinePath& path, const std::vector<NarrowStretch>& stretches);

}  // namespace angio::meshing::detail
