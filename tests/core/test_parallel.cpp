#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/beside.hpp"
#include "core/error.hpp"
#include "core/in_order.hpp"
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

TEST(Beside, LetsAFewPiecesWaitAndTheCallerGoOn) {
  std::mutex gate;
  std::atomic<int> done = 0;
  Beside beside(true, 3);
  {
    const std::unique_lock closed(gate);
    const auto piece = [&] {
      const std::lock_guard open(gate);
      ++done;
    };
    for (int i = 0; i < 3; ++i) beside.run(piece);  // does not block
    EXPECT_EQ(done, 0);
  }
  beside.wait();
  EXPECT_EQ(done, 3);
}

TEST(Beside, DoesNothingAfterAPieceThatThrowsAndTellsOnce) {
  std::atomic<int> done = 0;
  std::promise<void> all_wait;
  Beside beside(true, 4);
  beside.run([all = all_wait.get_future().share()] {
    all.wait();
    throw InputError("beside");
  });
  for (int i = 0; i < 3; ++i) beside.run([&] { ++done; });
  all_wait.set_value();
  EXPECT_THROW(beside.wait(), InputError);
  EXPECT_EQ(done, 0);
  beside.run([&] { ++done; });
  beside.wait();
  EXPECT_EQ(done, 1);
}

TEST(Beside, DropsWhatWaitsWhenItIsDestroyed) {
  std::atomic<int> done = 0;
  std::promise<void> has_begun;
  {
    Beside beside(true, 4);
    beside.run([&] {
      has_begun.set_value();
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      ++done;
    });
    for (int i = 0; i < 3; ++i) beside.run([&] { done += 10; });
    has_begun.get_future().wait();
  }
  EXPECT_EQ(done, 1);
}

TEST(Beside, SeveralWorkersShareThePiecesAndWaitForEachOther) {
  constexpr int kWorkers = 3;
  std::atomic<int> at_work = 0, done = 0;
  std::promise<void> all_at_work;
  const std::shared_future<void> all = all_at_work.get_future().share();
  Beside beside(true, 20, kWorkers);
  for (int i = 0; i < kWorkers; ++i)
    beside.run([&, all] {
      if (++at_work == kWorkers) all_at_work.set_value();
      if (all.wait_for(std::chrono::seconds(20)) == std::future_status::ready) ++done;
    });
  for (int i = 0; i < 10; ++i) beside.run([&] { ++done; });
  beside.wait();
  EXPECT_EQ(done, kWorkers + 10);
  beside.run([] { throw InputError("beside"); });
  EXPECT_THROW(beside.wait(), InputError);
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

TEST(Beside, DoBothReturnsOnceBothHaveEndedWhicheverThrows) {
  Beside beside(true);
  const auto nothing = [] {};
  const auto fails = [] { throw InputError("here"); };
  std::atomic<bool> has_ended = false;
  const auto lasts = [&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    has_ended = true;
  };
  do_both(beside, lasts, nothing);
  EXPECT_TRUE(has_ended.exchange(false));
  EXPECT_THROW(do_both(beside, lasts, fails), InputError);
  EXPECT_TRUE(has_ended);
  EXPECT_THROW(do_both(beside, fails, nothing), InputError);
  EXPECT_NO_THROW(do_both(beside, nothing, nothing));  // what was told is told once
}

TEST(InOrder, DoesPiecesInTheirOrderAndOneAtATimeWhoeverBringsThem) {
  constexpr int kWorkers = 4, kPieces = 200;
  std::vector<int> done;
  std::atomic<int> at_work = 0;
  bool is_alone = true;
  InOrder in_order;
  Beside beside(true, kPieces, kWorkers);
  for (int i = 0; i < kPieces; ++i)
    beside.run([&, i] {
      std::this_thread::sleep_for(std::chrono::microseconds(i * 7919 % 500));
      in_order.run(i, [&, i] {
        is_alone = is_alone && ++at_work == 1;
        done.push_back(i);
        --at_work;
      });
    });
  beside.wait();
  ASSERT_EQ(done.size(), std::size_t(kPieces));
  EXPECT_TRUE(std::is_sorted(done.begin(), done.end()));
  EXPECT_TRUE(is_alone);
}

TEST(InOrder, DoesNothingAfterAPieceThatThrows) {
  std::vector<int> done;
  InOrder in_order;
  in_order.run(2, [&] { done.push_back(2); });
  in_order.run(0, [&] { done.push_back(0); });
  EXPECT_THROW(in_order.run(1, [] { throw InputError("in its turn"); }), InputError);
  in_order.run(3, [&] { done.push_back(3); });
  EXPECT_EQ(done, std::vector<int>{0});
}

TEST(InOrder, LeavesWhatComesEarlyUntilItsTurn) {
  std::vector<int> done;
  InOrder in_order;
  for (const int i : {2, 1, 3}) in_order.run(i, [&done, i] { done.push_back(i); });
  EXPECT_TRUE(done.empty());
  in_order.run(0, [&done] { done.push_back(0); });
  EXPECT_EQ(done, (std::vector<int>{0, 1, 2, 3}));
}

}  // namespace
}  // namespace angio
