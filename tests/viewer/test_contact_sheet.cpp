#include <gtest/gtest.h>

#include <algorithm>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "testing/viewer/case_folder.hpp"
#include "testing/viewer/png.hpp"
#include "testing/viewer/shapes.hpp"
#include "viewer/contact_sheet.hpp"
#include "viewer/detail/canvas.hpp"
#include "viewer/detail/sheet_case.hpp"

namespace angio::viewer {
namespace {
namespace fs = std::filesystem;
using test::TemporaryFolder;

detail::Picture sheet_of(const fs::path& folder, const TemporaryFolder& out,
                         const fs::path& log = {}) {
  write_contact_sheet(folder, out / "sheet.png", log);
  return angio::test::picture_from_png(read_text(out / "sheet.png"));
}

/// Pixels of a rectangle that are not white paper.
int count_ink(const detail::Picture& picture, int left, int top, int right, int bottom) {
  int ink = 0;
  for (int y = top; y < bottom; ++y)
    for (int x = left; x < right; ++x) {
      const std::size_t at = 3 * (std::size_t(y) * std::size_t(picture.width) + std::size_t(x));
      ink +=
          picture.rgb[at] < 200 || picture.rgb[at + 1] < 200 || picture.rgb[at + 2] < 200 ? 1 : 0;
    }
  return ink;
}

TEST(ContactSheet, ShowsEveryPartOfACase) {
  const TemporaryFolder folder, out;
  test::write_case(folder.path());
  const detail::Picture sheet = sheet_of(folder.path(), out);
  const int w = sheet.width, h = sheet.height;
  EXPECT_GT(count_ink(sheet, 0, h / 10, w / 5, h / 3), 2000) << "projection";
  EXPECT_GT(count_ink(sheet, w / 4, h / 10, 7 * w / 10, 6 * h / 10), 2000) << "tree";
  EXPECT_GT(count_ink(sheet, w / 4, 7 * h / 10, 6 * w / 10, h), 500) << "diameters";
  EXPECT_GT(count_ink(sheet, 65 * w / 100, 7 * h / 10, w, h), 2000) << "balloon";
}

TEST(ContactSheet, IsTheSameEveryTime) {
  const TemporaryFolder folder, out;
  test::write_case(folder.path());
  EXPECT_EQ(sheet_of(folder.path(), out).rgb, sheet_of(folder.path(), out).rgb);
}

TEST(ContactSheet, OfACaseThatFailedSaysWhyInWords) {
  const TemporaryFolder folder, out;
  const fs::path log = out / "case.log";
  write_text_atomically(log, "segmentation 10 %\nangio: no vessel here. Try another series\n");
  const detail::SheetCase sheet = detail::read_sheet_case(folder.path(), log);
  EXPECT_EQ(sheet.status, "failed: no vessel here. Try another series");
  EXPECT_GT(count_ink(sheet_of(folder.path(), out, log), 0, 0, 1800, 1300), 500);
}

TEST(ContactSheet, OfNoCaseIsRefused) {
  const TemporaryFolder folder, out;
  const fs::path log = out / "case.log";
  write_text_atomically(log, "angio: no vessel here\n");
  const auto code_of = [&](const fs::path& one, const fs::path& its_log) {
    try {
      write_contact_sheet(one, out / "sheet.png", its_log);
    } catch (const Error& error) {
      return error.exit_code();
    }
    return ExitCode::done;
  };
  EXPECT_EQ(code_of(log, {}), ExitCode::no_input) << "a file";
  EXPECT_EQ(code_of(log, log), ExitCode::no_input) << "a file";
  EXPECT_EQ(code_of(folder.path(), {}), ExitCode::no_input) << "an empty folder";
  EXPECT_EQ(code_of(folder / "nowhere", {}), ExitCode::no_input);
  EXPECT_FALSE(fs::exists(out / "sheet.png"));
  EXPECT_EQ(code_of(folder / "nowhere", log), ExitCode::done) << "the log says why";
}

TEST(ContactSheet, IndexEscapesWhatItShows) {
  const TemporaryFolder out;
  write_text_atomically(out / "table.csv", "case,status\na<b,done\n");
  write_sheet_index(out / "index.html", {"a<b.png"}, out / "table.csv");
  const std::string page = read_text(out / "index.html");
  EXPECT_EQ(page.find("a<b"), std::string::npos);
  EXPECT_NE(page.find("<td>a&lt;b</td>"), std::string::npos);
  EXPECT_NE(page.find("src=\"a&lt;b.png\""), std::string::npos);
}

TEST(Canvas, WrapsTextAtSpacesWithoutLosingWords) {
  const std::string text = "one two three four five six seven";
  const auto lines = detail::wrap_text(text, 90.0, 9.0);
  ASSERT_GT(lines.size(), 1u);
  std::string joined;
  for (const std::string& line : lines) {
    EXPECT_LE(detail::Canvas::text_box(line, {}, 9.0).width, 90.0 + 4.0 + 1.0);
    joined += (joined.empty() ? "" : " ") + line;
  }
  EXPECT_EQ(joined, text);
}

}  // namespace
}  // namespace angio::viewer
