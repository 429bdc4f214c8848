#include "viewer/window/diameter_curve.hpp"

#include <vtkAxis.h>
#include <vtkContextActor.h>
#include <vtkContextScene.h>
#include <vtkDoubleArray.h>
#include <vtkPen.h>
#include <vtkPlot.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "viewer/window/colors.hpp"
#include "viewer/window/legend.hpp"

namespace angio::viewer::window {
namespace {

void fill(vtkTable* table, const std::string& name, const std::vector<double>& x,
          const std::vector<double>& y) {
  vtkNew<vtkDoubleArray> column_x, column_y;
  column_x->SetName("x");
  column_y->SetName(name.c_str());
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) {
    column_x->InsertNextValue(x[i]);
    column_y->InsertNextValue(y[i]);
  }
  table->AddColumn(column_x);
  table->AddColumn(column_y);
}

enum class Stroke { solid, dashed };

void add_line(vtkChartXY* chart, vtkTable* table, const detail::Rgb& color, float width,
              Stroke stroke = Stroke::solid) {
  vtkPlot* plot = chart->AddPlot(vtkChart::LINE);
  plot->SetInputData(table, 0, 1);
  plot->SetColor(color[0], color[1], color[2], 255);
  plot->SetWidth(width);
  if (stroke == Stroke::dashed) plot->GetPen()->SetLineType(vtkPen::DASH_LINE);
}

void style(vtkTextProperty* text, int size) {
  text->SetColor(0.87, 0.89, 0.91);
  text->SetFontSize(size);
  text->SetFontFamilyToArial();
  text->BoldOff();
}

void set_up(vtkAxis* axis, const char* title, double low, double high) {
  axis->SetTitle(title);
  axis->SetBehavior(vtkAxis::FIXED);
  axis->SetRange(low, high);
  axis->GetPen()->SetColor(150, 156, 168);
  axis->GetGridPen()->SetColor(58, 64, 76);
  style(axis->GetTitleProperties(), 12);
  style(axis->GetLabelProperties(), 11);
}

double highest(const TreatedLine& line) {
  double top = std::isfinite(line.reference_mm) ? line.reference_mm : 0.0;
  for (const auto* diameters : {&line.before, &line.peak, &line.after})
    for (const double diameter : *diameters)
      if (std::isfinite(diameter)) top = std::max(top, diameter);
  return top > 0.0 ? top : 1.0;
}

}  // namespace

DiameterCurve::DiameterCurve(const TreatedLine& line)
    : renderer_(vtkSmartPointer<vtkRenderer>::New()), top_mm_(1.25 * highest(line)) {
  renderer_->SetBackground(0.075, 0.085, 0.105);
  const std::vector<double>& x = line.abscissa_mm;
  const double low = x.empty() ? 0.0 : x.front(), high = x.size() < 2 ? low + 1.0 : x.back();
  std::vector<std::pair<std::string, detail::Rgb>> legend;
  const auto add = [&](const std::string& name, const std::vector<double>& along,
                       const std::vector<double>& y, const detail::Rgb& color, float width,
                       Stroke stroke) {
    if (y.empty()) return;
    vtkNew<vtkTable> table;
    fill(table, name, along, y);
    add_line(chart_, table, color, width, stroke);
    if (!name.empty()) legend.emplace_back(name, color);
  };
  if (std::isfinite(line.reference_mm))
    add("reference", {low, high}, {line.reference_mm, line.reference_mm}, colors::kFaintInk, 1.5f,
        Stroke::dashed);
  add("before", x, line.before, colors::kBefore, 2.0f, Stroke::solid);
  add("at peak", x, line.peak, colors::kNow, 2.0f, Stroke::solid);
  add("after", x, line.after, colors::kAfter, 2.0f, Stroke::solid);
  fill(cursor_, "cursor", {low, low}, {0.0, top_mm_});
  add_line(chart_, cursor_, colors::kCursor, 2.0f);
  for (const double edge : {line.proximal_mm, line.distal_mm})
    if (std::isfinite(edge))
      add("", {edge, edge}, {0.0, top_mm_}, colors::kFaintInk, 1.0f, Stroke::dashed);

  set_up(chart_->GetAxis(vtkAxis::BOTTOM), "along the line [mm]", low, high);
  set_up(chart_->GetAxis(vtkAxis::LEFT), "lumen diameter [mm]", 0.0, top_mm_);
  chart_->SetAutoSize(true);
  vtkNew<vtkContextActor> actor;
  actor->GetScene()->AddItem(chart_);
  renderer_->AddActor(actor);
  actor->GetScene()->SetRenderer(renderer_);
  add_legend(renderer_, 0.13, 0.985, legend);
}

void DiameterCurve::set_cursor(double abscissa_mm) {
  cursor_->SetValue(0, 0, abscissa_mm);
  cursor_->SetValue(1, 0, abscissa_mm);
  cursor_->GetColumn(0)->Modified();
  cursor_->Modified();
}

std::optional<double> DiameterCurve::abscissa_at(int x, const PixelBox& box) const {
  const vtkAxis* axis = const_cast<vtkChartXY*>(chart_.Get())->GetAxis(vtkAxis::BOTTOM);
  auto* bottom = const_cast<vtkAxis*>(axis);
  const double first = bottom->GetPoint1()[0], last = bottom->GetPoint2()[0];
  if (last <= first) return std::nullopt;
  const double share = std::clamp((x - box.left - first) / (last - first), 0.0, 1.0);
  return bottom->GetMinimum() + share * (bottom->GetMaximum() - bottom->GetMinimum());
}

}  // namespace angio::viewer::window
