#pragma once

#include <vtkActor.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>

#include <memory>
#include <vector>

#include "viewer/detail/case_data.hpp"
#include "viewer/detail/scene.hpp"

namespace angio::viewer::detail {

enum class ScenePart { scan, lumen, centerline, pressure };

/// What the desktop viewer shows, in a window or in a screenshot.
class CaseScene {
 public:
  /// @param data   lives longer than the scene
  /// @param scale  size of texts and lines, as kSupersampling for a screenshot
  CaseScene(const CaseData& data, int scale);

  /// The scene, and the small axes over it. The window takes both.
  [[nodiscard]] std::vector<vtkRenderer*> layers() const;

  void show_frame(std::size_t index);
  void toggle(ScenePart part);
  void look_at_lesion(double aspect);
  void look_at_tree(double aspect);
  /// To be called before every rendering.
  void update_overlays();

  [[nodiscard]] std::size_t frame() const { return frame_; }

 private:
  void add_scan(const Vec3& center);
  void add_texts(int scale);
  /// Where the balloon works; the middle of the lumen before the simulation has run.
  [[nodiscard]] Vec3 point_of_interest() const;
  void color_wall();
  void add_pressure_colors();

  const CaseData& data_;
  int scale_;
  vtkSmartPointer<vtkRenderer> renderer_;
  vtkSmartPointer<vtkRenderer> axes_;
  std::unique_ptr<ScaleBar> scale_bar_;
  std::vector<vtkSmartPointer<vtkActor>> slices_;
  std::vector<vtkSmartPointer<vtkActor>> lines_;
  vtkSmartPointer<vtkActor> lumen_, wall_;
  std::vector<vtkSmartPointer<vtkActor>> balloon_;  ///< and its guidewire
  vtkSmartPointer<vtkTextActor> status_;
  vtkSmartPointer<vtkColorTransferFunction> pressure_colors_;  ///< up to the highest at peak
  std::vector<vtkSmartPointer<vtkProp>> color_bar_;
  TriangleMesh first_wall_;   ///< the wall before it moves
  TriangleMesh still_lumen_;  ///< the lumen without that wall
  std::vector<double> contact_pressure_kpa_;
  bool shows_pressure_ = false;
  std::size_t frame_ = 0;
};

}  // namespace angio::viewer::detail
