#pragma once

#include <gtest/gtest.h>
#include <vtkCommand.h>
#include <vtkRenderWindowInteractor.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "formats/vtk_messages.hpp"
#include "testing/viewer/case_folder.hpp"
#include "testing/viewer/shapes.hpp"
#include "viewer/detail/offscreen.hpp"
#include "viewer/window/view_window.hpp"

namespace angio::viewer::window::test {
using detail::Picture;
using viewer::test::TemporaryFolder;

/// A window on a case of the viewer's tests, and a hand on its mouse.
class ViewWindowTest : public testing::Test {
 protected:
  ViewWindowTest() {
    viewer::test::write_case(folder_.path());
    open();
  }

  void open() {
    view_.reset();
    ViewOptions options;
    options.width = 1200;
    options.height = 800;
    options.save_folder = folder_.path();
    view_ = std::make_unique<ViewWindow>(folder_.path(), options, ViewWindow::Place::on_screen);
    view_->picture();
  }

  void event_at(int x, int y, unsigned long event) {
    view_->interactor()->SetEventInformation(x, y);
    view_->interactor()->InvokeEvent(event);
  }
  void click(int x, int y) {
    event_at(x, y, vtkCommand::MouseMoveEvent);
    event_at(x, y, vtkCommand::LeftButtonPressEvent);
    event_at(x, y, vtkCommand::LeftButtonReleaseEvent);
  }
  void click(const PixelBox& box) {
    ASSERT_GT(box.width, 0);
    click(box.left + box.width / 2, box.bottom + box.height / 2);
  }
  void click(Action action) { click(view_->controls().button_box(action)); }
  void drag(int x0, int y0, int x1, int y1) {
    event_at(x0, y0, vtkCommand::MouseMoveEvent);
    event_at(x0, y0, vtkCommand::LeftButtonPressEvent);
    event_at(x1, y1, vtkCommand::MouseMoveEvent);
    event_at(x1, y1, vtkCommand::LeftButtonReleaseEvent);
  }
  void scroll(const PixelBox& box, unsigned long event) {
    event_at(box.left + box.width / 2, box.bottom + box.height / 2, event);
  }
  static PixelBox middle_of(const PixelBox& box) {
    return {box.left + box.width / 4, box.bottom + box.height / 4, box.width / 2, box.height / 2};
  }

  /// Pixels of a box that differ between two pictures by more than rounding.
  static int changed(const Picture& a, const Picture& b, const PixelBox& box) {
    int count = 0;
    for (int y = box.bottom; y < box.top(); ++y)
      for (int x = box.left; x < box.right(); ++x) {
        const std::size_t at =
            (std::size_t(a.height - 1 - y) * std::size_t(a.width) + std::size_t(x)) * 3;
        int difference = 0;
        for (std::size_t c = 0; c < 3; ++c)
          difference = std::max(difference, std::abs(int(a.rgb[at + c]) - int(b.rgb[at + c])));
        count += difference > 12 ? 1 : 0;
      }
    return count;
  }
  static int count_blue(const Picture& picture, const PixelBox& box) {
    return count(picture, box, [](int r, int, int b) { return b > r + 30; });
  }
  template <class Judge>
  static int count(const Picture& picture, const PixelBox& box, Judge judge) {
    int found = 0;
    for (int y = box.bottom; y < box.top(); ++y)
      for (int x = box.left; x < box.right(); ++x) {
        const std::uint8_t* p =
            picture.rgb.data() +
            (std::size_t(picture.height - 1 - y) * std::size_t(picture.width) + std::size_t(x)) * 3;
        found += judge(p[0], p[1], p[2]) ? 1 : 0;
      }
    return found;
  }
  [[nodiscard]] PixelBox scene() const { return middle_of(view_->layout().scene); }

  TemporaryFolder folder_;
  detail::OffscreenDisplay display_;
  formats::VtkMessages messages_;
  std::unique_ptr<ViewWindow> view_;
};

}  // namespace angio::viewer::window::test
