#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/files.hpp"

namespace angio::formats {

/// Asserts that reading fails as bad data and that the message names the file.
template <class Read>
void expect_refused(const std::filesystem::path& path, const Read& read, const std::string& why) {
  try {
    read(path);
    FAIL() << path << " was accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(path.filename().string()));
    EXPECT_THAT(error.what(), testing::HasSubstr(why));
    EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
  }
}

inline void expect_surface_refused(const std::filesystem::path& path, const std::string& text,
                                   const std::string& why) {
  write_text_atomically(path, text);
  expect_refused(
      path, [](const std::filesystem::path& p) { return read_surface(p); }, why);
}

inline void expect_equal(const TriangleMesh& a, const TriangleMesh& b) {
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.triangles, b.triangles);
}

inline void expect_equal(const std::vector<DataArray>& a, const std::vector<DataArray>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].name, b[i].name);
    EXPECT_EQ(a[i].component_count, b[i].component_count) << a[i].name;
    EXPECT_EQ(a[i].type, b[i].type) << a[i].name;
    EXPECT_EQ(a[i].values, b[i].values) << a[i].name;
  }
}

}  // namespace angio::formats
