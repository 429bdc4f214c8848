#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace angio::centerline {

/// Items by rising key, for a front that never goes back: nothing may be added below the key taken
/// last, which is 0 at first. Items of one key come in rising order, but for those added at the key
/// taken last.
///
/// A radix heap. Non-negative doubles are ordered as their bits are. A bucket holds the keys that
/// differ from the last one first in one and the same bit, so that adding costs one look at the
/// bits, and an item moves at most once a bit.
///
/// Source: Ahuja, Mehlhorn, Orlin, Tarjan, "Faster algorithms for the shortest path problem",
/// J. ACM 37 (1990) 213, section 2.
class MonotoneQueue {
 public:
  /// @param key  >= 0, finite, not below the key taken last
  void add(double key, int item) {
    const auto bits = std::bit_cast<std::uint64_t>(key);
    bucket(bits).push_back({bits, item});
    ++count_;
  }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  /// The least key and its item. Not to be called when empty.
  std::pair<double, int> take() {
    if (buckets_[0].empty()) open_next();
    const Entry entry = buckets_[0].back();
    buckets_[0].pop_back();
    --count_;
    return {std::bit_cast<double>(entry.key), entry.item};
  }

 private:
  struct Entry {
    std::uint64_t key;
    int item;
  };

  std::vector<Entry>& bucket(std::uint64_t key) {
    return buckets_[std::size_t(std::bit_width(key ^ last_))];
  }

  /// Makes the least key the last one, and brings its bucket's items nearer.
  void open_next() {
    std::size_t first = 1;
    while (buckets_[first].empty()) ++first;
    opened_.swap(buckets_[first]);
    last_ = std::min_element(opened_.begin(), opened_.end(), [](const Entry& a, const Entry& b) {
              return a.key < b.key;
            })->key;
    for (const Entry& entry : opened_) bucket(entry.key).push_back(entry);
    opened_.clear();
    std::sort(buckets_[0].begin(), buckets_[0].end(),
              [](const Entry& a, const Entry& b) { return a.item > b.item; });
  }

  std::array<std::vector<Entry>, 65> buckets_;  // by the place of the first bit that differs
  std::vector<Entry> opened_;
  std::uint64_t last_ = 0;
  std::size_t count_ = 0;
};

}  // namespace angio::centerline
