#include <gtest/gtest.h>

#include <string>

#include "core/error.hpp"
#include "core/progress.hpp"

namespace angio {
namespace {

TEST(Error, EveryKindCarriesTheExitCodeOfTheContract) {
  EXPECT_EQ(int(InputError("x").exit_code()), 65);
  EXPECT_EQ(int(InputError("x", ExitCode::no_input).exit_code()), 66);
  EXPECT_EQ(int(InternalError("x").exit_code()), 70);
  EXPECT_EQ(int(IoError("x", ExitCode::cannot_create).exit_code()), 73);
  EXPECT_EQ(int(IoError("x").exit_code()), 74);
  EXPECT_EQ(int(Interrupted().exit_code()), 75);
  EXPECT_EQ(int(OptionError("x").exit_code()), 78);
}

TEST(Error, KeepsItsMessage) {
  const InputError error("no voxels");
  EXPECT_STREQ(static_cast<const Error&>(error).what(), "no voxels");
}

TEST(Expect, NamesTheConditionAndThePlace) {
  try {
    detail::fail_expectation("a < b", "core/x.cpp", 12);
    FAIL();
  } catch (const InternalError& error) {
    EXPECT_EQ(std::string(error.what()), "expectation failed: a < b (core/x.cpp:12)");
  }
}

TEST(Progress, IsSilentByDefaultAndOtherwisePassesEveryStepOn) {
  Progress().report(0.5, "nobody listens");
  double fraction = 0.0;
  std::string step;
  const Progress progress([&](double f, std::string_view s) {
    fraction = f;
    step = s;
  });
  progress.report(0.25, "smoothing");
  EXPECT_EQ(fraction, 0.25);
  EXPECT_EQ(step, "smoothing");
}

}  // namespace
}  // namespace angio
