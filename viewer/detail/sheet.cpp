#include "viewer/detail/sheet.hpp"

#include <vtkTextProperty.h>

#include "viewer/detail/rendering.hpp"

namespace angio::viewer::detail {

vtkSmartPointer<vtkRenderer> make_stage() {
  auto renderer = vtkSmartPointer<vtkRenderer>::New();
  renderer->SetBackground(1.0, 1.0, 1.0);
  return renderer;
}

void add_panel_title(vtkRenderer* renderer, const std::string& title, int panel_height) {
  const auto text = make_text(title, 13 * kSupersampling, colors::kInk);
  text->SetPosition(8.0 * kSupersampling, (panel_height - 20.0) * kSupersampling);
  text->GetTextProperty()->SetBackgroundColor(1.0, 1.0, 1.0);
  text->GetTextProperty()->SetBackgroundOpacity(0.85);
  renderer->AddActor2D(text);
}

Sheet::Sheet(int columns, std::size_t panel_count, int panel_width, int panel_height,
             int strip_height)
    : columns_(columns),
      panel_width_(panel_width),
      panel_height_(panel_height),
      picture_(blank_picture(
          columns * panel_width,
          (int(panel_count) + columns - 1) / columns * panel_height + strip_height)) {}

void Sheet::add(vtkRenderer* renderer) {
  // A gutter of white paper parts neighbours.
  paste(render_offscreen({renderer}, panel_width_ - kGutter, panel_height_ - kGutter),
        next_ % columns_ * panel_width_ + kGutter / 2,
        next_ / columns_ * panel_height_ + kGutter / 2, picture_);
  ++next_;
}

void Sheet::add_strip(vtkRenderer* renderer, int strip_height, double mm_per_pixel) {
  ViewFrame frame;
  frame.half_width_mm = 0.5 * mm_per_pixel * picture_.width;
  frame.half_height_mm = 0.5 * mm_per_pixel * strip_height;
  aim(renderer, frame, double(picture_.width) / strip_height);
  ScaleBar bar(renderer, kSupersampling, colors::kInk);
  paste(render_offscreen({renderer}, picture_.width, strip_height, [&] { bar.update(); }), 0,
        picture_.height - strip_height, picture_);
}

}  // namespace angio::viewer::detail
