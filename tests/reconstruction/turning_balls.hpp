#pragma once

#include <cmath>
#include <vector>

#include "reconstruction/reconstruction.hpp"

/// Runs around balls, whose line integrals are known.
namespace angio::reconstruction::tests {

struct Ball {
  Vec3 middle;
  double radius = 1.0;
  double attenuation = 0.1;  ///< [1/mm]
};

inline double line_integral(const std::vector<Ball>& balls, const Vec3& from, const Vec3& to) {
  const Vec3 ray = normalized(to - from);
  double sum = 0.0;
  for (const Ball& ball : balls) {
    const double d = norm(cross(ball.middle - from, ray));
    if (d < ball.radius)
      sum += 2.0 * ball.attenuation * std::sqrt(ball.radius * ball.radius - d * d);
  }
  return sum;
}

/// What a detector measures: the mean beam over each pixel.
class PicturesOfBalls : public FrameReader {
 public:
  PicturesOfBalls(std::vector<angiogram::ConeBeamFrame> frames, std::vector<Ball> balls,
                  double air = 10000.0)
      : frames_(std::move(frames)), balls_(std::move(balls)), air_(air) {}

  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    std::vector<float> pixels;
    for (int f = first; f < first + count; ++f) {
      const auto& frame = frames_[std::size_t(f)];
      for (int row = 0; row < frame.rows; ++row)
        for (int c = 0; c < frame.columns; ++c) pixels.push_back(float(air_ * beam(frame, c, row)));
    }
    return pixels;
  }

 private:
  [[nodiscard]] double beam(const angiogram::ConeBeamFrame& frame, int column, int row) const {
    double sum = 0.0;
    for (const double dc : {-0.25, 0.25})
      for (const double dr : {-0.25, 0.25})
        sum += 0.25 *
               std::exp(-line_integral(balls_, frame.source, frame.place(column + dc, row + dr)));
    return sum;
  }
  std::vector<angiogram::ConeBeamFrame> frames_;
  std::vector<Ball> balls_;
  double air_;
};

/// A turn from one primary angle to another.
inline std::vector<angiogram::ConeBeamFrame> turn(int count, double from_degrees, double to_degrees,
                                                  int columns = 96, int rows = 64,
                                                  double secondary_degrees = 0.0) {
  angiogram::CArmMount mount;
  mount.columns = columns;
  mount.rows = rows;
  mount.column_spacing_mm = mount.row_spacing_mm = 0.75;  // 0.5 mm at the isocentre
  mount.central_column = 0.5 * (columns - 1);
  mount.central_row = 0.5 * (rows - 1);
  std::vector<angiogram::ConeBeamFrame> frames;
  for (int f = 0; f < count; ++f)
    frames.push_back(angiogram::c_arm_frame(
        {from_degrees + (to_degrees - from_degrees) * f / (count - 1), secondary_degrees}, mount));
  return frames;
}

}  // namespace angio::reconstruction::tests
