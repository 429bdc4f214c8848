#pragma once

#include <vtkAbstractWidget.h>
#include <vtkActor.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkSmartPointer.h>

#include <functional>
#include <vector>

namespace angio::viewer::window {

enum class MeasureKind { distance, angle };

/// Distances [mm] and angles [degrees], measured by clicks with VTK's widgets. In a slice the
/// points lie in its plane; in the scene on the surface under the pointer.
class Measures {
 public:
  /// @param find_renderer     the view at a pixel of the window; null: none to measure in
  /// @param surfaces_of  what points of a view are kept to; none: its focal plane
  Measures(vtkRenderWindowInteractor* interactor,
           std::function<vtkRenderer*(int x, int y)> find_renderer,
           std::function<std::vector<vtkActor*>(vtkRenderer*)> surfaces_of);
  ~Measures();
  Measures(const Measures&) = delete;
  Measures& operator=(const Measures&) = delete;

  /// The next click begins a measurement; asked for twice, it does not.
  void start(MeasureKind kind);
  [[nodiscard]] bool is_waiting(MeasureKind kind) const {
    return is_waiting_ && waiting_kind_ == kind;
  }
  void erase();

  /// Of the measurements whose points are all set, in their order.
  [[nodiscard]] std::vector<double> values() const;

 private:
  bool on_press(vtkObject*, unsigned long, void*);
  void add_distance(vtkRenderer* view);
  void add_angle(vtkRenderer* view);
  template <class Widget, class Representation>
  void begin(Widget* widget, Representation* look, vtkRenderer* view);

  vtkRenderWindowInteractor* interactor_;
  std::function<vtkRenderer*(int, int)> find_renderer_;
  std::function<std::vector<vtkActor*>(vtkRenderer*)> surfaces_of_;
  std::vector<vtkSmartPointer<vtkAbstractWidget>> widgets_;
  MeasureKind waiting_kind_ = MeasureKind::distance;
  bool is_waiting_ = false;
  unsigned long observer_ = 0;
};

}  // namespace angio::viewer::window
