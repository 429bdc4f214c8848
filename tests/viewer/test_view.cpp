#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "tests/viewer/case_folder.hpp"
#include "tests/viewer/shapes.hpp"
#include "viewer/detail/picture.hpp"
#include "viewer/view.hpp"

namespace angio::viewer {
namespace {
using test::TemporaryFolder;
using test::write_case;

TEST(View, Look) {
  const TemporaryFolder folder;
  write_case(folder.path());
  ViewOptions options;
  options.screenshot = folder / "view.png";
  view_case(folder.path(), options);
}

}  // namespace
}  // namespace angio::viewer
