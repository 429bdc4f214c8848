#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <queue>
#include <random>

#include "centerline/detail/monotone_queue.hpp"

namespace angio::centerline {
namespace {

// As a binary heap gives them, keys of many orders of magnitude and equal ones among them.
TEST(MonotoneQueue, GivesWhatABinaryHeapGives) {
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> heap;
  MonotoneQueue queue;
  std::mt19937 random(3u);
  std::uniform_real_distribution<double> exponent(-6.0, 3.0);
  std::uniform_int_distribution<int> number(0, 3), item(0, 999);
  const auto add = [&](double key) {
    const Entry entry{key, item(random)};
    heap.push(entry);
    queue.add(entry.first, entry.second);
  };
  for (int i = 0; i < 100; ++i) add(i % 3 == 0 ? 0.5 : 1.0);
  for (int n = 0; n < 20000 && !heap.empty(); ++n) {
    ASSERT_FALSE(queue.empty());
    const Entry least = queue.take();
    ASSERT_EQ(least, heap.top()) << n;
    heap.pop();
    for (int i = number(random) - (n < 10000 ? 1 : 2); i > 0; --i)
      add(least.first + std::pow(10.0, exponent(random)));
  }
  EXPECT_EQ(queue.empty(), heap.empty());
}

}  // namespace
}  // namespace angio::centerline
