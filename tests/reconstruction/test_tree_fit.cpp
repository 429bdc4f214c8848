#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "angiogram/cone_beam.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "reconstruction/detail/self_calibration.hpp"
#include "reconstruction/tree_fit.hpp"

namespace angio::reconstruction {
namespace {

using angiogram::ConeBeamFrame;

constexpr double kContrast = 0.1;

/// A tube around the z axis, moved and turned, with a stenosis; and what is behind it.
struct Tube {
  Vec3 middle;
  double radius = 1.5, narrowing = 0.0;
  double half_length = 25.0;
  [[nodiscard]] double radius_at(double z) const {
    constexpr double kHalfLesion = 6.0;
    if (std::abs(z) >= kHalfLesion) return radius;
    return radius * (1.0 - 0.5 * narrowing * (1.0 + std::cos(units::kPi * z / kHalfLesion)));
  }
};

/// The way of a ray through it: where it is at right angles to the axis exact, else by steps.
double way_through(const Tube& tube, const Vec3& from, const Vec3& direction) {
  const Vec3 start = from - tube.middle;
  const double flat = std::hypot(direction.x, direction.y);
  const double nearest = -(start.x * direction.x + start.y * direction.y) / (flat * flat);
  const auto inside = [&](double t) {
    const Vec3 at = start + t * direction;
    const double r = tube.radius_at(at.z);
    return r * r - at.x * at.x - at.y * at.y;
  };
  if (inside(nearest) <= 0.0) return 0.0;
  const auto border = [&](double sign) {
    double in = 0.0, out = 3.0 * tube.radius / flat;
    for (int n = 0; n < 60; ++n) {
      const double between = 0.5 * (in + out);
      (inside(nearest + sign * between) > 0.0 ? in : out) = between;
    }
    return in;
  };
  return border(1.0) + border(-1.0);
}

double mean_way(const Tube& tube, const ConeBeamFrame& frame, int column, int row) {
  constexpr int kRays = 6;
  double sum = 0.0;
  for (int a = 0; a < kRays; ++a)
    for (int b = 0; b < kRays; ++b) {
      const Vec3 to = frame.place(column + (a + 0.5) / kRays - 0.5, row + (b + 0.5) / kRays - 0.5);
      sum += way_through(tube, frame.source, normalized(to - frame.source));
    }
  return sum / (kRays * kRays);
}

/// Logarithms of the beam, the mean of 6 x 6 rays a pixel, behind a wedge; noise is added later.
class TubePictures : public FrameReader {
 public:
  TubePictures(const std::vector<ConeBeamFrame>& frames, const Tube& tube)
      : size_(std::size_t(frames.front().columns * frames.front().rows)) {
    for (const ConeBeamFrame& frame : frames)
      for (int row = 0; row < frame.rows; ++row)
        for (int c = 0; c < frame.columns; ++c)
          pixels_.push_back(-kContrast * mean_way(tube, frame, c, row) - 0.4 - 0.002 * c);
  }
  void make_noise(double sd, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0.0, sd);
    noise_.resize(pixels_.size());
    for (double& noise : noise_) noise = normal(random);
  }
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    std::vector<float> values;
    for (std::size_t p = std::size_t(first) * size_; p < std::size_t(first + count) * size_; ++p)
      values.push_back(float(pixels_[p] + (noise_.empty() ? 0.0 : noise_[p])));
    return values;
  }

 private:
  std::size_t size_;
  std::vector<double> pixels_, noise_;
};

std::vector<ConeBeamFrame> views(const std::vector<angiogram::CArmAngles>& angles) {
  angiogram::CArmMount mount;
  mount.columns = 96;
  mount.rows = 128;
  mount.column_spacing_mm = mount.row_spacing_mm = 0.45;  // 0.3 mm at the isocentre
  mount.central_column = 47.5;
  mount.central_row = 63.5;
  std::vector<ConeBeamFrame> frames;
  for (const auto& a : angles) frames.push_back(angiogram::c_arm_frame(a, mount));
  return frames;
}

