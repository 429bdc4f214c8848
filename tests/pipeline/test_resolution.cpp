#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/case/resolution.hpp"

namespace angio::pipeline {
namespace {

TEST(Resolution, OfALabelMapIsHalfThatOfAScan) {
  VolumeGeometry geometry;
  geometry.size = {12, 12, 12};
  geometry.spacing = {0.5, 0.5, 0.8};
  Volume<float> scan(geometry, 0.0F), labels(geometry, 0.0F);
  for (std::size_t i = 0; i < scan.values.size(); ++i) {
    scan.values[i] = float(i % 97) + 0.25F * float(i % 5);
    labels.values[i] = i % 3 == 0 ? 1.0F : 0.0F;
  }
  EXPECT_DOUBLE_EQ(resolution_of(scan).longest_mm, 0.8);
  EXPECT_DOUBLE_EQ(resolution_of(scan).mean_mm, std::cbrt(0.5 * 0.5 * 0.8));
  EXPECT_DOUBLE_EQ(resolution_of(labels).longest_mm, 1.6);
  EXPECT_DOUBLE_EQ(resolution_of(labels).mean_mm, 2.0 * std::cbrt(0.5 * 0.5 * 0.8));
}

}  // namespace
}  // namespace angio::pipeline
