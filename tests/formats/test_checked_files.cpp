#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "core/error.hpp"
#include "formats/checked_arrays.hpp"
#include "formats/csv.hpp"
#include "testing/temporary_folder.hpp"

namespace angio::formats {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<DataArray> arrays_with(double third) {
  return {{"Ids", {0.0, 4.0, third}, 1, ArrayType::float64},
          {"Axial", {1.0, 2.0, 3.0, 4.0, 5.0, third}, 3, ArrayType::float64}};
}

template <class Read>
std::string complaint(const Read& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(CheckedArrays, GiveWhatIsWithinTheRange) {
  const std::vector<DataArray> arrays = arrays_with(7.0);
  const CheckedArrays three(arrays, 3, "region.vtp");
  EXPECT_EQ(three.integers<int>("Ids", 0.0, 7.0), (std::vector<int>{0, 4, 7}));
  EXPECT_EQ(three.numbers("Ids"), (std::vector<double>{0.0, 4.0, 7.0}));
  EXPECT_EQ(CheckedArrays(arrays, 2, "").vectors("Axial"),
            (std::vector<Vec3>{{1, 2, 3}, {4, 5, 7}}));
}

TEST(CheckedArrays, NameTheFileTheArrayAndThePlaceOfWhatIsNot) {
  for (const double value : {8.0, -1.0, kNan, 1e300, -std::numeric_limits<double>::infinity()}) {
    const std::vector<DataArray> arrays = arrays_with(value);
    const CheckedArrays three(arrays, 3, "region.vtp");
    EXPECT_THAT(complaint([&] { (void)three.integers<int>("Ids", 0.0, 7.0); }),
                testing::AllOf(testing::HasSubstr("region.vtp"), testing::HasSubstr("Ids"),
                               testing::HasSubstr("place 2")))
        << value;
  }
}

TEST(CheckedArrays, FitTheTypeThatIsAskedFor) {
  const std::vector<DataArray> arrays = arrays_with(3e9);
  EXPECT_NE(complaint([&] { (void)CheckedArrays(arrays, 3, "f").integers<int>("Ids"); }), "");
  EXPECT_NE(complaint([&] { (void)CheckedArrays(arrays, 3, "f").integers<char>("Ids"); }), "");
}

TEST(CheckedArrays, HaveAValueForEachPoint) {
  const std::vector<DataArray> arrays = arrays_with(7.0);
  EXPECT_NE(complaint([&] { (void)CheckedArrays(arrays, 4, "f").numbers("Ids"); }), "");
  EXPECT_NE(complaint([&] { (void)CheckedArrays(arrays, 3, "f").vectors("Axial"); }), "");
  EXPECT_NE(complaint([&] { (void)CheckedArrays(arrays, 3, "f").numbers("Radius"); }), "");
}

TEST(CheckedArrays, OfVectorsAreFinite) {
  const std::vector<DataArray> arrays = arrays_with(kNan);
  EXPECT_NE(complaint([&] { (void)CheckedArrays(arrays, 2, "f").vectors("Axial"); }), "");
}

class CsvTables : public testing::Test {
 protected:
  CsvTable read(const std::string& text) {
    const auto file = folder_.path() / "table.csv";
    std::ofstream(file) << text;
    return read_csv_table(file);
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(CsvTables, GiveTheirColumnsAndEmptyCellsAsNan) {
  const CsvTable table = read("a,b,phase\n1,,hold\n-2.5e3,7,rest\n");
  EXPECT_EQ(table.numbers("a"), (std::vector<double>{1.0, -2500.0}));
  EXPECT_TRUE(std::isnan(table.numbers("b")[0]));
  EXPECT_EQ(table.texts("phase"), (std::vector<std::string>{"hold", "rest"}));
  EXPECT_TRUE(read("a,b\n").rows.empty());
}

TEST_F(CsvTables, RefuseWhatIsNoTable) {
  EXPECT_THAT(complaint([&] { read(""); }), testing::HasSubstr("table.csv is empty"));
  EXPECT_THAT(complaint([&] { read("a,b\n1,2\n3\n"); }), testing::HasSubstr("row 2 has 1 cell"));
  EXPECT_THAT(complaint([&] { read("a,b\n1,2,3\n"); }), testing::HasSubstr("row 1"));
  const CsvTable table = read("a\n1\nabc\ninf\n");
  EXPECT_THAT(complaint([&] { (void)table.numbers("a"); }), testing::HasSubstr("row 2, column a"));
  EXPECT_THAT(complaint([&] { (void)table.numbers("c"); }), testing::HasSubstr("no column c"));
}

}  // namespace
}  // namespace angio::formats