/// A line beside the tube's axis, of one radius.
CenterlineTree start_near(const Tube& tube, const Vec3& beside, double radius) {
  CenterlineTree tree;
  CenterlinePath& path = tree.paths.emplace_back();
  for (double z = -16.0; z <= 16.0; z += 0.4) {
    path.points.push_back(tube.middle + beside + Vec3{0.2 * std::sin(0.2 * z), 0.0, z});
    path.inscribed_radius.push_back(radius);
  }
  path.abscissa = arc_length(path.points);
  path.section_area.assign(path.points.size(), 0.0);
  path.equivalent_radius = path.inscribed_radius;
  return tree;
}

RotationalRun run_of(const std::vector<ConeBeamFrame>& frames, const FrameReader& pictures) {
  RotationalRun run;
  run.frames = frames;
  run.pictures = &pictures;
  run.relation = PixelRelation::logarithmic;
  return run;
}

TEST(TreeFitOptions, DefaultsAreValid) {
  EXPECT_NO_THROW(TreeFitOptions{}.validate());
  TreeFitOptions options;
  options.frame_shift_sd_mm = -1.0;
  EXPECT_THROW(options.validate(), OptionError);
}

double worst_radius(const TreeFit& fit, const Tube& tube) {
  double worst = 0.0;
  const CenterlinePath& path = fit.tree.paths[0];
  for (std::size_t n = 0; n < path.points.size(); ++n) {
    const double z = path.points[n].z - tube.middle.z;
    if (std::abs(z) < 12.0)
      worst = std::max(worst, std::abs(path.equivalent_radius[n] - tube.radius_at(z)));
  }
  return worst;
}

double worst_place(const TreeFit& fit, const Tube& tube) {
  double worst = 0.0;
  for (const Vec3& point : fit.tree.paths[0].points)
    if (std::abs(point.z - tube.middle.z) < 12.0)
      worst = std::max(worst, std::hypot(point.x - tube.middle.x, point.y - tube.middle.y));
  return worst;
}

TEST(FitTree, FindsAKnownTubeWithoutNoise) {
  const Tube tube{{0.3, -0.2, 1.0}, 1.5, 0.0, 25.0};
  const auto frames = views({{-60.0, 0.0}, {0.0, 0.0}, {50.0, 0.0}});
  const TubePictures pictures(frames, tube);
  TreeFitOptions options;
  options.frame_shift_sd_mm = 0.0;
  const TreeFit fit =
      fit_tree(run_of(frames, pictures), 0.0, start_near(tube, {0.5, -0.4, 0.0}, 1.1), options);
  EXPECT_TRUE(fit.converged);
  EXPECT_LT(worst_radius(fit, tube), 0.002);
  EXPECT_LT(worst_place(fit, tube), 0.002);
  for (const double contrast : fit.contrast_per_mm) EXPECT_NEAR(contrast, kContrast, 3e-4);
  EXPECT_NEAR(fit.blur_pixels, 1.0, 0.1);  // a pixel's own aperture
}

TEST(FitTree, FindsAStenosisFarFromTheIsocentre) {
  const Tube tube{{4.0, -7.0, 3.0}, 1.5, 0.6, 25.0};
  const auto frames = views({{-60.0, 15.0}, {-15.0, -10.0}, {30.0, 5.0}, {70.0, 20.0}});
  const TubePictures pictures(frames, tube);
  const TreeFit fit =
      fit_tree(run_of(frames, pictures), 0.0, start_near(tube, {0.3, 0.3, 0.0}, 1.2), {});
  EXPECT_LT(worst_radius(fit, tube), 0.02);
  EXPECT_LT(worst_place(fit, tube), 0.05);
  const auto& radius = fit.tree.paths[0].equivalent_radius;
  EXPECT_NEAR(*std::min_element(radius.begin(), radius.end()), 0.6, 0.01);
}

