#include <gtest/gtest.h>
#include <omp.h>

#include <atomic>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/error.hpp"
#include "simulation/guard.hpp"
#include "testing/simulation/layered.hpp"
#include "testing/simulation/small_stenosis.hpp"

/// The second run beside the first one, and what a wall gives back.
namespace angio::simulation {
namespace {

SimulationModel small_model() {
  testing::StenosedTube p = testing::small_stenosis();
  p.balloon_rings = 13;
  p.balloon_around = 12;
  p.wall_rings = 31;
  p.wall_around = 14;
  return testing::make_model(p);
}

SimulationOptions short_course() {
  SimulationOptions options;
  options.backend = Backend::cpu;
  options.frame_s = 0.04;
  options.inflation.inflate_s = 0.24;
  options.inflation.hold_s = options.inflation.rest_s = 0.0;
  options.inflation.deflate_s = 0.08;
  return options;
}

using Walls = std::vector<std::vector<Vec3>>;

FrameSink into(Walls& walls) {
  return [&walls](const SimulationFrame& frame) { walls.push_back(frame.wall); };
}

class Threads {
 public:
  explicit Threads(int count) : before_(omp_get_max_threads()) { omp_set_num_threads(count); }
  ~Threads() { omp_set_num_threads(before_); }
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

 private:
  int before_;
};

TEST(Disturbed, MovesWhatMayMoveByLittleAndTheRestShapeWithIt) {
  const SimulationModel model = testing::layered_model();
  Disturbance by;
  by.move_mm = 0.01;
  const SimulationModel moved = disturbed(model, by);
  double largest = 0.0;
  for (std::size_t v = 0; v < model.balloon.vertices.size(); ++v) {
    const Vec3 move = moved.balloon.vertices[v] - model.balloon.vertices[v];
    EXPECT_NEAR(norm(move - (moved.balloon_rest[v] - model.balloon_rest[v])), 0.0, 1e-15);
    for (int k = 0; k < 3; ++k) EXPECT_LE(std::abs(move[k]), 0.01 + 1e-15);
    largest = std::max(largest, norm(move));
    EXPECT_EQ(norm(move) == 0.0, model.balloon_fixed[v] != 0) << v;
  }
  EXPECT_GT(largest, 0.008);
  const std::size_t columns = model.wall.vertices.size();
  for (std::size_t v = 0; v < model.layered_wall.vertices.size(); ++v) {
    const Vec3 move = moved.wall.vertices[v % columns] - model.wall.vertices[v % columns];
    EXPECT_NEAR(norm(moved.layered_wall.vertices[v] - model.layered_wall.vertices[v] - move), 0.0,
                1e-14);
    EXPECT_EQ(norm(move) == 0.0, model.wall_fixed[v % columns] != 0) << v;
  }
  Disturbance again = by, other = by;
  other.seed = 2;
  EXPECT_EQ(disturbed(model, again).wall.vertices, moved.wall.vertices);
  EXPECT_NE(disturbed(model, other).wall.vertices, moved.wall.vertices);
}

TEST(Guard, LeavesTheFirstRunAsItIsHoweverTheThreadsAreShared) {
  const SimulationModel model = small_model();
  const SimulationOptions options = short_course();
  Walls alone;
  simulate(model, options, into(alone));
  std::vector<Walls> seconds;
  for (const int threads : {1, 2, 3}) {
    const Threads set(threads);
    Walls first, second;
    const GuardedSummary both = simulate_guarded(model, options, {}, into(first), into(second));
    EXPECT_EQ(omp_get_max_threads(), threads);
    EXPECT_EQ(first, alone) << threads;
    EXPECT_EQ(both.second_failure, "");
    ASSERT_TRUE(both.second);
    EXPECT_EQ(both.second->frame_count, both.first.frame_count);
    seconds.push_back(std::move(second));
  }
  EXPECT_EQ(seconds[0], seconds[1]);
  EXPECT_EQ(seconds[0], seconds[2]);
  ASSERT_EQ(seconds[0].size(), alone.size());
  EXPECT_NE(seconds[0].back(), alone.back());
}

TEST(Guard, FindsALayeredWallsPreStressForBothRunsAndLeavesTheFirstAsItIs) {
  const SimulationModel model = testing::layered_model();
  SimulationOptions options = testing::layered_options();
  options.inflation = short_course().inflation;
  Walls alone, first, second;
  simulate(model, options, into(alone));
  const Threads two(2);
  const GuardedSummary both = simulate_guarded(model, options, {}, into(first), into(second));
  EXPECT_EQ(first, alone);
  EXPECT_EQ(both.second_failure, "");
  ASSERT_EQ(second.size(), first.size());
  EXPECT_NE(second.back(), first.back());
}

TEST(Guard, OfNoDisturbanceIsTheSameRunTwice) {
  const SimulationModel model = small_model();
  Walls first, second;
  simulate_guarded(model, short_course(), {0.0, 1.0, 1}, into(first), into(second));
  EXPECT_EQ(first, second);
}

TEST(Guard, ReportsOneProgressThatNeverFalls) {
  const SimulationModel model = small_model();
  for (const int threads : {1, 2}) {
    const Threads set(threads);
    std::vector<double> told;
    simulate_guarded(
        model, short_course(), {}, {}, {},
        Progress([&](double fraction, std::string_view) { told.push_back(fraction); }));
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end())) << threads;
    EXPECT_NEAR(told.back(), 1.0, 1e-12) << threads;
  }
}

