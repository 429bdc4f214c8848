#pragma once

#include <vtkActor2D.h>
#include <vtkButtonRepresentation.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkTextActor.h>

#include <string>

#include "viewer/window/layout.hpp"

namespace angio::viewer::window {

/// What a vtkButtonWidget shows: a word in a box of fixed pixels, lit while it is on.
class TextButton : public vtkButtonRepresentation {
 public:
  static TextButton* New();
  vtkTypeMacro(TextButton, vtkButtonRepresentation);

  void set_word(const std::string& word);
  void place(const PixelBox& box);  ///< an empty box hides it
  void set_on(bool is_on);
  [[nodiscard]] const PixelBox& box() const { return box_; }

  int ComputeInteractionState(int x, int y, int modify = 0) override;
  void Highlight(int state) override;
  void BuildRepresentation() override {}
  void GetActors2D(vtkPropCollection* parts) override;
  void ReleaseGraphicsResources(vtkWindow* window) override;
  int RenderOverlay(vtkViewport* viewport) override;
  int RenderOpaqueGeometry(vtkViewport* viewport) override;
  vtkTypeBool HasTranslucentPolygonalGeometry() override { return 0; }

 protected:
  TextButton();

 private:
  void paint();

  PixelBox box_;
  bool is_on_ = false;
  vtkNew<vtkPoints> corners_;
  vtkNew<vtkActor2D> ground_;
  vtkNew<vtkTextActor> word_;
};

}  // namespace angio::viewer::window
