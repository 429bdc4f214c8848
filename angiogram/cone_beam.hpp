#pragma once

#include <array>
#include <vector>

#include "angiogram/c_arm.hpp"
#include "core/triangle_mesh.hpp"

namespace angio::angiogram {

/// A frame of a C-arm: its X-ray source and its flat detector, in LPS [mm]. Columns are counted to
/// the right and rows down, from the middle of the first pixel.
struct ConeBeamFrame {
  Vec3 source;
  Vec3 first_pixel;  ///< its middle
  Vec3 column_step;  ///< from a pixel to the next in its row
  Vec3 row_step;     ///< from a pixel to the next in its column
  int columns = 1, rows = 1;

  [[nodiscard]] Vec3 place(double column, double row) const {
    return first_pixel + column * column_step + row * row_step;
  }
};

/// Where a frame sees a point.
struct SeenPoint {
  double column = 0.0, row = 0.0;
  /// How far along its ray the point lies: 0 at the source, 1 on the detector; the ray runs the
  /// other way where it is not positive.
  double depth = 0.0;
};

/// Where a frame sees points:
///
///     depth (column, row, 1)^T = A (x - source),   A = (column_step, row_step, first - source)^-1
///
/// (Hartley, Zisserman, Multiple View Geometry, 2004, eq. 6.11: the camera A [I | -source]).
class ConeBeamView {
 public:
  /// @throws InputError  the source lies in the detector's plane, or a step is zero
  explicit ConeBeamView(const ConeBeamFrame& frame);

  [[nodiscard]] SeenPoint see(const Vec3& point) const {
    const Vec3 seen = inverse_ * (point - source_);
    return {seen.x / seen.z, seen.y / seen.z, seen.z};
  }
  /// The matrix from (x, y, z, 1) in LPS [mm] to depth (column, row, 1), shape [3, 4].
  [[nodiscard]] std::array<std::array<double, 4>, 3> matrix() const;

 private:
  Vec3 source_;
  Mat3 inverse_;
};

/// The frame that a 3 x 4 matrix describes, up to its scale: depth is 1 at `in_front`.
/// @param matrix    from (x, y, z, 1) to a multiple of (column, row, 1)
/// @param in_front  a point that the source looks at; the detector's plane goes through it
/// @throws InputError  the matrix has no inverse
ConeBeamFrame frame_from_matrix(const std::array<std::array<double, 4>, 3>& matrix,
                                const Vec3& in_front, int columns, int rows);

/// How a C-arm's source and detector are mounted.
struct CArmMount {
  double source_to_detector_mm = 1200.0;
  double source_to_isocentre_mm = 800.0;
  double column_spacing_mm = 0.4;  ///< on the detector, from a column to the next
  double row_spacing_mm = 0.4;
  int columns = 1, rows = 1;
  /// Where the ray through the isocentre meets the detector [pixels]; by default its middle.
  double central_column = 0.0, central_row = 0.0;
};

/// The frame of a C-arm that stands at some angles around the isocentre, which is the origin (DICOM
/// PS3.3 C.8.7.5): c_arm_axes() with rows downward.
ConeBeamFrame c_arm_frame(const CArmAngles& angles, const CArmMount& mount);

/// As chord_lengths() of an XrayFrame, for the rays from a source: what each passes through inside
/// a closed surface [mm].
///
///     l(c, r) = |place(c, r) - source| sum over the triangles that the ray meets of +- depth
///
/// with 1 / depth linear on each triangle in the picture, so that it is exact, too.
/// @param mesh  closed, normals outward, wholly in front of the source
/// @return [mm], shape [rows, columns]
/// @throws InputError  a vertex lies behind the source
std::vector<double> chord_lengths(const TriangleMesh& mesh, const ConeBeamFrame& frame);

}  // namespace angio::angiogram
