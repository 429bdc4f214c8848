#pragma once

#include <string>

#include "viewer/detail/picture.hpp"
#include "viewer/detail/scene.hpp"

/// Several panels in one picture.
namespace angio::viewer::detail {

/// A renderer on white paper.
vtkSmartPointer<vtkRenderer> make_stage();

/// The title in a panel's upper left corner.
void add_panel_title(vtkRenderer* renderer, const std::string& title, int panel_height);

/// Panels row by row on one sheet, with a strip for their keys below.
class Sheet {
 public:
  Sheet(int columns, std::size_t panel_count, int panel_width, int panel_height, int strip_height);

  void add(vtkRenderer* renderer);
  /// @param mm_per_pixel  of the panels, for the scale bar; 0: none
  void add_strip(vtkRenderer* renderer, int strip_height, double mm_per_pixel);
  [[nodiscard]] Picture take() { return std::move(picture_); }

  static constexpr int kGutter = 14;  // [pixel]

 private:
  int columns_, panel_width_, panel_height_;
  int next_ = 0;
  Picture picture_;
};

}  // namespace angio::viewer::detail
