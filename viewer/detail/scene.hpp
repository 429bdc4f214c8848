#pragma once

#include <vtkActor.h>
#include <vtkActor2D.h>
#include <vtkCellArray.h>
#include <vtkColorTransferFunction.h>
#include <vtkPoints.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>

#include <string>
#include <vector>

#include "core/triangle_mesh.hpp"
#include "viewer/detail/picture.hpp"
#include "viewer/detail/view_frame.hpp"

/// The parts of a 3D scene, for the report's pictures and for the window alike.
namespace angio::viewer::detail {

namespace colors {
inline constexpr Rgb kLumen{196, 78, 70};
inline constexpr Rgb kSurroundings{170, 160, 158};
inline constexpr Rgb kBalloon{45, 130, 225};
inline constexpr Rgb kGuidewire{38, 40, 46};
inline constexpr Rgb kCloth{214, 222, 232};
inline constexpr Rgb kCenterline{60, 190, 120};
inline constexpr Rgb kInk{40, 44, 52};
inline constexpr Rgb kLightInk{222, 226, 232};
}  // namespace colors

struct SurfaceStyle {
  Rgb color = colors::kLumen;
  double opacity = 1.0;  ///< (0, 1]
};

/// A surface with smooth shading.
vtkSmartPointer<vtkActor> make_surface(const TriangleMesh& mesh, const SurfaceStyle& style);

/// Colours a surface by a value per vertex.
void color_by(vtkActor* actor, const std::vector<double>& values, vtkColorTransferFunction* map);

/// The same, translucent where the value is low: what presses on the wall shows, and what lies
/// behind the rest of it.
void color_by_translucent(vtkActor* actor, const std::vector<double>& values,
                          vtkColorTransferFunction* map);

/// A line drawn as a tube.
vtkSmartPointer<vtkActor> make_tube(const std::vector<Vec3>& points, double radius_mm,
                                    const Rgb& color);

/// A balloon, translucent around its guidewire if there is one, and that.
std::vector<vtkSmartPointer<vtkActor>> make_balloon(const TriangleMesh& balloon,
                                                    const std::vector<Vec3>& guidewire);

/// From light grey at 0 over yellow and red to dark red at `high`.
vtkSmartPointer<vtkColorTransferFunction> make_pressure_colors(double high);

/// From purple where thin over green to yellow where thick.
vtkSmartPointer<vtkColorTransferFunction> make_thickness_colors(double low, double high);

/// Draws the triangles' edges.
void show_edges(vtkActor* actor);

/// A rectangle of the picture, from its lower left corner [drawn pixel].
struct ColorBarPlace {
  double left = 0.0;
  double bottom = 0.0;
  double width = 0.0;
  double height = 0.0;
};

/// The colours with their values below and the title above. @return its parts, added to the
/// renderer
/// @param title  with its unit
/// @param scale  text size, 1 on a screen, more in a picture that is shrunk afterwards
std::vector<vtkSmartPointer<vtkProp>> add_color_bar(vtkRenderer* renderer,
                                                    vtkColorTransferFunction* map,
                                                    const std::string& title,
                                                    const ColorBarPlace& place, int scale,
                                                    const Rgb& text_color);

vtkSmartPointer<vtkTextActor> make_text(const std::string& text, int size, const Rgb& color);

/// A bar at the lower left as long as a round number of millimetres.
class ScaleBar {
 public:
  ScaleBar(vtkRenderer* renderer, int scale, const Rgb& color);
  /// Fits the bar to the camera; to be called before every rendering. Exact in parallel
  /// projection, which is what the scenes use.
  /// @param clear  kept free at the bottom [pixel]
  void update(double clear = 0.0);

 private:
  vtkRenderer* renderer_;
  int scale_;
  vtkSmartPointer<vtkPoints> points_;
  vtkSmartPointer<vtkTextActor> text_;
};

/// Points the renderer's camera.
void aim(vtkRenderer* renderer, const ViewFrame& frame, double picture_aspect);

/// Where a point lies in the picture, as fractions from the left and from the bottom.
struct PicturePlace {
  double x = 0.0;
  double y = 0.0;
};
PicturePlace place_in_picture(const ViewFrame& frame, double picture_aspect, const Vec3& point);

/// A ring with a label, drawn over the scene, laid out as lay_out_mark says.
/// @param place  of its middle
/// @param radius_fraction  as wanted, of the picture's height
void add_mark(vtkRenderer* renderer, const PicturePlace& place, double radius_fraction,
              const std::string& label, int width, int height, int scale);

/// Small arrows L, P, H (the axes of LPS) at the lower right, turned as the camera is.
/// @param scale  text size, as above
vtkSmartPointer<vtkRenderer> make_axes(int scale, const Rgb& color);

/// Turns and places them, when the scene's camera moved or the window changed its size.
/// @param width, height  of the picture, in pixels of scale 1
void turn_axes(vtkRenderer* axes, vtkRenderer* scene, int width, int height);

}  // namespace angio::viewer::detail
