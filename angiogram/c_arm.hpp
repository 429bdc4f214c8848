#pragma once

#include <string>

#include "core/vec3.hpp"

/// How a C-arm sees vessels: views by its angles, what they hide, X-ray pictures.
namespace angio::angiogram {

/// Where the C-arm's detector stands, as DICOM says it (PS3.3, C.8.7.5.1.2, Positioner Primary and
/// Secondary Angle): 0, 0 is in front of the patient's chest; the primary angle grows from the
/// patient's right (RAO) to the left (LAO, 90: at the left hand), the secondary one from the feet
/// (CAU) to the head (CRA).
struct CArmAngles {
  double primary_degrees = 0.0;    ///< [-180, 180]
  double secondary_degrees = 0.0;  ///< [-90, 90]
};

/// The picture's axes in LPS, unit and at right angles to each other. The picture is seen from the
/// detector, the head up: from in front, the patient's left is at the right.
struct CArmAxes {
  Vec3 to_detector;  ///< against the beam
  Vec3 right, up;    ///< right x up = to_detector
};

/// The axes of a view. With the angles p and s, in LPS,
///
///     to_detector = (cos s sin p, -cos s cos p, sin s)
///     right       = (cos p, sin p, 0)
///     up          = (-sin s sin p, sin s cos p, cos s)
///
/// so that the beam is arccos(cos p cos s) away from the one from the front, as PS3.3 has it.
CArmAxes c_arm_axes(const CArmAngles& angles);

/// The angles at which the detector stands in a direction.
/// @param to_detector  not zero; along the body's axis the primary angle is 0
CArmAngles c_arm_angles(const Vec3& to_detector);

/// By how much two beams differ [degrees], [0, 180].
double angle_between(const CArmAngles& a, const CArmAngles& b);

/// Views whose beams differ by less, from whichever end, show no depth [degrees].
inline constexpr double kLeastViewAngle = 30.0;

/// By how much two beams differ, from whichever end: what two views tell of depth [degrees], [0,
/// 90].
/// @param a, b  along the beams, not zero
double angle_between_beams(const Vec3& a, const Vec3& b);

/// As it is said in a catheter laboratory, in whole degrees: "LAO 32 CRA 15", "RAO 30", "AP CAU
/// 20", "AP".
std::string c_arm_label(const CArmAngles& angles);

}  // namespace angio::angiogram
