#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/atomic_file.hpp"
#include "tests/viewer/report_content.hpp"
#include "tests/viewer/shapes.hpp"
#include "viewer/report.hpp"

namespace angio::viewer {
namespace {
using test::make_report_content;
using test::TemporaryFolder;
using testing::HasSubstr;

TEST(Report, Look) {
  const TemporaryFolder folder;
  write_report(folder.path(), make_report_content());
}

}  // namespace
}  // namespace angio::viewer
