#include "reconstruction/geometry_file.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace angio::reconstruction {
namespace {

using angiogram::ConeBeamFrame;
using angiogram::ConeBeamView;
using Matrix = std::array<std::array<double, 4>, 3>;
constexpr std::size_t kMostFrames = 10000;

/// RTK's axes from ours: y is the body's.
Vec3 to_rtk(const Vec3& v) { return {v.x, v.z, -v.y}; }

/// RTK's nine numbers of a frame.
struct RtkNumbers {
  double gantry = 0, out_of_plane = 0, in_plane = 0;  // degrees
  double source_distance = 0, detector_distance = 0;
  double source_x = 0, source_y = 0, picture_x = 0, picture_y = 0;
};

/// The detector's rows and columns are r and c, its normal towards the source n: the rotation whose
/// rows they are is Rz(-in_plane) Rx(-out_of_plane) Ry(-gantry).
RtkNumbers rtk_numbers(const ConeBeamFrame& frame) {
  const Vec3 r = normalized(to_rtk(frame.column_step));
  const Vec3 n = normalized(cross(r, to_rtk(frame.row_step)));
  const Vec3 c = cross(n, r);
  const Vec3 source = to_rtk(frame.source);
  const Vec3 middle = to_rtk(frame.place(0.5 * (frame.columns - 1), 0.5 * (frame.rows - 1)));
  RtkNumbers numbers;
  numbers.out_of_plane = -std::asin(std::clamp(n.y, -1.0, 1.0)) * units::kDegreesPerRadian;
  numbers.gantry = -std::atan2(-n.x, n.z) * units::kDegreesPerRadian;
  numbers.in_plane = -std::atan2(-r.y, c.y) * units::kDegreesPerRadian;
  numbers.source_distance = dot(n, source);
  numbers.detector_distance = dot(n, source - middle);
  numbers.source_x = dot(source, r);
  numbers.source_y = dot(source, c);
  numbers.picture_x = dot(middle, r);
  numbers.picture_y = dot(middle, c);
  return numbers;
}

/// From RTK's (x, y, z, 1) to mm on the detector from the picture's middle.
Matrix rtk_matrix(const ConeBeamFrame& frame) {
  const Matrix pixels = ConeBeamView(frame).matrix();
  const std::array<double, 2> spacing{norm(frame.column_step), norm(frame.row_step)};
  const std::array<double, 2> middle{0.5 * (frame.columns - 1), 0.5 * (frame.rows - 1)};
  // RTK's third row has the detector's unit normal: its points before the source count below zero.
  const double scale = -std::sqrt(pixels[2][0] * pixels[2][0] + pixels[2][1] * pixels[2][1] +
                                  pixels[2][2] * pixels[2][2]);
  Matrix matrix{};
  for (std::size_t row = 0; row < 3; ++row) {
    std::array<double, 4> line{};
    for (std::size_t k = 0; k < 4; ++k)
      line[k] =
          (row < 2 ? spacing[row] * (pixels[row][k] - middle[row] * pixels[2][k]) : pixels[2][k]) /
          scale;
    matrix[row] = {line[0], line[2], -line[1], line[3]};  // x, y, z of RTK are our x, z, -y
  }
  return matrix;
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what) {
  throw InputError(fmt::format("the geometry file {} {}", file.filename().string(), what));
}

/// Twelve numbers; nothing where the text holds other things.
bool read_numbers(const std::string& text, Matrix& matrix, std::size_t& count) {
  std::string spaced = text;
  for (char& c : spaced)
    if (c == ',' || c == ';') c = ' ';
  std::istringstream in(spaced);
  count = 0;
  for (std::string word; in >> word; ++count) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (*end != '\0') return false;
    if (count < 12) matrix[count / 4][count % 4] = value;
  }
  return true;
}

void check(const Matrix& matrix, const std::filesystem::path& file, const std::string& where) {
  for (const auto& row : matrix)
    for (const double value : row)
      if (!std::isfinite(value))
        refuse(file, where + " holds a value that is not finite (it is damaged). Write it again");
}

std::vector<Matrix> read_csv(const std::filesystem::path& file, const std::string& text) {
  std::vector<Matrix> matrices;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r,;") == std::string::npos || line[0] == '#') continue;
    Matrix matrix{};
    std::size_t count = 0;
    if (!read_numbers(line, matrix, count)) {
      if (matrices.empty()) continue;  // a heading
      refuse(file,
             fmt::format("has words in line {} (a matrix is twelve numbers). Mend it", number));
    }
    if (count != 12)
      refuse(file, fmt::format("has {} numbers in line {} (a 3 x 4 matrix is twelve). Mend it",
                               count, number));
    check(matrix, file, fmt::format("in line {}", number));
    matrices.push_back(matrix);
    if (matrices.size() > kMostFrames) refuse(file, "has more than 10000 matrices. Cut it");
  }
  return matrices;
}

/// In our axes and in pixels.
Matrix from_rtk(const Matrix& rtk, const DetectorPixels& pixels) {
  Matrix matrix{};
  for (std::size_t row = 0; row < 3; ++row)
    matrix[row] = {rtk[row][0], -rtk[row][2], rtk[row][1], rtk[row][3]};
  for (std::size_t side = 0; side < 2; ++side) {
    const double spacing = pixels.spacing_mm[side];
    const double zero = pixels.first_mm ? -(*pixels.first_mm)[side] / spacing
                                        : 0.5 * (pixels.count[side] - 1);  // which pixel lies there
    for (std::size_t k = 0; k < 4; ++k)
      matrix[side][k] = matrix[side][k] / spacing + zero * matrix[2][k];
  }
  return matrix;
}

