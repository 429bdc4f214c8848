#include "viewer/detail/chart_picture.hpp"

#include <vtkAxis.h>
#include <vtkChartLegend.h>
#include <vtkChartXY.h>
#include <vtkContextActor.h>
#include <vtkContextScene.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPen.h>
#include <vtkPlot.h>
#include <vtkPlotPoints.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "formats/text.hpp"
#include "viewer/detail/rendering.hpp"
#include "viewer/detail/scene.hpp"
#include "viewer/detail/sheet.hpp"

namespace angio::viewer::detail {
namespace {

constexpr std::array<Rgb, 4> kLineColors{
    {{29, 95, 191}, {201, 94, 0}, {31, 138, 76}, {138, 60, 160}}};
constexpr Rgb kFaint{150, 156, 168};

Rgb line_color(int color) { return kLineColors[std::size_t(std::clamp(color, 1, 4) - 1)]; }

/// The least and the greatest finite value.
struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void take(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

class ChartDrawing {
 public:
  ChartDrawing(const Chart& chart, int scale) : scale_(scale * kSupersampling) {
    measure(chart);
    for (const ChartBand& band : chart.bands)
      if (band.first > x_.low) add({{band.first, band.first}, {y_.low, y_.high}}, kFaint, 0.7);
    for (const ChartLevel& level : chart.levels)
      add({{x_.low, x_.high}, {level.y, level.y}, level.label, true}, kFaint, 1.2);
    for (const ChartSeries& series : chart.series)
      add({series.x, series.y, series.label, series.dashed}, line_color(series.color), 2.0);
    for (const ChartMark& mark : chart.marks) add_mark(mark);
    set_up(chart);
  }

  Picture render(int width, int height) {
    const auto renderer = make_stage();
    vtkNew<vtkContextActor> actor;
    actor->GetScene()->AddItem(chart_);
    renderer->AddActor(actor);
    actor->GetScene()->SetRenderer(renderer);
    return render_offscreen({renderer}, width, height);
  }

 private:
  struct Line {
    std::vector<double> x, y;
    std::string label = {};
    bool is_dashed = false;
  };

  void measure(const Chart& chart) {
    for (const ChartSeries& series : chart.series) {
      for (const double value : series.x) x_.take(value);
      for (const double value : series.y) y_.take(value);
    }
    for (const ChartLevel& level : chart.levels) y_.take(level.y);
    if (chart.y_from_zero) y_.take(0.0);
    const auto ticks = round_ticks(y_.low, y_.high, 5);
    y_ = {ticks.front(), ticks.back()};
  }

  vtkPlot* add(const Line& line, const Rgb& color, double width, int kind = vtkChart::LINE) {
    vtkNew<vtkDoubleArray> x, y;
    x->SetName("x");
    y->SetName(line.label.c_str());
    for (std::size_t i = 0; i < std::min(line.x.size(), line.y.size()); ++i) {
      x->InsertNextValue(line.x[i]);
      y->InsertNextValue(line.y[i]);
    }
    vtkNew<vtkTable> table;
    table->AddColumn(x);
    table->AddColumn(y);
    vtkPlot* plot = chart_->AddPlot(kind);
    plot->SetInputData(table, 0, 1);
    plot->SetColor(color[0], color[1], color[2], 255);
    plot->SetWidth(float(width * scale_));
    if (line.is_dashed) plot->GetPen()->SetLineType(vtkPen::DASH_LINE);
    if (line.label.empty()) plot->LegendVisibilityOff();
    return plot;
  }

  void add_mark(const ChartMark& mark) {
    auto* points = vtkPlotPoints::SafeDownCast(
        add({{mark.x}, {mark.y}, mark.label}, line_color(mark.color), 1.0, vtkChart::POINTS));
    points->SetMarkerStyle(vtkPlotPoints::CIRCLE);
    points->SetMarkerSize(float(7.0 * scale_));
  }

  void style(vtkTextProperty* text, int size) const {
    text->SetColor(colors::kInk[0] / 255.0, colors::kInk[1] / 255.0, colors::kInk[2] / 255.0);
    text->SetFontFamilyToArial();
    text->SetFontSize(size * scale_);
    text->BoldOff();
  }

  /// VTK would choose many more.
  static void set_ticks(vtkAxis* axis, const Extent& range) {
    constexpr int kTicks = 7;
    const std::vector<double> ticks = round_ticks(range.low, range.high, kTicks);
    vtkNew<vtkDoubleArray> places;
    vtkNew<vtkStringArray> labels;
    for (const double tick : ticks) {
      if (tick < range.low - 1e-9 || tick > range.high + 1e-9) continue;
      places->InsertNextValue(tick);
      labels->InsertNextValue(formats::fixed_text(tick, tick_decimals(ticks[1] - ticks[0])));
    }
    axis->SetCustomTickPositions(places, labels);
  }

  void set_up_axis(int which, const std::string& title, const Extent& range) {
    vtkAxis* axis = chart_->GetAxis(which);
    axis->SetTitle(title);
    axis->SetBehavior(vtkAxis::FIXED);
    axis->SetRange(range.low, range.high);
    axis->GetPen()->SetWidth(float(scale_));
    axis->GetGridPen()->SetColor(228, 231, 236);
    axis->GetGridPen()->SetWidth(float(scale_));
    axis->SetTickLength(float(4 * scale_));
    axis->SetLabelOffset(float(4 * scale_));
    axis->SetMargins(9 * scale_, 9 * scale_);
    set_ticks(axis, range);
    style(axis->GetTitleProperties(), 13);
    style(axis->GetLabelProperties(), 12);
  }

  void set_up(const Chart& chart) {
    chart_->SetAutoSize(true);
    chart_->SetTitle(chart.title);
    style(chart_->GetTitleProperties(), 15);
    set_up_axis(vtkAxis::BOTTOM, chart.x_label, x_);
    set_up_axis(vtkAxis::LEFT, chart.y_label, y_);
    chart_->SetShowLegend(true);
    vtkChartLegend* legend = chart_->GetLegend();
    style(legend->GetLabelProperties(), 11);
    legend->SetLabelSize(11 * scale_);
    legend->SetSymbolWidth(22 * scale_);
    legend->SetInline(false);
    legend->SetHorizontalAlignment(vtkChartLegend::RIGHT);
    legend->SetVerticalAlignment(vtkChartLegend::CENTER);
  }

  int scale_;
  Extent x_, y_;
  vtkNew<vtkChartXY> chart_;
};

}  // namespace

Picture chart_picture(const Chart& chart, int scale) {
  return ChartDrawing(chart, scale).render(chart.width * scale, chart.height * scale);
}

}  // namespace angio::viewer::detail
