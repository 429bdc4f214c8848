#include "viewer/detail/scene.hpp"

#include <vtkActor2D.h>
#include <vtkActor2DCollection.h>
#include <vtkAxesActor.h>
#include <vtkCamera.h>
#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkProperty2D.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>
#include <vtkTubeFilter.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "formats/text.hpp"
#include "formats/vtk_arrays.hpp"
#include "viewer/detail/axis_letters.hpp"
#include "viewer/detail/chart.hpp"
#include "viewer/detail/mark.hpp"
#include "viewer/detail/scale_length.hpp"

namespace angio::viewer::detail {
namespace {

std::array<double, 3> unit_rgb(const Rgb& color) {
  return {color[0] / 255.0, color[1] / 255.0, color[2] / 255.0};
}

void shade(vtkProperty* property, const Rgb& color) {
  property->SetColor(unit_rgb(color).data());
  property->SetAmbient(0.28);
  property->SetDiffuse(0.72);
  property->SetSpecular(0.15);
  property->SetSpecularPower(25.0);
}

/// A line strip in pixels over the scene.
vtkSmartPointer<vtkActor2D> make_overlay_line(vtkPoints* points, const Rgb& color, float width) {
  vtkNew<vtkCellArray> cells;
  cells->InsertNextCell(int(points->GetNumberOfPoints()));
  for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i) cells->InsertCellPoint(i);
  vtkNew<vtkPolyData> line;
  line->SetPoints(points);
  line->SetLines(cells);
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(line);
  auto actor = vtkSmartPointer<vtkActor2D>::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(unit_rgb(color).data());
  actor->GetProperty()->SetLineWidth(width);
  return actor;
}

double half_height(const ViewFrame& frame, double picture_aspect) {
  return std::max(frame.half_height_mm, frame.half_width_mm / picture_aspect);
}

}  // namespace

vtkSmartPointer<vtkActor> make_surface(const TriangleMesh& mesh, const SurfaceStyle& style) {
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(formats::to_vtk(mesh));
  normals->SplittingOff();
  normals->ConsistencyOff();
  normals->Update();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(normals->GetOutput());
  mapper->ScalarVisibilityOff();
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  shade(actor->GetProperty(), style.color);
  actor->GetProperty()->SetOpacity(style.opacity);
  return actor;
}

void color_by(vtkActor* actor, const std::vector<double>& values, vtkColorTransferFunction* map) {
  vtkNew<vtkDoubleArray> array;
  array->SetName("shown");
  for (const double value : values) array->InsertNextValue(value);
  auto* mapper = vtkPolyDataMapper::SafeDownCast(actor->GetMapper());
  mapper->GetInput()->GetPointData()->SetScalars(array);
  mapper->SetLookupTable(map);
  mapper->UseLookupTableScalarRangeOn();
  mapper->InterpolateScalarsBeforeMappingOn();
  mapper->ScalarVisibilityOn();
}

void color_by_translucent(vtkActor* actor, const std::vector<double>& values,
                          vtkColorTransferFunction* map) {
  constexpr double kLeastOpacity = 0.38, kMostOpacity = 0.97;
  constexpr double kOpaqueFrom = 0.2;  // of the highest value
  const double high = map->GetRange()[1];
  vtkNew<vtkUnsignedCharArray> array;
  array->SetName("shown");
  array->SetNumberOfComponents(4);
  for (const double value : values) {
    double rgb[3];
    map->GetColor(value, rgb);
    const double share = std::clamp(value / (kOpaqueFrom * high), 0.0, 1.0);
    const double opacity = kLeastOpacity + share * (kMostOpacity - kLeastOpacity);
    array->InsertNextTuple4(255.0 * rgb[0], 255.0 * rgb[1], 255.0 * rgb[2], 255.0 * opacity);
  }
  auto* mapper = vtkPolyDataMapper::SafeDownCast(actor->GetMapper());
  mapper->GetInput()->GetPointData()->SetScalars(array);
  mapper->SetColorModeToDirectScalars();
  mapper->ScalarVisibilityOn();
  actor->ForceTranslucentOn();
}