std::vector<Matrix> read_xml(const std::filesystem::path& file, const std::string& text) {
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
    refuse(file, "is no whole XML (it is damaged). Write it again");
  const tinyxml2::XMLElement* root = document.FirstChildElement("RTKThreeDCircularGeometry");
  if (!root)
    refuse(file,
           "is not RTK's (it has no RTKThreeDCircularGeometry). Give one that rtk wrote, or "
           "a CSV of matrices");
  std::vector<Matrix> matrices;
  for (const auto* p = root->FirstChildElement("Projection"); p;
       p = p->NextSiblingElement("Projection")) {
    const std::string where = fmt::format("in projection {}", matrices.size() + 1);
    const auto* element = p->FirstChildElement("Matrix");
    Matrix matrix{};
    std::size_t count = 0;
    if (!element || !element->GetText() || !read_numbers(element->GetText(), matrix, count) ||
        count != 12)
      refuse(file, where + " has no matrix of twelve numbers. Write it again");
    check(matrix, file, where);
    matrices.push_back(matrix);
    if (matrices.size() > kMostFrames) refuse(file, "has more than 10000 projections. Cut it");
  }
  return matrices;
}

/// The place that the rays through the pictures' middles pass nearest, by least squares.
Vec3 looked_at(const std::vector<Matrix>& matrices, int columns, int rows) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Matrix& m : matrices) {
    Eigen::Matrix3d left;
    Eigen::Vector3d last;
    for (int row = 0; row < 3; ++row) {
      for (int k = 0; k < 3; ++k) left(row, k) = m[std::size_t(row)][std::size_t(k)];
      last[row] = m[std::size_t(row)][3];
    }
    const Eigen::Matrix3d inverse = left.inverse();
    const Eigen::Vector3d source = -inverse * last;
    const Eigen::Vector3d ray =
        (inverse * Eigen::Vector3d(0.5 * (columns - 1), 0.5 * (rows - 1), 1.0)).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    sum += across;
    right += across * source;
  }
  const Eigen::Vector3d x = sum.ldlt().solve(right);
  return x.allFinite() ? Vec3{x.x(), x.y(), x.z()} : Vec3{};
}

/// The detector so far from the source that its pixels have their size.
ConeBeamFrame as_far_as_its_pixels(ConeBeamFrame frame, double column_spacing_mm) {
  const double far = column_spacing_mm / norm(frame.column_step);
  frame.first_pixel = frame.source + far * (frame.first_pixel - frame.source);
  frame.column_step *= far;
  frame.row_step *= far;
  return frame;
}

}  // namespace

std::string rtk_geometry(const std::vector<ConeBeamFrame>& frames) {
  std::string xml =
      "<?xml version=\"1.0\"?>\n<!DOCTYPE RTKGEOMETRY>\n<RTKThreeDCircularGeometry "
      "version=\"3\">\n";
  for (const ConeBeamFrame& frame : frames) {
    const RtkNumbers n = rtk_numbers(frame);
    const auto put = [&](const char* key, double value) {
      xml += fmt::format("    <{0}>{1:.12g}</{0}>\n", key, value);
    };
    xml += "  <Projection>\n";
    put("GantryAngle", n.gantry);
    put("SourceToIsocenterDistance", n.source_distance);
    put("SourceToDetectorDistance", n.detector_distance);
    put("SourceOffsetX", n.source_x);
    put("SourceOffsetY", n.source_y);
    put("ProjectionOffsetX", n.picture_x);
    put("ProjectionOffsetY", n.picture_y);
    put("InPlaneAngle", n.in_plane);
    put("OutOfPlaneAngle", n.out_of_plane);
    xml += "    <Matrix>\n";
    for (const auto& row : rtk_matrix(frame))
      xml += fmt::format("      {:.14g} {:.14g} {:.14g} {:.14g}\n", row[0], row[1], row[2], row[3]);
    xml += "    </Matrix>\n  </Projection>\n";
  }
  return xml + "</RTKThreeDCircularGeometry>\n";
}

std::vector<ConeBeamFrame> read_geometry(const std::filesystem::path& file,
                                         const DetectorPixels& pixels) {
  const std::string text = read_text(file);
  const std::size_t begin = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  const bool is_xml = begin != std::string::npos && text[begin] == '<';
  std::vector<Matrix> matrices = is_xml ? read_xml(file, text) : read_csv(file, text);
  if (matrices.empty())
    refuse(file, "holds no matrix. Give RTK's XML, or a CSV of twelve numbers a line");
  const bool has_spacing = pixels.spacing_mm[0] > 0.0 && pixels.spacing_mm[1] > 0.0;
  if (is_xml && !has_spacing)
    refuse(file,
           "is RTK's, in mm on the detector, but the frames state no pixel spacing. Give it "
           "with --spacing, or a CSV of matrices in pixels");
  if (is_xml)
    for (Matrix& matrix : matrices) matrix = from_rtk(matrix, pixels);
  const auto [columns, rows] = pixels.count;
  const Vec3 middle = looked_at(matrices, columns, rows);
  std::vector<ConeBeamFrame> frames;
  for (const Matrix& matrix : matrices)
    frames.push_back(
        as_far_as_its_pixels(angiogram::frame_from_matrix(matrix, middle, columns, rows),
                             has_spacing ? pixels.spacing_mm[0] : 1.0));
  return frames;
}

}  // namespace angio::reconstruction
