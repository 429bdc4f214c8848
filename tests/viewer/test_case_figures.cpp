#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "testing/viewer/case_folder.hpp"
#include "testing/viewer/png.hpp"
#include "testing/viewer/shapes.hpp"
#include "viewer/case_figures.hpp"
#include "viewer/detail/chart.hpp"
#include "viewer/detail/drawing_picture.hpp"
#include "viewer/detail/picture.hpp"

namespace angio::viewer {
namespace {
namespace fs = std::filesystem;
using detail::Picture;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> names_of(const std::vector<fs::path>& files) {
  std::vector<std::string> names;
  for (const fs::path& file : files) {
    EXPECT_TRUE(fs::exists(file)) << file;
    names.push_back(file.filename());
  }
  return names;
}

/// A panel of three in a row and three in a column, above the strip of the keys.
std::string panel_of(const Picture& sheet, int column, int row) {
  constexpr int kStrip = 74, kTitle = 36;  // the titles differ
  const int width = sheet.width / 3, height = (sheet.height - kStrip) / 3;
  std::string bytes;
  for (int y = row * height + kTitle; y < (row + 1) * height; ++y) {
    const auto begin = sheet.rgb.begin() + 3 * (std::ptrdiff_t(y) * sheet.width + column * width);
    bytes.insert(bytes.end(), begin, begin + std::ptrdiff_t(3) * width);
  }
  return bytes;
}

TEST(CaseFigures, NineMomentsAndThePlotsAreWritten) {
  const TemporaryFolder folder;
  test::write_case(folder / "case");
  write_text_atomically(folder / "case/simulation/lumen_profile.csv",
                        "abscissa_mm,inscribed_diameter_before_mm,equivalent_diameter_before_mm,"
                        "inscribed_diameter_after_mm,equivalent_diameter_after_mm,"
                        "inscribed_diameter_peak_mm,equivalent_diameter_peak_mm\n"
                        "10,3,3.1,3,3.1,3,3.1\n15,1.2,1.3,2.4,2.5,2.9,3\n20,3,3.1,3,3.1,,3.1\n");
  const auto files = write_case_figures(folder / "case", folder / "out");
  EXPECT_THAT(names_of(files), ElementsAre("moments.png", "diameter.svg", "diameter.png",
                                           "course.svg", "course.png"));
  EXPECT_THAT(read_text(files[1]), HasSubstr(">at peak<"));
  EXPECT_THAT(read_text(files[3]), HasSubstr("pressure [atm]"));
  EXPECT_THAT(read_text(files[3]), HasSubstr("diameter [mm]"));

  // The case's frames have three shapes: as many different panels, from one view.
  const Picture sheet = angio::test::picture_from_png(read_text(files[0]));
  std::set<std::string> panels;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) panels.insert(panel_of(sheet, column, row));
  EXPECT_EQ(panels.size(), 3u);
  EXPECT_EQ(panel_of(sheet, 0, 0), panel_of(sheet, 1, 0));  // both before the peak
  EXPECT_NE(panel_of(sheet, 0, 0), panel_of(sheet, 2, 1));  // (f), the peak
}

TEST(CaseFigures, FailedSimulationHasNoProfileAndNoPlotOfIt) {
  const TemporaryFolder folder;
  test::write_case(folder / "case");
  EXPECT_THAT(names_of(write_case_figures(folder / "case", folder / "out")),
              ElementsAre("moments.png", "course.svg", "course.png"));
}

TEST(CaseFigures, CaseWithoutSimulationSaysWhatToRunAndLeavesNothing) {
  const TemporaryFolder folder;
  test::write_case(folder / "case");
  fs::remove_all(folder / "case" / "simulation");
  try {
    write_case_figures(folder / "case", folder / "out");
    FAIL() << "pictures of nothing were written";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), ExitCode::no_input);
    EXPECT_THAT(error.what(), HasSubstr("angio simulate"));
  }
  EXPECT_FALSE(fs::exists(folder / "out"));
}

/// The mean height of the pixels of the first series' blue [pixel from the bottom].
double height_of_blue(const Picture& picture) {
  double sum = 0.0, count = 0.0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const auto* pixel = &picture.rgb[std::size_t(3 * (y * picture.width + x))];
      if (pixel[2] < pixel[0] + 90) continue;
      sum += picture.height - y;
      count += 1.0;
    }
  EXPECT_GT(count, 100.0);
  return sum / count;
}

TEST(DrawingPicture, LineLiesAtItsValue) {
  detail::Chart chart;
  chart.width = 400;
  chart.height = 300;
  const auto drawn = [&](double y) {
    chart.series = {{"", {0.0, 1.0, 2.0}, {y, y, y}, 1, false},
                    {"", {0.0, 2.0}, {0.0, 10.0}, 2, false}};
    return detail::drawing_picture(detail::svg_file({chart}), 1);
  };
  const double low = height_of_blue(drawn(2.0)), middle = height_of_blue(drawn(5.0)),
               high = height_of_blue(drawn(8.0));
  EXPECT_NEAR(middle - low, high - middle, 1.0);  // linear
  EXPECT_GT(high - low, 0.4 * chart.height);
  EXPECT_EQ(drawn(2.0).width, chart.width);
}

TEST(CaseFigures, ThePngOfAPlotIsItsSvg) {
  const TemporaryFolder folder;
  test::write_case(folder / "case");
  write_case_figures(folder / "case", folder / "out");
  const Picture png = angio::test::picture_from_png(read_text(folder / "out/course.png"));
  const Picture drawing = detail::drawing_picture(read_text(folder / "out/course.svg"), 2);
  EXPECT_EQ(png.width, drawing.width);
  EXPECT_EQ(png_bytes(png), png_bytes(drawing));
}

}  // namespace
}  // namespace angio::viewer
