#include <gtest/gtest.h>

#include "core/units.hpp"
#include "simulation/detail/step_view.hpp"
#include "simulation/detail/success.hpp"
#include "tests/simulation/models.hpp"

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
  double peak() const { return units::pascal_from_atm(options.inflation.peak_pressure_atm); }
};

TEST(SuccessWatch, OfARunThatEndsRightSaysNothing) {
  Watched t;
  for (double& p : t.state.contact_pressure) p = 1.5 * t.peak();
  SimulationFrame frame = t.frame(3);
  frame.residual = 0.1;
  for (int i = 0; i < 10; ++i) t.watch.add(t.state, frame);
  EXPECT_EQ(t.watch.failure(), "");
  EXPECT_NEAR(t.watch.worst_pressure_ratio(), 1.5, 1e-9);
}

TEST(SuccessWatch, ACrossingIsAFailureThatNamesItsFrame) {
  Watched t;
  SimulationFrame frame = t.frame(21);
  frame.max_penetration_mm = 1e-3;
  t.watch.add(t.state, frame);
  t.watch.add(t.state, t.frame(22));
  EXPECT_NE(t.watch.failure().find("frame 21"), std::string::npos) << t.watch.failure();
  EXPECT_NE(t.watch.failure().find("cross"), std::string::npos);
}

TEST(SuccessWatch, APatchUnderPressureIsAFailureAndASliverIsNot) {
  Watched sliver;
  sliver.state.contact_pressure[100] = 20.0 * sliver.peak();
  sliver.watch.add(sliver.state, sliver.frame(1));
  EXPECT_EQ(sliver.watch.failure(), "");
  Watched patch;
  for (double& p : patch.state.contact_pressure) p = 6.0 * patch.peak();
  patch.watch.add(patch.state, patch.frame(1));
  EXPECT_NE(patch.watch.failure().find("6.0 times"), std::string::npos) << patch.watch.failure();
}

TEST(SuccessWatch, ForcesOffBalanceForSomeFramesOrAtTheEndAreAFailure) {
  Watched once, lasting, last;
  SimulationFrame open = once.frame(5);
  open.residual = 0.3;
  open.pressure_atm = once.options.inflation.peak_pressure_atm;
  once.watch.add(once.state, open);
  once.watch.add(once.state, once.frame(6));
  EXPECT_EQ(once.watch.failure(), "");
  for (int i = 0; i < 4; ++i) lasting.watch.add(lasting.state, open);
  lasting.watch.add(lasting.state, lasting.frame(9));
  EXPECT_NE(lasting.watch.failure().find("30 %"), std::string::npos) << lasting.watch.failure();
  last.watch.add(last.state, open);
  EXPECT_NE(last.watch.failure().find("last frame"), std::string::npos) << last.watch.failure();
  Watched slack;
  open.pressure_atm *= 0.1;
  for (int i = 0; i < 9; ++i) slack.watch.add(slack.state, open);
  slack.watch.add(slack.state, slack.frame(9));
  EXPECT_EQ(slack.watch.failure(), "");
}

TEST(SuccessWatch, DoesNotJudgeWhatIsForComparison) {
  Watched t;
  t.options.contact_model = ContactModel::paper;
  SuccessWatch watch(t.scene, t.model, t.options);
  SimulationFrame frame = t.frame(1);
  frame.max_penetration_mm = 0.01;
  watch.add(t.state, frame);
  EXPECT_EQ(watch.failure(), "");
}

}  // namespace
}  // namespace angio::simulation::detail
