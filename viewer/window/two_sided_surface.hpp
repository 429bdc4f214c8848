#pragma once

#include <vtkActor.h>
#include <vtkColorTransferFunction.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkRenderer.h>

#include "viewer/detail/picture.hpp"

namespace angio::viewer::window {

enum class Drawn { as_surface, as_wireframe };

/// A surface that may be translucent without depth peeling: its far side and its near side are
/// actors of their own. Drawn far side, what is inside, near side, in that order, a closed surface
/// blends as it should at the price of two passes (peeling takes one for each of its layers, over
/// the whole picture).
class TwoSidedSurface {
 public:
  explicit TwoSidedSurface(const detail::Rgb& color);

  /// @param surface  with normals outward; null shows nothing
  void set_input(vtkPolyData* surface);
  void set_visible(bool is_visible);
  void set_opacity(double opacity);  ///< (0, 1]; 1 draws one pass
  void set_drawn(Drawn drawn);
  void set_clipping(vtkPlane* plane);  ///< hides what lies behind it; null: nothing
  /// Colours by an array of the input. @param map  null: the plain colour
  void color_by(const char* array, bool is_on_cells, vtkColorTransferFunction* map);

  void add_far_side(vtkRenderer* renderer) { renderer->AddActor(far_); }
  void add_near_side(vtkRenderer* renderer) { renderer->AddActor(near_); }
  [[nodiscard]] bool is_visible() const { return is_visible_; }
  [[nodiscard]] double opacity() const { return opacity_; }
  [[nodiscard]] vtkActor* picked_actor() { return near_; }

 private:
  void update();

  vtkNew<vtkActor> far_, near_;
  vtkNew<vtkPolyDataMapper> far_mapper_, near_mapper_;
  bool has_input_ = false, is_visible_ = true;
  double opacity_ = 1.0;
};

}  // namespace angio::viewer::window
