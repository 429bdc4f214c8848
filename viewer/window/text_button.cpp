#include "viewer/window/text_button.hpp"

#include <vtkCellArray.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkPropCollection.h>
#include <vtkProperty2D.h>
#include <vtkTextProperty.h>

#include "viewer/window/colors.hpp"

namespace angio::viewer::window {

vtkStandardNewMacro(TextButton);

TextButton::TextButton() {
  corners_->SetNumberOfPoints(4);
  vtkNew<vtkCellArray> cells;
  cells->InsertNextCell({0, 1, 2, 3});
  vtkNew<vtkPolyData> box;
  box->SetPoints(corners_);
  box->SetPolys(cells);
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(box);
  ground_->SetMapper(mapper);
  vtkTextProperty* text = word_->GetTextProperty();
  text->SetFontFamilyToArial();
  text->SetFontSize(13);
  text->SetColor(0.9, 0.92, 0.94);
  text->SetJustificationToCentered();
  text->SetVerticalJustificationToCentered();
  SetNumberOfStates(1);
  place({});
  paint();
}

void TextButton::set_word(const std::string& word) { word_->SetInput(word.c_str()); }

void TextButton::place(const PixelBox& box) {
  box_ = box;
  corners_->SetPoint(0, box.left, box.bottom, 0);
  corners_->SetPoint(1, box.right(), box.bottom, 0);
  corners_->SetPoint(2, box.right(), box.top(), 0);
  corners_->SetPoint(3, box.left, box.top(), 0);
  corners_->Modified();
  word_->SetPosition(box.left + 0.5 * box.width, box.bottom + 0.5 * box.height);
  SetVisibility(box.width > 0 ? 1 : 0);
}

void TextButton::set_on(bool is_on) {
  is_on_ = is_on;
  paint();
}

int TextButton::ComputeInteractionState(int x, int y, int) {
  InteractionState = GetVisibility() && box_.contains(x, y) ? Inside : Outside;
  return InteractionState;
}

void TextButton::Highlight(int state) {
  Superclass::Highlight(state);
  paint();
}

void TextButton::paint() {
  const detail::Rgb& color = HighlightState != HighlightNormal ? colors::kButtonTouched
                             : is_on_                          ? colors::kButtonOn
                                                               : colors::kButton;
  ground_->GetProperty()->SetColor(color[0] / 255.0, color[1] / 255.0, color[2] / 255.0);
}

void TextButton::GetActors2D(vtkPropCollection* parts) {
  parts->AddItem(ground_);
  parts->AddItem(word_);
}

void TextButton::ReleaseGraphicsResources(vtkWindow* window) {
  ground_->ReleaseGraphicsResources(window);
  word_->ReleaseGraphicsResources(window);
}

int TextButton::RenderOpaqueGeometry(vtkViewport* viewport) {
  return word_->RenderOpaqueGeometry(viewport);
}

int TextButton::RenderOverlay(vtkViewport* viewport) {
  return ground_->RenderOverlay(viewport) + word_->RenderOverlay(viewport);
}

}  // namespace angio::viewer::window
