#include "angiogram/c_arm.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"

namespace angio::angiogram {
namespace {

constexpr double kRadians = units::kPi / 180.0;

std::string side(long angle, const char* positive, const char* negative) {
  if (angle == 0) return {};
  return std::string(angle > 0 ? positive : negative) + " " + std::to_string(std::abs(angle));
}

}  // namespace

CArmAxes c_arm_axes(const CArmAngles& angles) {
  const double p = kRadians * angles.primary_degrees, s = kRadians * angles.secondary_degrees;
  return {{std::cos(s) * std::sin(p), -std::cos(s) * std::cos(p), std::sin(s)},
          {std::cos(p), std::sin(p), 0.0},
          {-std::sin(s) * std::sin(p), std::sin(s) * std::cos(p), std::cos(s)}};
}

CArmAngles c_arm_angles(const Vec3& to_detector) {
  const double across = std::hypot(to_detector.x, to_detector.y);
  const double primary = across > 0.0 ? std::atan2(to_detector.x, -to_detector.y) : 0.0;
  return {primary / kRadians, std::atan2(to_detector.z, across) / kRadians};
}

double angle_between(const CArmAngles& a, const CArmAngles& b) {
  const double cosine = dot(c_arm_axes(a).to_detector, c_arm_axes(b).to_detector);
  return std::acos(std::clamp(cosine, -1.0, 1.0)) / kRadians;
}

double angle_between_beams(const Vec3& a, const Vec3& b) {
  return std::acos(std::min(1.0, std::abs(dot(normalized(a), normalized(b))))) / kRadians;
}

std::string c_arm_label(const CArmAngles& angles) {
  const std::string primary = side(std::lround(angles.primary_degrees), "LAO", "RAO");
  const std::string secondary = side(std::lround(angles.secondary_degrees), "CRA", "CAU");
  return (primary.empty() ? "AP" : primary) + (secondary.empty() ? "" : " " + secondary);
}

}  // namespace angio::angiogram
