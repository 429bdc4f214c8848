#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace angio::pipeline {

/// The memory that the cases of a batch may take together, so that `-j N` is never too many.
class MemoryBudget {
 public:
  /// @param total_bytes  what is free when the batch begins
  explicit MemoryBudget(std::uint64_t total_bytes) : total_(total_bytes) {}

  /// Whether a case may begin: the first one always may.
  [[nodiscard]] bool has_room_for(std::uint64_t bytes) const {
    return taken_ == 0 || taken_ + bytes <= total_;
  }
  void take(std::uint64_t bytes) { taken_ += bytes; }
  void give_back(std::uint64_t bytes) { taken_ -= bytes; }

 private:
  std::uint64_t total_;
  std::uint64_t taken_ = 0;
};

/// What the stages of a case have taken at the most [bytes], by its run.json; 0: not known.
std::uint64_t memory_taken(const std::filesystem::path& case_folder);

/// What a case may take [bytes], of which nothing is known but its input: 1 GiB, and 24 bytes for
/// each of the input's, which are two to a voxel where they are not packed.
std::uint64_t memory_guess(const std::string& input);

}  // namespace angio::pipeline
