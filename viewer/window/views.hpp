#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>

#include "viewer/detail/case_data.hpp"
#include "viewer/window/diameter_curve.hpp"
#include "viewer/window/frame_store.hpp"
#include "viewer/window/image_panel.hpp"
#include "viewer/window/scan_image.hpp"
#include "viewer/window/scene_view.hpp"
#include "viewer/window/treated_line.hpp"

namespace angio::viewer::window {

enum class SliceAxis { axial, coronal, sagittal };

/// All that is drawn of a case: scene, slice, section and curve, linked by one frame and one
/// cursor on the treated line.
class Views {
 public:
  /// @throws InputError (66) as read_case
  explicit Views(const std::filesystem::path& case_folder);

  [[nodiscard]] const detail::CaseData& data() const { return data_; }
  [[nodiscard]] const TreatedLine& line() const { return line_; }
  [[nodiscard]] const std::vector<Field>& fields() const { return fields_; }
  [[nodiscard]] bool has_scan() const { return scan_.has_value(); }
  SceneView& scene() { return *scene_; }
  ImagePanel& slice() { return *slice_; }
  ImagePanel& section() { return *section_; }
  DiameterCurve& curve() { return *curve_; }

  /// Reads the list of frames and the time series again. @return false where that is not enough:
  /// the first frames, another run's, or a run that is done; then make new views
  [[nodiscard]] bool reload_frames();

  void show_frame(std::size_t index);
  [[nodiscard]] std::size_t frame() const { return frame_; }
  [[nodiscard]] double time_s() const;
  [[nodiscard]] std::size_t frame_at(double time_s) const;  ///< the last that is not later
  /// A column of the time series at the frame shown; NaN where unknown.
  [[nodiscard]] double number(const char* column) const;
  [[nodiscard]] std::string phase() const;
  [[nodiscard]] double highest_pressure_atm() const;

  /// The wall is opaque while it is coloured, and faint while the balloon is.
  /// @param place  in fields(); beyond: plain
  void color_by(std::optional<std::size_t> place);
  [[nodiscard]] std::optional<std::size_t> field() const { return field_; }

  void walk_to(double abscissa_mm);
  [[nodiscard]] double abscissa_mm() const { return abscissa_mm_; }
  void walk_to_point(const Vec3& point);
  void set_slice_axis(SliceAxis axis);
  [[nodiscard]] SliceAxis slice_axis() const { return axis_; }
  void center_panels();          ///< slice and section on the cursor, as large as at the start
  void scroll_slice(int steps);  ///< by a voxel's shortest edge each
  void set_slab(bool is_slab);
  [[nodiscard]] bool is_slab() const { return is_slab_; }
  void change_grey(double window_by, double level_by);  ///< in hundredths of the first window
  void reset_grey();

 private:
  void add_diameters();
  void show_slice(bool is_new);
  void show_section();
  void show_contours();
  [[nodiscard]] std::string grey_words() const;

  std::filesystem::path folder_, simulation_;
  detail::CaseData data_;
  TreatedLine line_;
  FrameStore store_;
  std::optional<ScanImage> scan_;
  std::unique_ptr<SceneView> scene_;
  std::unique_ptr<ImagePanel> slice_, section_;
  std::unique_ptr<DiameterCurve> curve_;
  std::vector<Field> fields_;
  std::optional<std::size_t> field_;
  std::optional<double> plain_wall_opacity_;  ///< to come back to
  std::size_t frame_ = 0;
  double abscissa_mm_ = 0.0;
  Vec3 slice_point_;
  SliceAxis axis_ = SliceAxis::axial;
  bool is_slab_ = false;
};

}  // namespace angio::viewer::window
