#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <limits>

#include "core/atomic_file.hpp"
#include "formats/files.hpp"
#include "testing/pipeline/reading.hpp"
#include "testing/temporary_folder.hpp"

namespace angio {
namespace {
namespace fs = std::filesystem;

class Folder : public test::TemporaryFolder {
 public:
  Folder() { make_folder(path() / "segmentation"); }
};

/// Along z, radius 2, length 20.
CenterlineTree make_tree() {
  CenterlinePath path;
  for (int i = 0; i <= 100; ++i) path.points.push_back({0, 0, 0.2 * i});
  path.abscissa = arc_length(path.points);
  path.inscribed_radius.assign(path.points.size(), 2.0);
  path.equivalent_radius = path.inscribed_radius;
  return {{path}};
}

TriangleMesh make_triangle(double scale) {
  return {{{0, 0, 0}, {scale * 30, 0, 0}, {0, scale * 20, scale * 5}}, {{0, 1, 2}}};
}

TEST(Reading, EveryEndNeedsALineOfItsOwn) {
  const std::vector<LineEnd> ends = ends_of(make_tree());
  ASSERT_EQ(ends.size(), 2u);
  EXPECT_EQ(count_found_ends({{{0, 0, 0}, 4.0}, {{0, 0, 20}, 4.0}}, ends), 2);
  EXPECT_EQ(count_found_ends({{{0, 0, 19}, 4.0}, {{0, 0, 20}, 4.0}}, ends), 1);
}

TEST(Reading, AnEndIsFoundWithinOneAndAHalfRadii) {
  const std::vector<LineEnd> ends = ends_of(make_tree());
  EXPECT_EQ(count_found_ends({{{2.9, 0, 20}, 4.0}}, ends), 1);
  EXPECT_EQ(count_found_ends({{{3.1, 0, 20}, 4.0}}, ends), 0);
}

TEST(Reading, AnEndPickedByEyeInAThinVesselIsFoundWithinThePersonsAim) {
  const std::vector<LineEnd> thin{{{0, 0, 0}, 0.3}};
  EXPECT_EQ(count_found_ends({{{0.9 * kEyeMm, 0, 0}, 0.0, true}}, thin), 1);
  EXPECT_EQ(count_found_ends({{{0.9 * kEyeMm, 0, 0}, 0.0, false}}, thin), 0);
}

TEST(Reading, AnyOfSeveralInletsIsRight) {
  const LineEnd begin{{0, 0, 0}, 2.0};
  EXPECT_TRUE(is_inlet_right({{50, 0, 0}, {0, 3.9, 0}}, begin, {}));
  EXPECT_FALSE(is_inlet_right({{50, 0, 0}, {0, 4.1, 0}}, begin, {}));
}

TEST(Reading, StenosesAreFalseUnlessReadOrDoubtful) {
  const CenterlineTree tree = make_tree();
  const auto listed_at = [](double z, double percent) {
    return ListedStenosis{{{0, 0, z}}, 4.0, percent};
  };
  Reading reading;
  reading.stenosis_places = {{0, 0, 5}};
  EXPECT_EQ(count_stenoses(reading, {listed_at(6, 80)}).found, 1);
  EXPECT_EQ(count_stenoses(reading, {listed_at(6, 80)}).wrong, 0);
  EXPECT_EQ(count_stenoses(reading, {listed_at(6, 49)}).found, 0) << "not called severe";
  EXPECT_EQ(count_stenoses(reading, {listed_at(15, 80)}).wrong, 1);
  const double unmeasured = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(count_stenoses(reading, {listed_at(6, unmeasured)}).found, 1)
      << "too narrow to measure is severe";
  reading.doubtful_places = {{0, 0, 15}};
  EXPECT_EQ(count_stenoses(reading, {listed_at(15, 80)}).wrong, 0);
}

TEST(Reading, UnitAndFrameAreThoseThatTheProgramReadTheFileBy) {
  const Folder folder;
  const fs::path input = folder.path() / "input.vtp";
  for (const double unit : {1.0, 10.0, 25.4, 1000.0}) {
    formats::write_surface(input, {make_triangle(1.0 / unit), {}, {}});
    // A part was left out: the box in the case is a little smaller.
    formats::write_surface(folder.path() / "segmentation/lumen_surface.vtp",
                           {make_triangle(0.85), {}, {}});
    const ReadingFrame frame = frame_of_case(input, folder.path());
    EXPECT_DOUBLE_EQ(frame.scale, unit);
    EXPECT_FALSE(frame.is_ras);
  }
}

TEST(Reading, ThePlacesOfAFileInRasAreTurned) {
  const Folder folder;
  const fs::path input = folder.path() / "input.stl";
  write_text_atomically(input,
                        "solid SPACE=RAS\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
                        "vertex 30 0 0\nvertex 0 20 0\nendloop\nendfacet\nendsolid\n");
  formats::write_surface(folder.path() / "segmentation/lumen_surface.vtp",
                         {{{{0, 0, 0}, {-30, 0, 0}, {0, -20, 0}}, {{0, 1, 2}}}, {}, {}});
  const ReadingFrame frame = frame_of_case(input, folder.path());
  EXPECT_EQ(frame({30, 20, 5}), (Vec3{-30, -20, 5}));
}

TEST(Reading, PublicTablesAreReadAndAgreeWithThemselves) {
  const fs::path folder = ANGIO_DATASETS;
  const auto readings = read_readings(folder / "public_readings.csv", folder / "public_ends.csv");
  EXPECT_GE(readings.size(), 60u);
  for (const Reading& reading : readings) {
    const std::string name = reading.case_name + "/" + reading.file;
    EXPECT_EQ(std::size_t(reading.stenoses.value_or(0)), reading.stenosis_places.size()) << name;
    if (reading.ends && !reading.placed_ends.empty()) {
      EXPECT_EQ(std::size_t(*reading.ends), reading.placed_ends.size()) << name;
    }
  }
}

}  // namespace
}  // namespace angio
