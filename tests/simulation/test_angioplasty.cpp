#include <gtest/gtest.h>
#include <omp.h>

#include "core/error.hpp"
#include "testing/simulation/models.hpp"
#include "testing/simulation/small_stenosis.hpp"

/// A balloon in a stenosed tube, from insertion to rest.
namespace angio::simulation {
namespace {

SimulationOptions quick() {
  SimulationOptions options;
  options.frame_s = 0.04;
  options.inflation.inflate_s = 1.2;
  options.inflation.hold_s = 0.4;
  options.inflation.deflate_s = 1.0;
  options.inflation.rest_s = 0.08;
  return options;
}

bool segment_meets_triangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b,
                            const Vec3& c) {  // Moeller and Trumbore 1997
  const Vec3 d = q - p, e1 = b - a, e2 = c - a, h = cross(d, e2);
  const double det = dot(e1, h);
  if (det == 0.0) return false;
  const Vec3 s = p - a, k = cross(s, e1);
  const double u = dot(s, h) / det, v = dot(d, k) / det, t = dot(e2, k) / det;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t <= 1.0;
}

int count_crossings(const std::vector<Vec3>& x, const std::vector<Triangle>& xs,
                    const std::vector<Vec3>& y, const std::vector<Triangle>& ys) {
  int count = 0;
  const auto at = [](const std::vector<Vec3>& p, int v) { return p[std::size_t(v)]; };
  for (const Triangle& s : xs)
    for (const Triangle& t : ys) {
      if (distance(at(x, s[0]), at(y, t[0])) > 2.5) continue;  // edges are shorter than 1 mm
      for (std::size_t k = 0; k < 3; ++k) {
        count += segment_meets_triangle(at(x, s[k]), at(x, s[(k + 1) % 3]), at(y, t[0]),
                                        at(y, t[1]), at(y, t[2]));
        count += segment_meets_triangle(at(y, t[k]), at(y, t[(k + 1) % 3]), at(x, s[0]),
                                        at(x, s[1]), at(x, s[2]));
      }
    }
  return count;
}

struct Course {
  SimulationSummary summary;
  std::vector<SimulationFrame> frames;

  [[nodiscard]] const SimulationFrame& peak() const {
    return frames[std::size_t(summary.peak_frame)];
  }
};

Course run(const SimulationModel& model, const SimulationOptions& options) {
  Course course;
  course.summary =
      simulate(model, options, [&](const SimulationFrame& f) { course.frames.push_back(f); });
  return course;
}

// Narrowest mean radius of the wall's rings (each ring of the model has one z at the start).
double throat_radius(const SimulationFrame& frame, int around) {
  double least = 1e9;
  for (std::size_t ring = 0; ring < frame.wall.size(); ring += std::size_t(around)) {
    double sum = 0.0;
    for (std::size_t k = 0; k < std::size_t(around); ++k)
      sum += std::hypot(frame.wall[ring + k].x, frame.wall[ring + k].y);
    least = std::min(least, sum / around);
  }
  return least;
}

class Angioplasty : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    model_ = new SimulationModel(testing::make_model(testing::small_stenosis()));
    course_ = new Course(run(*model_, quick()));
  }
  static void TearDownTestSuite() {
    delete course_;
    delete model_;
  }
  static SimulationModel* model_;
  static Course* course_;
};
SimulationModel* Angioplasty::model_ = nullptr;
Course* Angioplasty::course_ = nullptr;

TEST_F(Angioplasty, OpensTheThroatAndLeavesItOpen) {
  const double before = throat_radius(course_->frames.front(), 20);
  const double peak = throat_radius(course_->peak(), 20);
  const double after = throat_radius(course_->frames.back(), 20);
  EXPECT_GT(peak, 1.5 * before);
  EXPECT_GT(after, 1.2 * before);
  EXPECT_LT(after, peak);  // recoil: some comes back, not all
  EXPECT_GT(peak - after, 0.05 * peak);
}

TEST_F(Angioplasty, TheThroatNeverNarrowsWhileTheBalloonFills) {
  double before = 0.0;
  for (const SimulationFrame& f : course_->frames) {
    if (f.phase != Phase::inflate) continue;
    const double now = throat_radius(f, 20);
    EXPECT_GT(now, before - 0.02);
    before = now;
  }
}

TEST_F(Angioplasty, NoTriangleOfTheBalloonEverCrossesOneOfTheWall) {
  for (const SimulationFrame& f : course_->frames) {
    EXPECT_EQ(f.contact.max_penetration_mm, 0.0) << f.frame;
    if (f.frame % 6 == 0) {
      EXPECT_EQ(
          count_crossings(f.balloon, model_->balloon.triangles, f.wall, model_->wall.triangles), 0)
          << f.frame;
    }
  }
}

TEST_F(Angioplasty, ReachesThePeakPressureAndReturnsToTheStartVolume) {
  const SimulationSummary& s = course_->summary;
  EXPECT_NEAR(s.peak_pressure_atm, 8.0, 0.08);
  EXPECT_EQ(s.frame_count, int(course_->frames.size()));
  const SimulationFrame &first = course_->frames.front(), &last = course_->frames.back();
  EXPECT_NEAR(last.balloon_volume_mm3, first.balloon_volume_mm3, 0.02 * first.balloon_volume_mm3);
  EXPECT_NEAR(last.pressure_atm, 0.0, 0.02);
}

