#pragma once

#include <vector>

#include "core/vec3.hpp"
#include "datasets/detail/lumen_shape.hpp"

/// A vessel as it is designed: directions and radii along its axis, and its stenoses.
namespace angio::datasets::detail {

/// Direction of the axis at an arc length; between keys it turns smoothly (Catmull-Rom).
struct DirectionKey {
  double abscissa_mm = 0.0;
  Vec3 direction;  ///< need not be unit
};

/// The radius falls linearly within a stretch; at its start it passes over from the stretch before
/// within `transition_mm` (smoothstep).
struct RadiusStretch {
  double start_mm = 0.0;
  double end_mm = 0.0;
  double radius_at_start_mm = 0.0;
  double radius_at_end_mm = 0.0;
  double transition_mm = 0.0;
};

enum class LesionShape { concentric, eccentric, two_sided };

struct LesionPlan {
  double center_mm = 0.0;
  double length_mm = 0.0;
  double depth = 0.0;  ///< diameter stenosis, [0, 1)
  Vec3 toward;         ///< eccentric: where the lumen is pushed; two-sided: its long side
  LesionShape shape = LesionShape::eccentric;
};

struct VesselPlan {
  Vec3 start;  ///< LPS [mm]
  double length_mm = 0.0;
  std::vector<DirectionKey> directions;  ///< ascending
  std::vector<RadiusStretch> radii;      ///< ascending, without gaps
  std::vector<LesionPlan> lesions;       ///< do not overlap
  bool begins_in_parent = false;         ///< no flat end at its start
  bool ends_as_dome = false;             ///< no flat end at its end: an aneurysm's sac

  [[nodiscard]] Vec3 direction(double abscissa_mm) const;         ///< unit tangent of the axis
  [[nodiscard]] double healthy_radius(double abscissa_mm) const;  ///< [mm]
};

/// Samples a plan. The samples continue past flat ends by 1.2 radii.
Branch sample_vessel(const VesselPlan& plan);

/// The sample of a branch nearest to an abscissa of its axis.
int sample_at(const Branch& branch, double abscissa_mm);

}  // namespace angio::datasets::detail
