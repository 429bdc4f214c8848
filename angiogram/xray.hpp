#pragma once

#include <vector>

#include "angiogram/c_arm.hpp"
#include "core/triangle_mesh.hpp"

namespace angio::angiogram {

/// A square picture of a view.
struct XrayFrame {
  CArmAngles angles;
  Vec3 center;                ///< in the picture's middle, LPS [mm]
  double half_size_mm = 1.0;  ///< shown to each side, > 0
  int pixels = 1;             ///< to a side, [1, 10000]

  [[nodiscard]] double pixel_mm() const { return 2.0 * half_size_mm / pixels; }
};

/// How much contrast medium each ray passes through: the length of its way inside a closed surface.
///
///     l(x, y) = sum over the triangles that the ray meets of +- z,   + where it leaves
///
/// with z of the meeting point along the ray, so that it is exact for the surface as it is, hollows
/// and pieces behind each other included. A ray through an edge or a corner meets one of the
/// triangles there: ties are broken as if all rays were moved by (e, e^2), e -> 0.
///
/// Rays are parallel (WorkingView) and go through the middles of the pixels.
/// @param mesh  closed, normals outward; an open one tells nothing behind its holes
/// @return [mm], rows from the top, shape [pixels, pixels]
/// @throws InputError  the frame is out of range
std::vector<double> chord_lengths(const TriangleMesh& mesh, const XrayFrame& frame);

/// The share of the beam that is left (Beer, Lambert), as a subtracted picture shows it:
///
///     I / I0 = exp(-mu l)
///
/// @param attenuation_per_mm  mu of contrast medium above that of what it takes the place of
///                            [1/mm], > 0
std::vector<double> transmissions(std::vector<double> chords_mm, double attenuation_per_mm);

/// mu of 320 mg of iodine in a mL, at 60 keV [1/mm]: 7.58 cm^2/g (NIST, Hubbell, Seltzer, NISTIR
/// 5632) times 0.32 g/mL.
inline constexpr double kContrastMedium = 0.243;

/// An open surface with each rim closed by triangles to its middle.
TriangleMesh with_caps(TriangleMesh open);

}  // namespace angio::angiogram
