#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "simulation/run/success.hpp"
#include "simulation/step/make_views.hpp"
#include "testing/simulation/models.hpp"

namespace angio::simulation::detail {
namespace {

SimulationModel stenosed_tube() { return testing::make_model({}); }

struct Watched {
  SimulationModel model = stenosed_tube();
  SimulationOptions options;
  Scene scene = make_scene(model, options);
  State state = start_state(scene, 1e5);
  SuccessWatch watch{scene, model, options};

  SimulationFrame frame(int number) const {
    SimulationFrame frame;
    frame.frame = number;
    frame.phase = Phase::inflate;
    return frame;
  }
  void watch_frame(const SimulationFrame& frame) { watch.judge(watch.look(state), frame); }
  double peak() const { return units::pascal_from_atm(options.inflation.peak_pressure_atm); }
};

TEST(SuccessWatch, OfARunThatEndsRightSaysNothing) {
  Watched t;
  for (double& p : t.state.contact_pressure) p = 1.5 * t.peak();
  SimulationFrame frame = t.frame(3);
  frame.residual = 0.1;
  for (int i = 0; i < 10; ++i) t.watch_frame(frame);
  EXPECT_EQ(t.watch.failure(), "");
  EXPECT_NEAR(t.watch.worst_pressure_ratio(), 1.5, 1e-9);
}

TEST(SuccessWatch, ACrossingIsAFailureThatNamesItsFrame) {
  Watched t;
  SimulationFrame frame = t.frame(21);
  frame.contact.max_penetration_mm = 1e-3;
  t.watch_frame(frame);
  t.watch_frame(t.frame(22));
  EXPECT_NE(t.watch.failure().find("frame 21"), std::string::npos) << t.watch.failure();
  EXPECT_NE(t.watch.failure().find("cross"), std::string::npos);
}

TEST(SuccessWatch, APatchUnderPressureIsAFailureAndASliverIsNot) {
  Watched sliver;
  sliver.state.contact_pressure[100] = 20.0 * sliver.peak();
  sliver.watch_frame(sliver.frame(1));
  EXPECT_EQ(sliver.watch.failure(), "");
  Watched patch;
  for (double& p : patch.state.contact_pressure) p = 6.0 * patch.peak();
  patch.watch_frame(patch.frame(1));
  EXPECT_NE(patch.watch.failure().find("6.0 times"), std::string::npos) << patch.watch.failure();
}

// The greatest patch pressure of a band around a tube's middle, whose pressure falls off along the
// tube within a third of the radius.
double pressure_of_a_band(int rings, int around) {
  testing::StenosedTube tube;
  tube.wall_rings = rings;
  tube.wall_around = around;
  const SimulationModel model = testing::make_model(tube);
  const Scene scene = make_scene(model, {});
  State state = start_state(scene, 1e5);
  const int first = scene.bodies.wall().first;
  for (std::size_t v = 0; v < state.contact_pressure.size(); ++v) {
    const double z = state.x[std::size_t(first) + v].z / (model.reference_radius_mm / 3.0);
    state.contact_pressure[v] = 1e5 * std::exp(-z * z);
  }
  return patch_pressure(scene, state, 0.5 * model.reference_radius_mm).pressure;
}

TEST(SuccessWatch, APatchsPressureDoesNotDependOnTheMesh) {
  const double fine = pressure_of_a_band(161, 64);
  EXPECT_NEAR(pressure_of_a_band(81, 32), fine, 0.1 * fine);
}

TEST(SuccessWatch, ForcesOffBalanceInAnyFrameAreAFailure) {
  Watched t;
  SimulationFrame open = t.frame(5);
  open.residual = 0.3;
  t.watch_frame(open);
  t.watch_frame(t.frame(6));
  EXPECT_NE(t.watch.failure().find("30 %"), std::string::npos) << t.watch.failure();
  EXPECT_NE(t.watch.failure().find("frame 5"), std::string::npos) << t.watch.failure();
}

TEST(SuccessWatch, DoesNotJudgeWhatIsForComparison) {
  Watched t;
  t.options.contact.model = ContactModel::paper;
  SuccessWatch watch(t.scene, t.model, t.options);
  SimulationFrame frame = t.frame(1);
  frame.contact.max_penetration_mm = 0.01;
  watch.judge(watch.look(t.state), frame);
  EXPECT_EQ(watch.failure(), "");
}

}  // namespace
}  // namespace angio::simulation::detail
