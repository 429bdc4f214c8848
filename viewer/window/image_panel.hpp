#pragma once

#include <vtkActor.h>
#include <vtkImageResliceMapper.h>
#include <vtkImageSlice.h>
#include <vtkNew.h>
#include <vtkPolyDataMapper.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>

#include <array>
#include <string>
#include <vector>

#include "core/triangle_mesh.hpp"
#include "viewer/detail/picture.hpp"
#include "viewer/detail/scene.hpp"
#include "viewer/window/scan_image.hpp"

namespace angio::viewer::window {

/// A surface of which a panel shows the section.
struct Contour {
  const TriangleMesh* mesh;  ///< lives until other contours are set; null: nothing
  detail::Rgb color;
};

/// Where a panel's plane lies, and which way is up in it.
struct PanelPlane {
  Vec3 point;          ///< LPS [mm], in the panel's middle
  Vec3 direction;      ///< unit, away from the eye
  Vec3 up;             ///< unit, at right angles to direction
  bool is_new = true;  ///< not the same view moved on: centre it
};

/// A flat view: a slice of the scan in any plane, with exact sections of surfaces over it.
class ImagePanel {
 public:
  /// @param scan            null: contours alone
  /// @param half_height_mm  shown above and below the middle at the start, > 0
  ImagePanel(const ScanImage* scan, double half_height_mm);

  [[nodiscard]] vtkRenderer* renderer() const { return renderer_; }

  void look_at(const PanelPlane& plane);
  void set_half_height(double half_height_mm);
  /// The brightest of this thickness [mm] instead of one slice; 0: one slice.
  void set_slab(double thickness_mm);
  void set_contours(const std::vector<Contour>& contours);
  void set_words(const std::string& title, const std::string& footer);
  /// Letters at the left, right, top and bottom edge; empty: none.
  void set_edge_letters(const std::array<std::string, 4>& letters);
  void update_overlays() { scale_bar_.update(); }

 private:
  struct Line {
    const TriangleMesh* mesh = nullptr;
    vtkSmartPointer<vtkPolyDataMapper> mapper;
    vtkSmartPointer<vtkActor> actor;
  };
  void cut(Line& line) const;

  vtkSmartPointer<vtkRenderer> renderer_;
  detail::ScaleBar scale_bar_;
  vtkNew<vtkImageResliceMapper> mapper_;
  vtkNew<vtkImageSlice> slice_;
  Vec3 plane_point_, plane_normal_{0, 0, 1};
  std::vector<Line> lines_;
  vtkSmartPointer<vtkTextActor> title_, footer_;
  std::array<vtkSmartPointer<vtkTextActor>, 4> letters_;
};

}  // namespace angio::viewer::window
