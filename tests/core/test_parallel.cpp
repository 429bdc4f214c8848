#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/error.hpp"
#include "core/parallel.hpp"

namespace angio {
namespace {

TEST(ParallelFor, CallsEveryIndexOnce) {
  for (const std::ptrdiff_t count : {0, 1, 2, 1000}) {
    std::vector<int> even(std::size_t(count), 0);
    std::vector<int> uneven(std::size_t(count), 0);
    parallel_for(count, [&](std::ptrdiff_t i) { ++even[std::size_t(i)]; });
    parallel_for_uneven(count, [&](std::ptrdiff_t i) { ++uneven[std::size_t(i)]; });
    EXPECT_EQ(even, std::vector<int>(std::size_t(count), 1));
    EXPECT_EQ(uneven, std::vector<int>(std::size_t(count), 1));
  }
}

TEST(ParallelFor, ThrowsTheBodysExceptionInTheCallingThread) {
  const auto body = [](std::ptrdiff_t i) {
    if (i == 37) throw InputError("at 37");
  };
  EXPECT_THROW(parallel_for(100, body), InputError);
  EXPECT_THROW(parallel_for_uneven(100, body), InputError);
}

}  // namespace
}  // namespace angio