vtkSmartPointer<vtkActor> make_tube(const std::vector<Vec3>& points, double radius_mm,
                                    const Rgb& color) {
  std::vector<int> line(points.size());
  for (std::size_t i = 0; i < line.size(); ++i) line[i] = int(i);
  vtkNew<vtkPolyData> poly;
  poly->SetPoints(formats::to_vtk(points));
  poly->SetLines(formats::to_vtk_cells(std::vector<std::vector<int>>{line}));
  vtkNew<vtkTubeFilter> tube;
  tube->SetInputData(poly);
  tube->SetRadius(radius_mm);
  tube->SetNumberOfSides(12);
  tube->CappingOn();
  tube->Update();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(tube->GetOutput());
  mapper->ScalarVisibilityOff();
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  shade(actor->GetProperty(), color);
  return actor;
}

std::vector<vtkSmartPointer<vtkActor>> make_balloon(const TriangleMesh& balloon,
                                                    const std::vector<Vec3>& guidewire) {
  constexpr double kWireRadius = 0.18;  // [mm], a wire of 0.014 inch
  constexpr double kTranslucent = 0.55;
  std::vector<vtkSmartPointer<vtkActor>> actors;
  const bool has_wire = guidewire.size() > 1;
  if (has_wire) actors.push_back(make_tube(guidewire, kWireRadius, colors::kGuidewire));
  if (!balloon.triangles.empty())
    actors.push_back(make_surface(balloon, {colors::kBalloon, has_wire ? kTranslucent : 1.0}));
  return actors;
}

vtkSmartPointer<vtkColorTransferFunction> make_pressure_colors(double high) {
  auto map = vtkSmartPointer<vtkColorTransferFunction>::New();
  map->SetColorSpaceToLab();
  map->AddRGBPoint(0.0, 0.88, 0.88, 0.88);
  map->AddRGBPoint(0.25 * high, 0.99, 0.83, 0.45);
  map->AddRGBPoint(0.5 * high, 0.99, 0.55, 0.24);
  map->AddRGBPoint(0.75 * high, 0.84, 0.18, 0.12);
  map->AddRGBPoint(high, 0.42, 0.0, 0.05);
  return map;
}

vtkSmartPointer<vtkColorTransferFunction> make_thickness_colors(double low, double high) {
  auto map = vtkSmartPointer<vtkColorTransferFunction>::New();
  const auto at = [&](double share) { return low + share * (high - low); };
  map->AddRGBPoint(at(0.0), 0.27, 0.0, 0.33);
  map->AddRGBPoint(at(0.25), 0.23, 0.32, 0.55);
  map->AddRGBPoint(at(0.5), 0.13, 0.57, 0.55);
  map->AddRGBPoint(at(0.75), 0.37, 0.79, 0.38);
  map->AddRGBPoint(at(1.0), 0.99, 0.91, 0.14);
  return map;
}

void show_edges(vtkActor* actor) {
  actor->GetProperty()->EdgeVisibilityOn();
  actor->GetProperty()->SetEdgeColor(unit_rgb(colors::kInk).data());
}

vtkSmartPointer<vtkTextActor> make_text(const std::string& text, int size, const Rgb& color) {
  auto actor = vtkSmartPointer<vtkTextActor>::New();
  actor->SetInput(text.c_str());
  actor->GetTextProperty()->SetFontFamilyToArial();
  actor->GetTextProperty()->SetFontSize(size);
  actor->GetTextProperty()->SetColor(unit_rgb(color).data());
  return actor;
}

