#pragma once

#include <vtkActor.h>
#include <vtkImageSlice.h>
#include <vtkImageSliceMapper.h>
#include <vtkPlane.h>
#include <vtkRegularPolygonSource.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>
#include <vtkTubeFilter.h>
#include <vtkVolume.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/triangle_mesh.hpp"
#include "viewer/detail/case_data.hpp"
#include "viewer/detail/scene.hpp"
#include "viewer/window/frame_store.hpp"
#include "viewer/window/scan_image.hpp"
#include "viewer/window/treated_line.hpp"
#include "viewer/window/two_sided_surface.hpp"

namespace angio::viewer::window {

enum class Layer { lumen, wall, balloon, wire, line, slice, projection };
inline constexpr std::size_t kLayerCount = 7;

/// The 3D scene: what is drawn, how, and from where it is seen. Parallel projection.
class SceneView {
 public:
  /// @param data, line  live longer
  /// @param scan        null: the case has none
  SceneView(const detail::CaseData& data, const TreatedLine& line, const ScanImage* scan);

  [[nodiscard]] vtkRenderer* renderer() const { return renderer_; }

  void show_frame(const FrameShapes& shapes);
  /// Null: plain colours. The bar of the colours stands at the lower left.
  void color_by(const std::optional<Field>& field, const FieldRange& range);

  [[nodiscard]] bool has(Layer layer) const;
  [[nodiscard]] bool is_visible(Layer layer) const;
  void set_visible(Layer layer, bool is_visible);
  [[nodiscard]] double opacity(Layer layer) const;
  void set_opacity(Layer layer, double opacity);  ///< [0, 1]
  /// The wireframe is that of the mesh; the shaded lumen is thinned where it is large.
  void set_drawn(Drawn drawn);
  /// Cuts lumen and wall open; null: whole again. The balloon stays whole.
  void set_clipping(vtkPlane* plane);

  /// A ring about the line, wider than the lumen near it is at any time.
  void set_cursor(double abscissa_mm);
  void set_words(const std::string& words);
  /// One slice of the scan through a point, at right angles to an axis of the voxels.
  /// @param axis  0, 1 or 2
  void set_slice(int axis, const Vec3& point);

  void look_at_lesion(double aspect);
  void look_at_tree(double aspect);
  /// Leaves the lowest pixels to others: bars are drawn above them.
  void keep_clear(int bottom_pixels);
  /// To be called before every drawing.
  void update_overlays() { scale_bar_->update(double(clear_)); }

  /// Half the size of what a balloon touches; of the lumen before the simulation.
  [[nodiscard]] double reach_mm() const;
  [[nodiscard]] Vec3 point_of_interest() const;
  /// Lumen and wall, to be met by a pick.
  [[nodiscard]] std::vector<vtkActor*> surfaces();

 private:
  void add_lines();
  void add_projection(const ScanImage& scan);
  [[nodiscard]] vtkProp* prop(Layer layer) const;
  TwoSidedSurface* surface(Layer layer);
  [[nodiscard]] const TwoSidedSurface* surface(Layer layer) const;
  void paint();

  const detail::CaseData& data_;
  const TreatedLine& line_;
  const ScanImage* scan_;
  vtkSmartPointer<vtkRenderer> renderer_;
  TriangleMesh first_wall_;                                ///< the wall before it moves
  TriangleMesh still_lumen_;                               ///< the lumen without that wall
  vtkSmartPointer<vtkPolyData> whole_lumen_, thin_lumen_;  ///< the mesh; what is shaded
  TwoSidedSurface lumen_, wall_, balloon_;
  FrameShapes shapes_;
  vtkNew<vtkTubeFilter> wire_tube_;
  vtkNew<vtkActor> wire_;
  vtkSmartPointer<vtkActor> lines_;
  vtkNew<vtkImageSliceMapper> slice_mapper_;
  vtkNew<vtkImageSlice> slice_;
  vtkSmartPointer<vtkVolume> projection_;
  std::array<double, kLayerCount> opacity_{};
  vtkNew<vtkRegularPolygonSource> cursor_ring_;
  vtkNew<vtkActor> cursor_;
  vtkSmartPointer<vtkTextActor> words_;
  std::unique_ptr<detail::ScaleBar> scale_bar_;
  int clear_ = 0;  ///< at the bottom [pixel]
  std::optional<Field> field_;
  FieldRange field_range_;
  vtkSmartPointer<vtkColorTransferFunction> colors_;
  std::vector<vtkSmartPointer<vtkProp>> color_bar_;
};

}  // namespace angio::viewer::window
