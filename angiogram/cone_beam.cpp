#include "angiogram/cone_beam.hpp"

#include <algorithm>
#include <cmath>

#include "angiogram/triangle_pixels.hpp"
#include "core/error.hpp"

namespace angio::angiogram {
namespace {

Mat3 from_columns(const Vec3& a, const Vec3& b, const Vec3& c) {
  Mat3 m;
  for (int row = 0; row < 3; ++row) {
    m(row, 0) = a[row];
    m(row, 1) = b[row];
    m(row, 2) = c[row];
  }
  return m;
}

Vec3 column(const Mat3& m, int c) { return {m(0, c), m(1, c), m(2, c)}; }

/// The inverse, or nothing where the columns lie in a plane to rounding.
Mat3 checked_inverse(const Mat3& m, const char* problem) {
  constexpr double kFlat = 1e-12;
  const double size = norm(column(m, 0)) * norm(column(m, 1)) * norm(column(m, 2));
  if (!(std::abs(determinant(m)) > kFlat * size)) throw InputError(problem);
  return inverse(m);
}

}  // namespace

ConeBeamView::ConeBeamView(const ConeBeamFrame& frame)
    : source_(frame.source),
      inverse_(checked_inverse(
          from_columns(frame.column_step, frame.row_step, frame.first_pixel - frame.source),
          "a frame's source lies in its detector's plane (the geometry is damaged). Check the "
          "distances and the matrices")) {}

std::array<std::array<double, 4>, 3> ConeBeamView::matrix() const {
  const Vec3 shift = inverse_ * source_;
  std::array<std::array<double, 4>, 3> matrix{};
  for (int row = 0; row < 3; ++row)
    matrix[std::size_t(row)] = {inverse_(row, 0), inverse_(row, 1), inverse_(row, 2), -shift[row]};
  return matrix;
}

ConeBeamFrame frame_from_matrix(const std::array<std::array<double, 4>, 3>& matrix,
                                const Vec3& in_front, int columns, int rows) {
  Mat3 left;
  Vec3 last;
  for (int row = 0; row < 3; ++row) {
    for (int c = 0; c < 3; ++c) left(row, c) = matrix[std::size_t(row)][std::size_t(c)];
    last[row] = matrix[std::size_t(row)][3];
  }
  const Mat3 rays = checked_inverse(left,
                                    "a frame's matrix has no inverse (it is no projection from a "
                                    "point). Check the geometry file");
  ConeBeamFrame frame;
  frame.columns = columns;
  frame.rows = rows;
  frame.source = -(rays * last);
  const double depth = (left * (in_front - frame.source)).z;
  frame.column_step = depth * column(rays, 0);
  frame.row_step = depth * column(rays, 1);
  frame.first_pixel = frame.source + depth * column(rays, 2);
  return frame;
}

ConeBeamFrame c_arm_frame(const CArmAngles& angles, const CArmMount& mount) {
  const CArmAxes axes = c_arm_axes(angles);
  ConeBeamFrame frame;
  frame.columns = mount.columns;
  frame.rows = mount.rows;
  frame.source = -mount.source_to_isocentre_mm * axes.to_detector;
  frame.column_step = mount.column_spacing_mm * axes.right;
  frame.row_step = -mount.row_spacing_mm * axes.up;
  const Vec3 middle =
      (mount.source_to_detector_mm - mount.source_to_isocentre_mm) * axes.to_detector;
  frame.first_pixel =
      middle - mount.central_column * frame.column_step - mount.central_row * frame.row_step;
  return frame;
}

std::vector<double> chord_lengths(const TriangleMesh& mesh, const ConeBeamFrame& frame) {
  const ConeBeamView view(frame);
  std::vector<detail::Corner> corners;
  corners.reserve(mesh.vertices.size());
  for (const Vec3& vertex : mesh.vertices) {
    const SeenPoint seen = view.see(vertex);
    if (!(seen.depth > 0.0))
      throw InputError(
          "a surface reaches behind the X-ray source (its unit may be wrong). Check the distances");
    corners.push_back(
        {seen.column, frame.rows - 1 - seen.row, 1.0 / seen.depth, int(corners.size())});
  }
  // As the detector sees it, up and right as in a parallel picture, or mirrored.
  const Vec3 along = frame.place(0.5 * frame.columns, 0.5 * frame.rows) - frame.source;
  const double hand = dot(cross(frame.row_step, frame.column_step), along) > 0.0 ? 1.0 : -1.0;
  std::vector<double> chords(std::size_t(frame.columns) * std::size_t(frame.rows), 0.0);
  for (const Triangle& t : mesh.triangles)
    detail::add_triangle(
        {corners[std::size_t(t[0])], corners[std::size_t(t[1])], corners[std::size_t(t[2])]},
        frame.columns, frame.rows, [hand](double reciprocal) { return hand / reciprocal; }, chords);
  for (int row = 0; row < frame.rows; ++row)
    for (int c = 0; c < frame.columns; ++c) {
      double& chord = chords[std::size_t(row) * std::size_t(frame.columns) + std::size_t(c)];
      if (chord != 0.0) chord = std::max(chord, 0.0) * distance(frame.place(c, row), frame.source);
    }
  return chords;
}

}  // namespace angio::angiogram