std::vector<vtkSmartPointer<vtkProp>> add_color_bar(vtkRenderer* renderer,
                                                    vtkColorTransferFunction* map,
                                                    const std::string& title,
                                                    const ColorBarPlace& place, int scale,
                                                    const Rgb& text_color) {
  constexpr int kSteps = 128;
  const double low = map->GetRange()[0], high = map->GetRange()[1];
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> cells;
  vtkNew<vtkDoubleArray> values;
  for (int step = 0; step <= kSteps; ++step) {
    const double x = place.left + place.width * step / kSteps;
    points->InsertNextPoint(x, place.bottom, 0.0);
    points->InsertNextPoint(x, place.bottom + place.height, 0.0);
    for (int side = 0; side < 2; ++side)
      values->InsertNextValue(low + (high - low) * step / kSteps);
    if (step == kSteps) break;
    const vtkIdType corner = 2 * step;
    cells->InsertNextCell({corner, corner + 2, corner + 3, corner + 1});
  }
  vtkNew<vtkPolyData> strip;
  strip->SetPoints(points);
  strip->SetPolys(cells);
  strip->GetPointData()->SetScalars(values);
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(strip);
  mapper->SetLookupTable(map);
  mapper->UseLookupTableScalarRangeOn();
  vtkNew<vtkActor2D> actor;
  actor->SetMapper(mapper);
  std::vector<vtkSmartPointer<vtkProp>> parts{actor.Get()};

  const auto add_text = [&](const std::string& words, double x, double y) {
    const auto text = make_text(words, 14 * scale, text_color);
    text->GetTextProperty()->SetJustificationToCentered();
    text->SetPosition(x, y);
    parts.push_back(text);
  };
  const std::vector<double> round = round_ticks(low, high, 5);
  const double step = round[1] - round[0];
  const auto tick_text = [&](double tick) {  // an end between the steps needs a decimal more
    const int decimals = tick_decimals(step);
    const double rounded = std::round(tick * std::pow(10.0, decimals)) / std::pow(10.0, decimals);
    return formats::fixed_text(tick, decimals + (std::abs(rounded - tick) > 0.05 * step ? 1 : 0));
  };
  for (const double tick : bar_ticks(low, high))
    add_text(tick_text(tick), place.left + place.width * (tick - low) / (high - low),
             place.bottom - 17.0 * scale);
  add_text(title, place.left + 0.5 * place.width, place.bottom + place.height + 5.0 * scale);
  for (const auto& part : parts) renderer->AddViewProp(part);
  return parts;
}

ScaleBar::ScaleBar(vtkRenderer* renderer, int scale, const Rgb& color)
    : renderer_(renderer),
      scale_(scale),
      points_(vtkSmartPointer<vtkPoints>::New()),
      text_(make_text("", 14 * scale, color)) {
  points_->SetNumberOfPoints(4);
  for (vtkIdType i = 0; i < 4; ++i) points_->SetPoint(i, 0, 0, 0);
  renderer_->AddActor2D(make_overlay_line(points_, color, float(2 * scale)));
  renderer_->AddActor2D(text_);
}

void ScaleBar::update(double clear) {
  const int* size = renderer_->GetSize();
  if (size[0] <= 0 || size[1] <= 0) return;
  const double mm_per_pixel =
      2.0 * renderer_->GetActiveCamera()->GetParallelScale() / double(size[1]);
  const double length_mm = scale_length(0.25 * double(size[0]) * mm_per_pixel);
  const double length = length_mm / mm_per_pixel;
  const double left = 18.0 * scale_, bottom = clear + 18.0 * scale_, tick = 5.0 * scale_;
  points_->SetPoint(0, left, bottom + tick, 0);
  points_->SetPoint(1, left, bottom, 0);
  points_->SetPoint(2, left + length, bottom, 0);
  points_->SetPoint(3, left + length, bottom + tick, 0);
  points_->Modified();
  text_->SetInput((formats::number_text(length_mm) + " mm").c_str());
  text_->SetPosition(left + 4.0 * scale_, bottom + 5.0 * scale_);
}

void aim(vtkRenderer* renderer, const ViewFrame& frame, double picture_aspect) {
  vtkCamera* camera = renderer->GetActiveCamera();
  const double reach = 4.0 * std::max(frame.half_width_mm, frame.half_height_mm);
  const Vec3 eye = frame.focus - reach * frame.direction;
  camera->ParallelProjectionOn();
  camera->SetFocalPoint(frame.focus.x, frame.focus.y, frame.focus.z);
  camera->SetPosition(eye.x, eye.y, eye.z);
  camera->SetViewUp(frame.up.x, frame.up.y, frame.up.z);
  camera->SetParallelScale(half_height(frame, picture_aspect));
  renderer->ResetCameraClippingRange();
}

