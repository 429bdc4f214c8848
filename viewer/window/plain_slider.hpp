#pragma once

#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkSliderRepresentation2D.h>
#include <vtkSliderWidget.h>
#include <vtkSmartPointer.h>

#include "viewer/window/layout.hpp"

namespace angio::viewer::window {

/// A slider in the window's colours, without a title.
struct PlainSlider {
  vtkSmartPointer<vtkSliderRepresentation2D> look;
  vtkSmartPointer<vtkSliderWidget> widget;
  PixelBox track;
};

/// From 0 to 1, without a label. Its widget tells of every motion (InteractionEvent).
PlainSlider make_slider(vtkRenderWindowInteractor* interactor, vtkRenderer* front);

/// Where its knob runs; hidden where the track has no width.
void place(PlainSlider& slider, const PixelBox& track, vtkRenderer* front);

}  // namespace angio::viewer::window