TEST(Guard, StopsBothRunsWhenItIsInterrupted) {
  const SimulationModel model = small_model();
  for (const int threads : {1, 2})
    for (const double until : {0.2, 0.7}) {
      const Threads set(threads);
      EXPECT_THROW(simulate_guarded(model, short_course(), {}, {}, {},
                                    Progress([&](double fraction, std::string_view) {
                                      if (fraction >= until) throw Interrupted();
                                    })),
                   Interrupted)
          << threads << " " << until;
    }
}

TEST(Guard, SaysWhyTheSecondRunGaveNothing) {
  const SimulationModel model = small_model();
  // So far aside that the balloon's start crosses the wall or itself: no start at all.
  for (const int threads : {1, 2}) {
    const Threads set(threads);
    Walls first;
    const GuardedSummary both =
        simulate_guarded(model, short_course(), {2.0, 1.0, 1}, into(first), {});
    EXPECT_NE(both.second_failure, "") << threads;
    EXPECT_EQ(both.first.failure, "");
    EXPECT_EQ(int(first.size()), both.first.frame_count);
  }
}

TEST(Guard, PassesOnWhyTheFirstRunCannotBegin) {
  testing::StenosedTube p = testing::small_stenosis();
  p.start_radius = 1.0;  // wider than the throat
  const SimulationModel model = testing::make_model(p);
  for (const int threads : {1, 2}) {
    const Threads set(threads);
    EXPECT_THROW(simulate_guarded(model, short_course(), {}, {}, {}), InputError);
  }
}

// ---- what a wall gives back --------------------------------------------------------------------

// Mean diameter of the ring in the middle of the model's tube, through its vertices.
double middle_diameter(const SimulationModel& model, const std::vector<Vec3>& wall) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t v = 0; v < wall.size(); ++v)
    if (std::abs(model.wall.vertices[v].z) < 1e-9) {
      sum += 2.0 * std::hypot(wall[v].x, wall[v].y);
      ++count;
    }
  return sum / count;
}

struct Diameters {
  double before = 0.0, peak = 0.0, after = 0.0, balloon = 0.0, gap = 0.0;
  [[nodiscard]] double recoil() const { return peak - after; }
};

// A healthy tube of 3 mm, widened by a balloon of 3.4 mm and let go.
Diameters widen(const WallMaterial& wall) {
  testing::StenosedTube p = testing::small_stenosis();
  p.stenosis = 0.0;
  p.nominal_radius = 1.7;
  const SimulationModel model = testing::make_model(p);
  SimulationOptions options;
  options.backend = Backend::cpu;
  options.frame_s = 0.04;
  options.wall = wall;
  options.contact.adhesion_traction_kpa = 0.0;  // else it pulls a wall that flows back inwards
  options.inflation.inflate_s = 1.2;
  options.inflation.hold_s = 0.4;
  options.inflation.deflate_s = 1.0;
  options.inflation.rest_s = 1.0;
  Diameters found;
  found.before = middle_diameter(model, model.wall.vertices);
  double pressure = -1.0;
  const SimulationSummary summary = simulate(model, options, [&](const SimulationFrame& f) {
    found.after = middle_diameter(model, f.wall);
    if (f.pressure_atm < pressure) return;
    pressure = f.pressure_atm;
    found.peak = found.after;
    found.balloon = f.balloon_diameter_mm;
    found.gap = contact_gap_mm(model, f);
  });
  EXPECT_EQ(summary.failure, "");
  return found;
}

TEST(Recoil, OfAWallThatOnlyFlowsIsNone) {
  WallMaterial plastic;
  plastic.yield_strain = 0.002;
  plastic.creep_per_s = 1000.0;
  plastic.foundation_kpa_per_mm = 0.0;
  const Diameters found = widen(plastic);
  ASSERT_GT(found.peak, found.before + 0.3);
  EXPECT_NEAR(found.recoil(), 0.0, 0.01);
  // Against the balloon itself the gap would be counted as lumen: a negative recoil.
  EXPECT_GT(found.after, found.balloon);
}

TEST(Recoil, OfAnElasticWallIsBackToTheStart) {
  WallMaterial elastic;
  elastic.yield_strain = 10.0;
  const Diameters found = widen(elastic);
  ASSERT_GT(found.peak, found.before + 0.3);
  EXPECT_NEAR(found.after, found.before, 0.02);
  EXPECT_NEAR(found.recoil(), found.peak - found.before, 0.02);
}

TEST(ContactGap, IsThatOfTwoPlanesWhereTheyAreForcedTogether) {
  SimulationModel model;
  model.balloon.vertices = {{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}};
  model.balloon.triangles = {{0, 1, 2}};
  model.wall.vertices = {{-1, -1, 0.02}, {1, -1, 0.02}, {1, 1, 0.02}, {-1, 1, 0.5}};
  model.wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  SimulationFrame frame;
  frame.balloon = model.balloon.vertices;
  frame.wall = model.wall.vertices;
  frame.contact_pressure_kpa = {100.0, 200.0, 300.0, 0.0};
  EXPECT_NEAR(contact_gap_mm(model, frame), 0.02, 1e-12);
  frame.contact_pressure_kpa.assign(4, 0.0);
  EXPECT_EQ(contact_gap_mm(model, frame), 0.0);
}

}  // namespace
}  // namespace angio::simulation
