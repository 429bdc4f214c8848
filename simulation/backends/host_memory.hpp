#pragma once

#include <memory>
#include <vector>

namespace angio::simulation::detail {

/// Keeps a step's arrays in the computer's own memory.
class HostMemory {
 public:
  template <class Value>
  Value* store(std::vector<Value> values) {
    auto block = std::make_shared<std::vector<Value>>(std::move(values));
    blocks_.push_back(block);
    return block->data();
  }
  template <class Value>
  Value* allocate(std::size_t count) {
    return store(std::vector<Value>(count));
  }

 private:
  std::vector<std::shared_ptr<void>> blocks_;
};

}  // namespace angio::simulation::detail
