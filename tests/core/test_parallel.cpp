#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/beside.hpp"
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

TEST(Beside, WorksInTurnWithTheCallersThreadsAndThrowsWhenWaitedFor) {
  const int before = omp_get_max_threads();
  for (const int threads : {1, 3}) {
    omp_set_num_threads(threads);
    std::vector<int> seen;
    Beside beside;
    for (int i = 0; i < 5; ++i)
      beside.run([&seen, i] { seen.push_back(10 * i + omp_get_max_threads()); });
    beside.wait();
    EXPECT_EQ(seen,
              (std::vector<int>{threads, 10 + threads, 20 + threads, 30 + threads, 40 + threads}));
    EXPECT_THROW(
        {
          beside.run([] { throw InputError("beside"); });
          beside.wait();
        },
        InputError);
  }
  omp_set_num_threads(before);
}

TEST(Beside, TakesASpareThreadWhereTheCallerHasOneOnly) {
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  for (const bool has_spare_thread : {false, true}) {
    std::thread::id worker;
    Beside beside(has_spare_thread);
    beside.run([&worker] { worker = std::this_thread::get_id(); });
    beside.wait();
    EXPECT_EQ(worker == std::this_thread::get_id(), !has_spare_thread);
  }
  omp_set_num_threads(before);
}

}  // namespace
}  // namespace angio