TEST_F(Angioplasty, FixedVerticesStayAndFramesAreComplete) {
  for (const SimulationFrame& f : course_->frames) {
    ASSERT_EQ(f.wall.size(), model_->wall.vertices.size());
    ASSERT_EQ(f.contact_pressure_kpa.size(), f.wall.size());
    ASSERT_EQ(f.plastic_strain.size(), f.wall.size());
    ASSERT_EQ(f.membrane.thickness_mm.size(), f.balloon.size());
    for (std::size_t v = 0; v < f.wall.size(); ++v)
      if (model_->wall_fixed[v]) {
        EXPECT_EQ(f.wall[v], model_->wall.vertices[v]);
      }
    for (std::size_t v = 0; v < f.balloon.size(); ++v)
      if (model_->balloon_fixed[v]) {
        EXPECT_EQ(f.balloon[v], model_->balloon.vertices[v]);
      }
  }
}

TEST_F(Angioplasty, FrictionAndContactAreThereOnlyWhileTheyTouch) {
  EXPECT_EQ(course_->frames.front().contact.friction_delta_mm, 0.0);
  EXPECT_EQ(course_->frames.front().contact.count, 0);
  EXPECT_GT(course_->peak().contact.count, 50);
  double most = 0.0;
  for (const SimulationFrame& f : course_->frames) {
    most = std::max(most, f.contact.friction_delta_mm);
    if (f.contact.count == 0 && f.phase == Phase::rest) {
      EXPECT_EQ(f.contact.friction_delta_mm, 0.0);
    }
  }
  EXPECT_GT(most, 0.0);
}

TEST_F(Angioplasty, AdhesionActsAfterTheFirstTouchAndMostWhileTheSurfacesPart) {
  double before_touch = 0.0, pressed = 0.0, parting = 0.0;
  bool touched = false;
  for (const SimulationFrame& f : course_->frames) {
    if (!touched) before_touch = std::max(before_touch, f.contact.viscous_delta_mm);
    touched = touched || f.contact.count > 0;
    if (f.phase == Phase::hold) pressed = std::max(pressed, f.contact.viscous_delta_mm);
    if (f.phase == Phase::deflate) parting = std::max(parting, f.contact.viscous_delta_mm);
  }
  EXPECT_EQ(before_touch, 0.0);
  EXPECT_GT(parting, 2.0 * pressed);
  EXPECT_LT(course_->frames.back().contact.viscous_delta_mm, parting);
}

TEST(AngioplastyRuns, GiveTheSameBitsForOneAndTwoThreads) {
  testing::StenosedTube p = testing::small_stenosis();
  p.balloon_rings = 13;
  p.balloon_around = 12;
  p.wall_rings = 31;
  p.wall_around = 14;
  const SimulationModel model = testing::make_model(p);
  SimulationOptions options = quick();
  options.sweeps = 5;
  options.inflation.inflate_s = 0.24;
  options.inflation.hold_s = options.inflation.rest_s = 0.0;
  options.inflation.deflate_s = 0.08;
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const Course one = run(model, options);
  omp_set_num_threads(2);
  const Course two = run(model, options);
  omp_set_num_threads(threads);
  ASSERT_EQ(one.frames.size(), two.frames.size());
  for (std::size_t f = 0; f < one.frames.size(); ++f) {
    ASSERT_EQ(one.frames[f].balloon, two.frames[f].balloon) << f;
    ASSERT_EQ(one.frames[f].wall, two.frames[f].wall) << f;
    ASSERT_EQ(one.frames[f].contact.friction_delta_mm, two.frames[f].contact.friction_delta_mm)
        << f;
  }
}

// Mean radius of the ring that was the narrowest at the start: the narrowest of all may later be
// one that nothing touches.
double stretched_radius(const Course& course, int around) {
  const auto mean = [&](const SimulationFrame& f, std::size_t ring) {
    double sum = 0.0;
    for (std::size_t k = 0; k < std::size_t(around); ++k)
      sum += std::hypot(f.wall[ring + k].x, f.wall[ring + k].y);
    return sum / around;
  };
  const SimulationFrame& first = course.frames.front();
  std::size_t throat = 0;
  for (std::size_t ring = 0; ring < first.wall.size(); ring += std::size_t(around))
    if (mean(first, ring) < mean(first, throat)) throat = ring;
  return mean(course.peak(), throat);
}

// The throat at peak with one thing changed.
double throat_with(const SimulationModel& model, SimulationOptions options) {
  options.inflation.deflate_s = options.frame_s;
  options.inflation.rest_s = 0.0;
  const Course course = run(model, options);
  return stretched_radius(course, 20);
}

TEST(AngioplastyRuns, ThroatHardlyDependsOnNumericalChoices) {
  const SimulationModel model = testing::make_model(testing::small_stenosis());
  const SimulationOptions base = quick();
  const double throat = throat_with(model, base);
  SimulationOptions thin = base;
  thin.contact.distance_mm = 0.5 * base.contact.distance_mm;
  EXPECT_NEAR(throat_with(model, thin), throat, base.contact.distance_mm);
  SimulationOptions fine = base;
  fine.frame_s = 0.5 * base.frame_s;
  EXPECT_NEAR(throat_with(model, fine), throat, 0.01 * throat);
}

TEST(AngioplastyRuns, RefuseABalloonThatCrossesTheWall) {
  testing::StenosedTube p = testing::small_stenosis();
  p.start_radius = 1.0;
  EXPECT_THROW(simulate(testing::make_model(p), quick(), {}), InputError);
}

}  // namespace
}  // namespace angio::simulation
