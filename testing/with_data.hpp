#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace angio::test {

/// A test of real objects, which are no part of the repository: skipped where ANGIO_DATA does not
/// name their folder.
class WithData : public testing::Test {
 protected:
  void SetUp() override {
    const char* data = std::getenv("ANGIO_DATA");
    if (!data) GTEST_SKIP() << "ANGIO_DATA is not set";
    data_ = data;
  }
  [[nodiscard]] std::filesystem::path data(const std::string& name) const { return data_ / name; }

 private:
  std::filesystem::path data_;
};

}  // namespace angio::test
