#pragma once

#include <vtkInteractorStyleTrackballCamera.h>

#include <functional>
#include <vector>

namespace angio::viewer::window {

/// The mouse: VTK's trackball in the scene; in the slices left drags window and level, the wheel
/// scrolls, middle and right move and zoom; in the curve left drags the cursor. Keys are not its.
class MouseStyle : public vtkInteractorStyleTrackballCamera {
 public:
  static MouseStyle* New();
  vtkTypeMacro(MouseStyle, vtkInteractorStyleTrackballCamera);

  struct Panels {
    std::vector<vtkRenderer*> slices;
    vtkRenderer* curve = nullptr;
    std::function<void(int dx, int dy)> on_grey;                   ///< [pixel]
    std::function<void(vtkRenderer* panel, int steps)> on_scroll;  ///< away from the user: +1
    std::function<void(int x)> on_curve;                           ///< of the window [pixel]
  };
  void set_panels(Panels panels);

  void OnLeftButtonDown() override;
  void OnLeftButtonUp() override;
  void OnMiddleButtonDown() override;
  void OnRightButtonDown() override;
  void OnMouseMove() override;
  void OnMouseWheelForward() override;
  void OnMouseWheelBackward() override;
  void OnChar() override {}

 private:
  enum class Drag { none, grey, curve };
  /// The renderer under the pointer.
  vtkRenderer* find_panel();
  [[nodiscard]] bool is_slice(vtkRenderer* panel) const;

  Panels panels_;
  Drag drag_ = Drag::none;
};

}  // namespace angio::viewer::window
