#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <regex>
#include <string>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "reconstruction/geometry_file.hpp"
#include "testing/temporary_folder.hpp"
#include "tests/reconstruction/turning_balls.hpp"

namespace angio::reconstruction {
namespace {

using angiogram::ConeBeamFrame;
using angiogram::ConeBeamView;
using testing::HasSubstr;

class GeometryFile : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& text) {
    const auto file = folder_.path() / "geometry.txt";
    write_text_atomically(file, text);
    return file;
  }
  std::vector<ConeBeamFrame> read(const std::string& text) {
    return read_geometry(write(text), {{96, 64}, {0.75, 0.75}});
  }
  std::string refusal(const std::string& text) {
    try {
      read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "it was taken";
  }
  test::TemporaryFolder folder_;
};

void expect_same_view(const ConeBeamFrame& a, const ConeBeamFrame& b) {
  for (const Vec3 point : {Vec3{3, -5, 8}, Vec3{-10, 2, -4}}) {
    const auto x = ConeBeamView(a).see(point), y = ConeBeamView(b).see(point);
    EXPECT_NEAR(x.column, y.column, 1e-5);
    EXPECT_NEAR(x.row, y.row, 1e-5);
  }
}

/// A detector that is shifted, turned in its plane and leans.
std::vector<ConeBeamFrame> strange_frames() {
  auto frames = tests::turn(5, -60.0, 120.0, 96, 64, 12.0);
  for (ConeBeamFrame& frame : frames) {
    const Vec3 c = frame.column_step, r = frame.row_step;
    frame.column_step = std::cos(0.05) * c + std::sin(0.05) * r;
    frame.row_step = std::cos(0.05) * r - std::sin(0.05) * c;
    frame.first_pixel += 3.0 * c - 2.0 * r;
  }
  return frames;
}

TEST_F(GeometryFile, OfRtkComesBack) {
  const auto frames = strange_frames();
  const auto back = read(rtk_geometry(frames));
  ASSERT_EQ(back.size(), frames.size());
  for (std::size_t f = 0; f < frames.size(); ++f) {
    expect_same_view(frames[f], back[f]);
    EXPECT_LT(distance(back[f].first_pixel, frames[f].first_pixel), 1e-5);  // and stands there
  }
}

TEST_F(GeometryFile, OfRtkIsOfTheMillimetresThatTheStackLiesIn) {
  // The first pixel lies 3 mm farther along the columns than the middle has it, 1.5 mm less down.
  const auto frames = strange_frames();
  const auto file = write(rtk_geometry(frames));
  const std::array<double, 2> first{-0.5 * 95 * 0.75 + 3.0, -0.5 * 63 * 0.75 - 1.5};
  const auto off = read_geometry(file, {{96, 64}, {0.75, 0.75}, first});
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const auto x = ConeBeamView(frames[f]).see({3, -5, 8}),
               y = ConeBeamView(off[f]).see({3, -5, 8});
    EXPECT_NEAR(y.column, x.column - 3.0 / 0.75, 1e-5);
    EXPECT_NEAR(y.row, x.row + 1.5 / 0.75, 1e-5);
  }
  EXPECT_THROW(read_geometry(file, {{96, 64}, {0.0, 0.0}}), InputError);
}

/// What RTK makes of the nine numbers (rtkThreeDCircularProjectionGeometry.cxx): translation,
/// magnification, translation, rotation, as it documents them.
TEST_F(GeometryFile, OfRtkHasTheMatricesOfItsNumbers) {
  const std::string xml = rtk_geometry(strange_frames());
  const auto number = [&](const std::string& key, std::size_t from) {
    const std::size_t at = xml.find("<" + key + ">", from);
    return std::stod(xml.substr(at + key.size() + 2));
  };
  const auto rotation = [](int axis, double degrees) {
    const double a = degrees * units::kPi / 180.0;
    const int j = (axis + 1) % 3, k = (axis + 2) % 3;
    Mat3 m = Mat3::identity();
    m(j, j) = m(k, k) = std::cos(a);
    m(j, k) = -std::sin(a);
    m(k, j) = std::sin(a);
    return m;
  };
  int count = 0;
  for (std::size_t at = xml.find("<Projection>"); at != std::string::npos;
       at = xml.find("<Projection>", at + 1), ++count) {
    const Mat3 turn = rotation(2, -number("InPlaneAngle", at)) *
                      rotation(0, -number("OutOfPlaneAngle", at)) *
                      rotation(1, -number("GantryAngle", at));
    const Vec3 point{4.0, -7.0, 5.0};
    Vec3 p = turn * point;
    const double sx = number("SourceOffsetX", at), sy = number("SourceOffsetY", at);
    p -= Vec3{sx, sy, 0.0};
    const double depth = p.z - number("SourceToIsocenterDistance", at);
    const double far = -number("SourceToDetectorDistance", at);
    const double u = far * p.x / depth + sx - number("ProjectionOffsetX", at);
    const double v = far * p.y / depth + sy - number("ProjectionOffsetY", at);
    std::istringstream matrix(xml.substr(xml.find("<Matrix>", at) + 8));
    double m[3][4];
    for (auto& row : m)
      for (double& value : row) matrix >> value;
    const auto line = [&](int r) {
      return m[r][0] * point.x + m[r][1] * point.y + m[r][2] * point.z + m[r][3];
    };
    EXPECT_NEAR(line(2), depth, 1e-6 * std::abs(depth));
    EXPECT_NEAR(line(0) / line(2), u, 1e-6);
    EXPECT_NEAR(line(1) / line(2), v, 1e-6);
  }
  EXPECT_EQ(count, 5);
}

TEST_F(GeometryFile, OfCsvIsTakenWithHeadingsAndSemicolons) {
  const auto frames = tests::turn(4, 0.0, 90.0);
  std::string text = "# matrices\nm00;m01;m02\n";
  for (const ConeBeamFrame& frame : frames) {
    std::string line;
    for (const auto& row : ConeBeamView(frame).matrix())
      for (const double value : row)
        line += (line.empty() ? "" : ";") + std::to_string(7e3 * value);
    text += line + "\r\n";
  }
  const auto back = read(text);
  ASSERT_EQ(back.size(), 4u);
  for (const ConeBeamFrame& frame : back) EXPECT_GT(ConeBeamView(frame).see({}).depth, 0.0);
}

TEST_F(GeometryFile, ThatIsDamagedIsRefusedWithItsPlace) {
  EXPECT_THAT(refusal("1,2,3\n"), HasSubstr("3 numbers in line 1"));
  EXPECT_THAT(refusal("1,2,3,4,5,6,7,8,9,10,11,nan\n"), HasSubstr("line 1"));
  EXPECT_THAT(refusal(""), HasSubstr("holds no matrix"));
  EXPECT_THAT(refusal("<a>"), HasSubstr("XML"));
  EXPECT_THAT(refusal("<a></a>"), HasSubstr("not RTK's"));
  EXPECT_THAT(refusal("0,0,0,0,0,0,0,0,0,0,0,0\n"), HasSubstr("no inverse"));
  EXPECT_THROW(read_geometry(folder_.path() / "none.csv", {{96, 64}, {1.0, 1.0}}), Error);
}

}  // namespace
}  // namespace angio::reconstruction
