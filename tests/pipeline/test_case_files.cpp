#include <gtest/gtest.h>

#include "formats/files.hpp"
#include "pipeline/case/case_files.hpp"
#include "run_program.hpp"

namespace angio::pipeline {
namespace {

CenterlinePath line_of(int id, int point_count, const Vec3& direction) {
  CenterlinePath path;
  path.id = id;
  for (int i = 0; i < point_count; ++i) {
    path.points.push_back((0.1 * i) * direction);
    path.inscribed_radius.push_back(1.5 - 0.01 * i);
    path.section_area.push_back(7.0 - 0.1 * i);
    path.equivalent_radius.push_back(1.49 - 0.01 * i);
  }
  path.abscissa = arc_length(path.points);
  return path;
}

TEST(CaseFiles, CenterlinesReadBackAsTheyWereWritten) {
  CenterlineTree tree;
  tree.paths.push_back(line_of(0, 20, {0, 0, 1}));
  tree.paths.back().tracts = {{0, 8, 0, 0, false}, {8, 11, 1, 1, true}, {11, 19, 2, 2, false}};
  tree.paths.push_back(line_of(1, 15, {0, 0.6, 0.8}));
  tree.paths.back().tracts = {{0, 8, 0, 0, false}, {8, 11, 1, 1, true}, {11, 14, 3, 2, false}};

  test::CommandFolder folder;
  write_centerlines(folder / "centerlines.vtp", tree);
  const CenterlineTree again = read_centerlines(folder / "centerlines.vtp");
  ASSERT_EQ(again.paths.size(), 2u);
  for (std::size_t p = 0; p < 2; ++p) {
    const CenterlinePath& a = tree.paths[p];
    const CenterlinePath& b = again.paths[p];
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.points, b.points);
    EXPECT_EQ(a.inscribed_radius, b.inscribed_radius);
    EXPECT_EQ(a.abscissa, b.abscissa);
    EXPECT_EQ(a.section_area, b.section_area);
    EXPECT_EQ(a.equivalent_radius, b.equivalent_radius);
    ASSERT_EQ(a.tracts.size(), b.tracts.size());
    for (std::size_t t = 0; t < a.tracts.size(); ++t) {
      EXPECT_EQ(a.tracts[t].first_point, b.tracts[t].first_point);
      EXPECT_EQ(a.tracts[t].last_point, b.tracts[t].last_point);
      EXPECT_EQ(a.tracts[t].group_id, b.tracts[t].group_id);
      EXPECT_EQ(a.tracts[t].blanking, b.tracts[t].blanking);
    }
  }
}

TEST(CaseFiles, CenterlinesCarryTheContractsArrays) {
  CenterlineTree tree;
  tree.paths.push_back(line_of(0, 5, {1, 0, 0}));
  tree.paths.back().tracts = {{0, 4, 0, 0, false}};
  test::CommandFolder folder;
  write_centerlines(folder / "centerlines.vtp", tree);
  const formats::PolylineData data = formats::read_polylines(folder / "centerlines.vtp");
  for (const char* array :
       {"MaximumInscribedSphereRadius", "Abscissas", "EquivalentRadius", "SectionArea"})
    EXPECT_EQ(formats::find_array(data.point_arrays, array).values.size(), 5u) << array;
  for (const char* array : {"CenterlineIds", "GroupIds", "TractIds", "Blanking"})
    EXPECT_EQ(formats::find_array(data.cell_arrays, array).values.size(), 1u) << array;
}

TEST(CaseFiles, ATimeSeriesRowHasEveryColumn) {
  const std::string header = kTimeSeriesHeader;
  const std::string row = time_series_row({}, 1.25);
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), std::count(row.begin(), row.end(), ','));
  EXPECT_TRUE(row.starts_with("0,0,insert,"));
}

}  // namespace
}  // namespace angio::pipeline