PicturePlace place_in_picture(const ViewFrame& frame, double picture_aspect, const Vec3& point) {
  const double height = 2.0 * half_height(frame, picture_aspect);
  const Vec3 d = point - frame.focus;
  return {0.5 + dot(d, frame.right()) / (height * picture_aspect), 0.5 + dot(d, frame.up) / height};
}

void add_mark(vtkRenderer* renderer, const PicturePlace& place, double radius_fraction,
              const std::string& label, int width, int height, int scale) {
  const auto text = make_text(label, 15 * scale, colors::kInk);
  text->GetTextProperty()->BoldOn();
  text->GetTextProperty()->SetBackgroundColor(1.0, 1.0, 1.0);
  text->GetTextProperty()->SetBackgroundOpacity(0.8);
  constexpr int kDpi = 72;  // VTK's for pictures that are not shown
  int box[4] = {0, 0, 0, 0};
  vtkTextRenderer::GetInstance()->GetBoundingBox(text->GetTextProperty(), label, box, kDpi);
  const double x = place.x * width, y = place.y * height;
  const MarkLayout layout =
      lay_out_mark({x, y, radius_fraction * height, double(box[1] - box[0] + 1),
                    double(box[3] - box[2] + 1), 8.0 * scale, double(width), double(height)});
  constexpr int kSides = 72;
  vtkNew<vtkPoints> ring;
  for (int side = 0; side <= kSides; ++side) {
    const double angle = 2.0 * units::kPi * side / kSides;
    ring->InsertNextPoint(x + layout.radius * std::cos(angle), y + layout.radius * std::sin(angle),
                          0.0);
  }
  renderer->AddActor2D(make_overlay_line(ring, colors::kInk, float(2 * scale)));
  text->SetPosition(layout.label_left - box[0], layout.label_bottom - box[2]);
  renderer->AddActor2D(text);
}

vtkSmartPointer<vtkRenderer> make_axes(int scale, const Rgb& color) {
  vtkNew<vtkAxesActor> axes;
  axes->AxisLabelsOff();
  auto renderer = vtkSmartPointer<vtkRenderer>::New();
  renderer->SetLayer(1);
  renderer->InteractiveOff();
  renderer->AddActor(axes);
  for (const char* letter : {"L", "P", "H"}) {
    const auto text = make_text(letter, 13 * scale, color);
    text->GetTextProperty()->BoldOn();
    text->GetTextProperty()->SetJustificationToCentered();
    text->GetTextProperty()->SetVerticalJustificationToCentered();
    text->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
    renderer->AddActor2D(text);
  }
  return renderer;
}

void turn_axes(vtkRenderer* axes, vtkRenderer* scene, int width, int height) {
  constexpr double kSide = 130.0;       // [pixel]
  constexpr double kHalfHeight = 1.45;  // an axis is 1 long
  axes->SetViewport(1.0 - std::min(1.0, kSide / width), 0.0, 1.0, std::min(1.0, kSide / height));
  vtkCamera* camera = axes->GetActiveCamera();
  vtkCamera* from = scene->GetActiveCamera();
  double direction[3], right[3], up[3];
  from->GetDirectionOfProjection(direction);
  vtkMath::Cross(direction, from->GetViewUp(), right);
  vtkMath::Normalize(right);
  vtkMath::Cross(right, direction, up);
  camera->ParallelProjectionOn();
  camera->SetFocalPoint(0, 0, 0);
  camera->SetPosition(-5 * direction[0], -5 * direction[1], -5 * direction[2]);
  camera->SetViewUp(from->GetViewUp());
  camera->SetParallelScale(kHalfHeight);
  axes->ResetCameraClippingRange();
  const auto letters =
      place_axis_letters({{{right[0], up[0]}, {right[1], up[1]}, {right[2], up[2]}}});
  vtkActor2DCollection* texts = axes->GetActors2D();
  for (int axis = 0; axis < texts->GetNumberOfItems(); ++axis) {
    const auto& [x, y] = letters.at(std::size_t(axis));
    vtkActor2D::SafeDownCast(texts->GetItemAsObject(axis))
        ->SetPosition(0.5 + 0.5 * x / kHalfHeight, 0.5 + 0.5 * y / kHalfHeight);
  }
}

}  // namespace angio::viewer::detail
