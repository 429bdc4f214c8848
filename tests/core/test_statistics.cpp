#include <gtest/gtest.h>

#include "core/statistics.hpp"

namespace angio {
namespace {

TEST(Median, IsTheUpperMiddleValue) {
  EXPECT_EQ(median(std::vector<double>{3.0}), 3.0);
  EXPECT_EQ(median(std::vector<double>{5.0, 1.0, 3.0}), 3.0);
  EXPECT_EQ(median(std::vector<int>{4, 1, 3, 2}), 3);
}

TEST(WeightedQuantile, IsTheLeastValueUpToWhichTheShareOfTheWeightLies) {
  const std::vector<std::pair<double, double>> weighted{{30.0, 1.0}, {10.0, 7.0}, {20.0, 2.0}};
  EXPECT_EQ(weighted_quantile(weighted, 0.0), 10.0);
  EXPECT_EQ(weighted_quantile(weighted, 0.69), 10.0);
  EXPECT_EQ(weighted_quantile(weighted, 0.71), 20.0);
  EXPECT_EQ(weighted_quantile(weighted, 0.91), 30.0);
  EXPECT_EQ(weighted_quantile(weighted, 1.0), 30.0);
}

TEST(Quantile, RunsFromTheLeastToTheGreatest) {
  const std::vector<double> values{4.0, 0.0, 3.0, 1.0, 2.0};
  EXPECT_EQ(quantile(values, 0.0), 0.0);
  EXPECT_EQ(quantile(values, 0.25), 1.0);
  EXPECT_EQ(quantile(values, 0.49), 1.0);
  EXPECT_EQ(quantile(values, 1.0), 4.0);
}

}  // namespace
}  // namespace angio
