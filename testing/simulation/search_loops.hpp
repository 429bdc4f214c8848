#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <random>
#include <vector>

namespace angio::simulation::testing {

/// The loops of a search for candidates (candidate_search.hpp) on one thread, each in an order of
/// its own: as threads would take them that come when they like.
class ShuffledLoops {
 public:
  explicit ShuffledLoops(unsigned seed) : random_(seed) {}

  template <class Value>
  void clear(Value* values, int count) {
    std::fill_n(values, count, Value{});
  }
  template <class Loop, class Search>
  void for_each(int count, const Search& search) {
    std::vector<int> order(static_cast<std::size_t>(count));
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), random_);
    for (const int i : order) Loop::run(search, i);
  }
  void scan(const int* values, int* sums, int count) {
    std::exclusive_scan(values, values + count, sums, 0);
  }

 private:
  std::mt19937 random_;
};

}  // namespace angio::simulation::testing
