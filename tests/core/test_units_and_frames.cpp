#include <gtest/gtest.h>

#include "core/frames.hpp"
#include "core/units.hpp"

namespace angio {
namespace {

TEST(Units, AStandardAtmosphereIs101Point325Kilopascal) {
  EXPECT_DOUBLE_EQ(units::kilopascal_from_pascal(units::pascal_from_atm(1.0)), 101.325);
}

TEST(Units, ConversionsAreInverse) {
  EXPECT_DOUBLE_EQ(units::atm_from_pascal(units::pascal_from_atm(8.0)), 8.0);
  EXPECT_DOUBLE_EQ(units::kilopascal_from_pascal(units::pascal_from_kilopascal(10.0)), 10.0);
  EXPECT_DOUBLE_EQ(units::pascal_from_megapascal(1.031), 1.031e6);
}

TEST(Frames, LeftPosteriorSuperiorIsMinusRightMinusAnteriorSuperior) {
  EXPECT_EQ(lps_from_ras({1.0, 2.0, 3.0}), (Vec3{-1.0, -2.0, 3.0}));
  EXPECT_EQ(lps_from_ras(lps_from_ras({1.0, 2.0, 3.0})), (Vec3{1.0, 2.0, 3.0}));
}

}  // namespace
}  // namespace angio
