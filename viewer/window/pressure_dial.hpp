#pragma once

#include <vtkAbstractContextItem.h>

#include <string>

namespace angio::viewer::window {

/// A round gauge with a needle and the number below it, as on the inflation device.
class PressureDial : public vtkAbstractContextItem {
 public:
  static PressureDial* New();
  vtkTypeMacro(PressureDial, vtkAbstractContextItem);

  /// @param x, y, radius  its middle [pixel]
  void place(double x, double y, double radius);
  /// @param highest_atm  of the case, >= 0; the scale ends at an even number a tenth above it
  void set_highest(double highest_atm);
  /// @param phase  "inflate"; may be empty
  void show(double pressure_atm, const std::string& phase);  ///< NaN: not known
  bool Paint(vtkContext2D* painter) override;

 private:
  [[nodiscard]] double angle_at(double pressure_atm) const;  ///< [degrees], counter-clockwise

  double x_ = 0.0, y_ = 0.0, radius_ = 1.0;
  double end_atm_ = 2.0, pressure_atm_ = 0.0;
  std::string phase_;
};

}  // namespace angio::viewer::window
