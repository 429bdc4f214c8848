#include "viewer/window/two_sided_surface.hpp"

#include <vtkProperty.h>

namespace angio::viewer::window {

TwoSidedSurface::TwoSidedSurface(const detail::Rgb& color) {
  for (const auto& [actor, mapper] :
       {std::pair<vtkActor*, vtkPolyDataMapper*>(far_, far_mapper_), {near_, near_mapper_}}) {
    mapper->ScalarVisibilityOff();
    actor->SetMapper(mapper);
    vtkProperty* look = actor->GetProperty();
    look->SetColor(color[0] / 255.0, color[1] / 255.0, color[2] / 255.0);
    look->SetAmbient(0.25);
    look->SetDiffuse(0.75);
    look->SetSpecular(0.15);
    look->SetSpecularPower(25.0);
  }
  far_->GetProperty()->FrontfaceCullingOn();
  update();
}

void TwoSidedSurface::set_input(vtkPolyData* surface) {
  has_input_ = surface && surface->GetNumberOfPoints() > 0;
  if (has_input_)
    for (vtkPolyDataMapper* mapper : {far_mapper_.Get(), near_mapper_.Get()})
      mapper->SetInputData(surface);
  update();
}

void TwoSidedSurface::set_visible(bool is_visible) {
  is_visible_ = is_visible;
  update();
}

void TwoSidedSurface::set_opacity(double opacity) {
  opacity_ = opacity;
  update();
}

void TwoSidedSurface::set_drawn(Drawn drawn) {
  for (vtkActor* actor : {far_.Get(), near_.Get()})
    actor->GetProperty()->SetRepresentation(drawn == Drawn::as_wireframe ? VTK_WIREFRAME
                                                                         : VTK_SURFACE);
}

void TwoSidedSurface::set_clipping(vtkPlane* plane) {
  for (vtkPolyDataMapper* mapper : {far_mapper_.Get(), near_mapper_.Get()}) {
    mapper->RemoveAllClippingPlanes();
    if (plane) mapper->AddClippingPlane(plane);
  }
}

void TwoSidedSurface::color_by(const char* array, bool is_on_cells, vtkColorTransferFunction* map) {
  for (vtkPolyDataMapper* mapper : {far_mapper_.Get(), near_mapper_.Get()}) {
    mapper->SetScalarVisibility(map ? 1 : 0);
    if (!map) continue;
    if (is_on_cells)
      mapper->SetScalarModeToUseCellFieldData();
    else
      mapper->SetScalarModeToUsePointFieldData();
    mapper->SelectColorArray(array);
    mapper->SetColorModeToMapScalars();
    map->SetVectorModeToMagnitude();
    mapper->SetLookupTable(map);
    mapper->UseLookupTableScalarRangeOn();
    mapper->SetInterpolateScalarsBeforeMapping(is_on_cells ? 0 : 1);
  }
}

void TwoSidedSurface::update() {
  const bool is_shown = has_input_ && is_visible_ && opacity_ > 0.0;
  const bool is_translucent = opacity_ < 1.0;
  near_->SetVisibility(is_shown ? 1 : 0);
  far_->SetVisibility(is_shown && is_translucent ? 1 : 0);
  near_->GetProperty()->SetBackfaceCulling(is_translucent ? 1 : 0);
  for (vtkActor* actor : {far_.Get(), near_.Get()}) actor->GetProperty()->SetOpacity(opacity_);
}

}  // namespace angio::viewer::window
