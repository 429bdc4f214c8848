#pragma once

#include <vector>

#include "angiogram/cone_beam.hpp"
#include "core/vec3.hpp"
#include "reconstruction/detail/vessel_lines.hpp"
#include "reconstruction/reconstruction.hpp"

namespace angio::reconstruction::detail {

/// What one view of standing vessels shows of them.
struct ViewPicture {
  angiogram::ConeBeamFrame frame;
  std::vector<float> vessels;  ///< line integrals without what is wide, shape [rows, columns]
  VesselLines lines;
  std::vector<int> nearest;     ///< line pixel, -1: there is none
  std::vector<float> distance;  ///< from it [pixels]
  double pixel_mm = 0.0;        ///< on the detector
};

/// Where a view has a place of the patient.
struct LineNear {
  bool is_seen = false;
  int pixel = -1;            ///< of the nearest line, -1: none
  double distance_mm = 0.0;  ///< from it, at the place's depth
  double radius_mm = 0.0;    ///< of the vessel there, were it at that depth
};

/// A view whose lines are found.
/// @param vessels  line integrals without what is wide
/// @param covered  pixels where no line is taken, 1; empty: none
/// @param widest_mm  diameter of the widest vessel, at the isocentre
ViewPicture make_view_picture(const angiogram::ConeBeamFrame& frame, std::vector<float> vessels,
                              const std::vector<char>& covered, double widest_mm);

/// Its lines' distances anew, after lines were taken out.
void find_nearest(ViewPicture& picture);

/// A pixel's size at the isocentre [mm]; of some frames the smallest.
double pixel_at_isocentre(const angiogram::ConeBeamFrame& frame);
double finest_pixel(const std::vector<angiogram::ConeBeamFrame>& frames);

/// A frame taken from elsewhere.
angiogram::ConeBeamFrame shifted(angiogram::ConeBeamFrame frame, const Vec3& by);

/// Looks places up in a view.
class ViewLookup {
 public:
  explicit ViewLookup(const ViewPicture& picture) : picture_(picture), view_(picture.frame) {}
  [[nodiscard]] LineNear at(const Vec3& place) const;
  [[nodiscard]] angiogram::SeenPoint see(const Vec3& place) const { return view_.see(place); }
  /// A pixel's size at a depth [mm].
  [[nodiscard]] double pixel_mm(double depth) const { return picture_.pixel_mm * depth; }
  [[nodiscard]] const ViewPicture& picture() const { return picture_; }

 private:
  const ViewPicture& picture_;
  angiogram::ConeBeamView view_;
};

}  // namespace angio::reconstruction::detail
