#include "viewer/window/pressure_dial.hpp"

#include <vtkBrush.h>
#include <vtkContext2D.h>
#include <vtkObjectFactory.h>
#include <vtkPen.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "formats/text.hpp"
#include "viewer/window/colors.hpp"

namespace angio::viewer::window {
namespace {

constexpr double kFirstDegrees = 205.0, kLastDegrees = -25.0;  // as a manometer's scale

void use_pen(vtkContext2D* painter, const detail::Rgb& color, float width) {
  painter->GetPen()->SetColor(color[0], color[1], color[2]);
  painter->GetPen()->SetLineType(vtkPen::SOLID_LINE);
  painter->GetPen()->SetWidth(width);
}

void write(vtkContext2D* painter, double x, double y, int size, const std::string& words) {
  vtkTextProperty* text = painter->GetTextProp();
  text->SetFontFamilyToArial();
  text->SetFontSize(size);
  text->SetColor(0.87, 0.89, 0.91);
  text->SetJustificationToCentered();
  text->SetVerticalJustificationToCentered();
  painter->DrawString(float(x), float(y), words.c_str());
}

}  // namespace

vtkStandardNewMacro(PressureDial);

void PressureDial::place(double x, double y, double radius) {
  x_ = x;
  y_ = y;
  radius_ = radius;
}

void PressureDial::set_highest(double highest_atm) {
  end_atm_ = 2.0 * std::max(1.0, std::ceil(0.55 * highest_atm));
}

void PressureDial::show(double pressure_atm, const std::string& phase) {
  pressure_atm_ = pressure_atm;
  phase_ = phase;
}

double PressureDial::angle_at(double pressure_atm) const {
  const double share = std::clamp(pressure_atm / end_atm_, 0.0, 1.0);
  return kFirstDegrees + share * (kLastDegrees - kFirstDegrees);
}

bool PressureDial::Paint(vtkContext2D* painter) {
  if (radius_ < 10.0) return true;
  const auto at = [&](double degrees, double distance) {
    const double angle = degrees * units::kPi / 180.0;
    return std::pair(float(x_ + distance * std::cos(angle)),
                     float(y_ + distance * std::sin(angle)));
  };
  painter->GetBrush()->SetOpacity(0);
  use_pen(painter, colors::kFaintInk, 2.0f);
  painter->DrawArc(float(x_), float(y_), float(radius_), float(kLastDegrees), float(kFirstDegrees));
  const double tick_atm = end_atm_ > 12.0 ? 4.0 : 2.0;
  for (double tick = 0.0; tick <= end_atm_ + 1e-9; tick += tick_atm) {
    const auto [x0, y0] = at(angle_at(tick), 0.88 * radius_);
    const auto [x1, y1] = at(angle_at(tick), radius_);
    painter->DrawLine(x0, y0, x1, y1);
    const auto [x2, y2] = at(angle_at(tick), 0.7 * radius_);
    write(painter, x2, y2, 11, formats::fixed_text(tick, 0));
  }
  const bool is_known = std::isfinite(pressure_atm_);
  if (is_known) {
    use_pen(painter, colors::kNow, 3.0f);
    const auto [x0, y0] = at(angle_at(pressure_atm_), -0.12 * radius_);
    const auto [x1, y1] = at(angle_at(pressure_atm_), 0.84 * radius_);
    painter->DrawLine(x0, y0, x1, y1);
  }
  write(painter, x_, y_ - 0.62 * radius_, 15,
        is_known ? formats::fixed_text(pressure_atm_, 2) + " atm" : "-- atm");
  write(painter, x_, y_ - 0.9 * radius_, 12, phase_);
  return true;
}

}  // namespace angio::viewer::window
