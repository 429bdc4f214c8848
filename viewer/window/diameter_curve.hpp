#pragma once

#include <vtkChartXY.h>
#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTable.h>

#include <optional>

#include "viewer/window/layout.hpp"
#include "viewer/window/treated_line.hpp"

namespace angio::viewer::window {

/// The lumen's diameter along the treated line before, at peak and after, with the lesion's edges,
/// the reference and a cursor.
class DiameterCurve {
 public:
  explicit DiameterCurve(const TreatedLine& line);

  [[nodiscard]] vtkRenderer* renderer() const { return renderer_; }
  void set_cursor(double abscissa_mm);
  /// What lies under a pixel, kept to the curve's ends; nothing before the chart was first drawn.
  /// @param x    of the window
  /// @param box  where the chart lies in it
  [[nodiscard]] std::optional<double> abscissa_at(int x, const PixelBox& box) const;

 private:
  vtkSmartPointer<vtkRenderer> renderer_;
  vtkNew<vtkChartXY> chart_;
  vtkNew<vtkTable> cursor_;
  double top_mm_ = 1.0;
};

}  // namespace angio::viewer::window
