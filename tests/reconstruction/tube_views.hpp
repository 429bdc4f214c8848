#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "angiogram/cone_beam.hpp"
#include "core/units.hpp"
#include "core/vec3.hpp"
#include "reconstruction/reconstruction.hpp"

/// Straight vessels, projected by steps along the rays.
namespace angio::reconstruction {

/// A tube of round section around a straight line, narrowed in its middle.
struct Tube {
  Vec3 from, to;
  double radius = 1.5, throat = 1.5;
  [[nodiscard]] double radius_at(double part) const {
    const double away = std::abs(part - 0.5) / 0.1;
    return away < 1.0 ? throat + (radius - throat) * 0.5 * (1.0 - std::cos(units::kPi * away))
                      : radius;
  }
};

/// A ray, and where it is nearest to a tube's axis.
struct TubeRay {
  Vec3 source, ray;
  double nearest = 0.0;
};

inline TubeRay ray_at(const Tube& tube, const Vec3& source, const Vec3& pixel) {
  const Vec3 ray = normalized(pixel - source), along = normalized(tube.to - tube.from),
             between = tube.from - source;
  const double b = dot(ray, along), d = dot(ray, between), e = dot(along, between);
  return {source, ray, (d - b * e) / std::max(1e-12, 1.0 - b * b)};
}

inline bool is_within(const Tube& tube, const Vec3& place) {
  const Vec3 axis = tube.to - tube.from;
  const double part = dot(place - tube.from, axis) / dot(axis, axis);
  return part >= 0.0 && part <= 1.0 && norm(place - tube.from - part * axis) < tube.radius_at(part);
}

/// How much of a ray lies within the tubes [mm], where they meet once: by steps along the ray.
inline double way_through(const std::vector<Tube>& tubes, const Vec3& source, const Vec3& pixel) {
  constexpr double kStep = 0.05, kReach = 8.0;
  double way = 0.0;
  for (std::size_t n = 0; n < tubes.size(); ++n) {
    const TubeRay ray = ray_at(tubes[n], source, pixel);
    for (double t = ray.nearest - kReach; t < ray.nearest + kReach; t += kStep) {
      const Vec3 place = source + t * ray.ray;
      const auto holds = [&](const Tube& tube) { return is_within(tube, place); };
      if (holds(tubes[n]) && std::none_of(tubes.begin(), tubes.begin() + std::ptrdiff_t(n), holds))
        way += kStep;
    }
  }
  return way;
}

inline angiogram::ConeBeamFrame frame_at(double primary, double secondary) {
  angiogram::CArmMount mount;
  mount.columns = mount.rows = 140;
  mount.column_spacing_mm = mount.row_spacing_mm = 0.6;
  mount.central_column = mount.central_row = 69.5;
  return angiogram::c_arm_frame({primary, secondary}, mount);
}

/// Pictures of tubes, linear in the beam, with a noise of a hundredth that is the same each time.
class TubePictures : public FrameReader {
 public:
  TubePictures(const std::vector<Tube>& tubes,
               const std::vector<angiogram::ConeBeamFrame>& frames) {
    unsigned state = 1;
    for (const auto& frame : frames)
      for (int row = 0; row < frame.rows; ++row)
        for (int column = 0; column < frame.columns; ++column) {
          const double way = way_through(tubes, frame.source, frame.place(column, row));
          state = state * 1664525U + 1013904223U;
          const double noise = 1.0 + 0.017 * (double(state >> 8U) / double(1U << 24U) - 0.5) * 2.0;
          pixels_.push_back(float(40000.0 * noise * std::exp(-0.08 * way)));
        }
    per_frame_ = pixels_.size() / frames.size();
  }
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    const auto begin = pixels_.begin() + std::ptrdiff_t(std::size_t(first) * per_frame_);
    return {begin, begin + std::ptrdiff_t(std::size_t(count) * per_frame_)};
  }

 private:
  std::vector<float> pixels_;
  std::size_t per_frame_ = 0;
};

}  // namespace angio::reconstruction
