#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "segmentation/detail/stack_geometry.hpp"

namespace angio::segmentation::detail {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

DicomFrame frame_at(const Vec3& position, const Vec3& i = {1, 0, 0}, const Vec3& j = {0, 1, 0}) {
  DicomFrame frame;
  frame.has_position = frame.has_orientation = frame.has_spacing = true;
  frame.position = position;
  frame.axis_i = i;
  frame.axis_j = j;
  frame.spacing_i = 0.4;
  frame.spacing_j = 0.6;
  return frame;
}

std::vector<DicomFrame> straight_stack(int count, double spacing) {
  std::vector<DicomFrame> frames;
  for (int k = 0; k < count; ++k) frames.push_back(frame_at({-1, -2, 3 + spacing * k}));
  return frames;
}

TEST(StackGeometry, TellsRowFromColumnSpacing) {
  const auto stack = stack_geometry(straight_stack(5, 0.5), 20, 10);
  ASSERT_THAT(stack.problem, IsEmpty());
  EXPECT_EQ(stack.geometry.size, (std::array<int, 3>{20, 10, 5}));
  EXPECT_DOUBLE_EQ(stack.geometry.spacing.x, 0.4);  // between columns
  EXPECT_DOUBLE_EQ(stack.geometry.spacing.y, 0.6);  // between rows
  EXPECT_DOUBLE_EQ(stack.geometry.spacing.z, 0.5);
  EXPECT_THAT(stack.warnings, IsEmpty());
}

TEST(StackGeometry, IsTheSameForAnyOrderOfFrames) {
  auto frames = straight_stack(7, 0.5);
  const auto forward = stack_geometry(frames, 8, 8);
  std::reverse(frames.begin(), frames.end());
  std::swap(frames[1], frames[4]);
  const auto shuffled = stack_geometry(frames, 8, 8);
  EXPECT_EQ(forward.geometry, shuffled.geometry);
  EXPECT_GT(determinant(shuffled.geometry.direction), 0.999);
  EXPECT_EQ(frames[std::size_t(shuffled.order[0])].position, (Vec3{-1, -2, 3}));
}

TEST(StackGeometry, PlacesEveryFrameOfAnObliqueStack) {
  const Vec3 i = normalized(Vec3{0.8, 0.1, -0.3});
  const Vec3 j = normalized(cross(Vec3{0.2, 0.5, 0.9}, i));
  const Vec3 n = cross(i, j);
  std::vector<DicomFrame> frames;
  for (int k = 0; k < 6; ++k) frames.push_back(frame_at(Vec3{5, 6, 7} + (0.7 * k) * n, i, j));
  const auto stack = stack_geometry(frames, 4, 4);
  ASSERT_THAT(stack.problem, IsEmpty());
  EXPECT_NEAR(determinant(stack.geometry.direction), 1.0, 1e-12);
  for (int k = 0; k < 6; ++k)
    EXPECT_LT(
        distance(stack.geometry.lps_from_index({0, 0, double(k)}), frames[std::size_t(k)].position),
        1e-9);
}

TEST(StackGeometry, ToleratesTwoMicrometresOfJitter) {
  auto frames = straight_stack(5, 0.3);
  frames[2].position.z += 0.002;
  const auto stack = stack_geometry(frames, 8, 8);
  EXPECT_THAT(stack.problem, IsEmpty());
  EXPECT_THAT(stack.warnings, IsEmpty());
  EXPECT_NEAR(stack.geometry.spacing.z, 0.3, 1e-12);
}

TEST(StackGeometry, WarnsOfASliceThreePercentOff) {
  auto frames = straight_stack(5, 0.5);
  frames[2].position.z += 0.015;
  const auto stack = stack_geometry(frames, 8, 8);
  EXPECT_THAT(stack.problem, IsEmpty());
  EXPECT_EQ(stack.warnings.size(), 1u);
}

TEST(StackGeometry, RefusesWhatIsNoRegularGrid) {
  auto missing = straight_stack(8, 0.5);
  missing.erase(missing.begin() + 3);
  EXPECT_THAT(stack_geometry(missing, 8, 8).problem, HasSubstr("a slice is missing between 4 and"));

  auto uneven = straight_stack(8, 0.5);
  uneven[3].position.z += 0.15;
  EXPECT_THAT(stack_geometry(uneven, 8, 8).problem, HasSubstr("unevenly spaced"));

  auto twice = straight_stack(8, 0.5);
  twice.push_back(twice[2]);
  EXPECT_THAT(stack_geometry(twice, 8, 8).problem, HasSubstr("repeats a position"));

  auto turned = straight_stack(8, 0.5);
  turned[5].axis_i = {0, 1, 0};
  turned[5].axis_j = {-1, 0, 0};
  EXPECT_THAT(stack_geometry(turned, 8, 8).problem, HasSubstr("different orientations"));

  EXPECT_THAT(stack_geometry(straight_stack(1, 0.5), 8, 8).problem, HasSubstr("one slice alone"));
}

TEST(StackGeometry, RefusesMissingOrImpossibleGeometry) {
  auto frames = straight_stack(4, 0.5);
  frames[1].has_spacing = false;
  EXPECT_THAT(stack_geometry(frames, 8, 8).problem, HasSubstr("pixel spacing is missing"));
  frames = straight_stack(4, 0.5);
  frames[1].has_position = false;
  EXPECT_THAT(stack_geometry(frames, 8, 8).problem, HasSubstr("position is missing"));
  frames = straight_stack(4, 0.5);
  for (auto& frame : frames) frame.spacing_i = 0.0;
  EXPECT_THAT(stack_geometry(frames, 8, 8).problem, HasSubstr("impossible"));
  frames = straight_stack(4, 0.5);
  for (auto& frame : frames) frame.axis_j = {0.5, 0.5, 0};
  EXPECT_THAT(stack_geometry(frames, 8, 8).problem, HasSubstr("right angles"));
}

}  // namespace
}  // namespace angio::segmentation::detail