TEST(FitTree, FindsFramesThatStandBesideWhereTheySay) {
  const Tube tube{{0.0, 0.0, 0.0}, 1.4, 0.5, 25.0};
  const auto frames = views({{-60.0, 0.0}, {-20.0, 0.0}, {20.0, 0.0}, {60.0, 0.0}});
  std::vector<ConeBeamFrame> real = frames;
  real[1] = detail::moved(frames[1], {{}, {0.6, 0.2, 0.0}});
  real[2] = detail::moved(frames[2], {{}, {-0.5, 0.2, 0.0}});
  TubePictures pictures(real, tube);
  pictures.make_noise(0.002, 1);
  TreeFitOptions options;
  options.frame_shift_sd_mm = 1.0;
  const TreeFit fit =
      fit_tree(run_of(frames, pictures), 0.0, start_near(tube, {0.2, 0.1, 0.0}, 1.2), options);
  EXPECT_LT(worst_radius(fit, tube), 0.03);
  const auto seen = [](const ConeBeamFrame& frame) {
    return angiogram::ConeBeamView(frame).see({0.0, 0.0, 0.0}).column;
  };
  const auto relative = [&](const std::vector<ConeBeamFrame>& at) {
    return seen(at[1]) - seen(frames[1]) - (seen(at[2]) - seen(frames[2]));
  };
  EXPECT_NEAR(relative(fit.frames), relative(real), 0.6);
}

TEST(FitTree, MeasuresAStenosisByTwoViewsThatStandBesideWhereTheySay) {
  const Tube tube{{1.0, 2.0, -1.0}, 1.5, 0.6, 25.0};
  const auto frames = views({{-30.0, 0.0}, {30.0, 10.0}});
  std::vector<ConeBeamFrame> real = frames;
  real[1] = detail::moved(frames[1], {{0.004, 0.0, 0.006}, {1.5, 0.5, -1.0}});
  TubePictures pictures(real, tube);
  pictures.make_noise(0.01, 3);
  TreeFitOptions options;
  options.frame_shift_sd_mm = 2.0;
  options.frame_turn_sd_degrees = 0.5;
  const TreeFit fit =
      fit_tree(run_of(frames, pictures), 0.0, start_near(tube, {0.5, 0.3, 0.0}, 1.2), options);
  const auto& radius = fit.tree.paths[0].tube_radius;
  EXPECT_NEAR(2.0 * *std::min_element(radius.begin(), radius.end()), 1.2, 0.1);
}

TEST(FitTree, ItsRadiiAreWrongByWhatItSays) {
  const Tube tube{{0.3, -0.2, 1.0}, 1.3, 0.5, 25.0};
  const auto frames = views({{-45.0, 0.0}, {0.0, 0.0}, {45.0, 0.0}});
  TubePictures pictures(frames, tube);
  double squares = 0.0;
  int count = 0;
  constexpr int kSeeds = 12;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    pictures.make_noise(0.01, unsigned(seed));
    const TreeFit fit =
        fit_tree(run_of(frames, pictures), 0.0, start_near(tube, {0.1, 0.1, 0.0}, 1.2), {});
    const CenterlinePath& path = fit.tree.paths[0];
    for (std::size_t n = 0; n < path.points.size(); n += 5) {
      const double z = path.points[n].z - tube.middle.z;
      if (std::abs(z) > 11.0) continue;
      // The ball of the truth, as the fit's.
      double ball = tube.radius_at(z);
      for (double t = -3.0; t <= 3.0; t += 0.01)
        ball = std::min(ball, std::hypot(t, tube.radius_at(z + t)));
      const double score = (path.tube_radius[n] - ball) / fit.radius_sd[0][n];
      squares += score * score;
      ++count;
    }
  }
  const double sd = std::sqrt(squares / count);
  RecordProperty("sd", std::to_string(sd));
  EXPECT_GT(sd, 0.75);
  EXPECT_LT(sd, 1.3);
}

TEST(FitTree, RefusesFramesWithoutTheVessel) {
  const Tube tube{{0.0, 0.0, 0.0}, 1.4, 0.0, 25.0};
  const auto frames = views({{0.0, 0.0}, {60.0, 0.0}});
  const TubePictures pictures(frames, tube);
  const Tube elsewhere{{200.0, 0.0, 0.0}, 1.4, 0.0, 25.0};
  EXPECT_THROW(fit_tree(run_of(frames, pictures), 0.0, start_near(elsewhere, {}, 1.2), {}),
               InputError);
}

}  // namespace
}  // namespace angio::reconstruction
