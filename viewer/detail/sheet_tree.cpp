#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/centerline_trees.hpp"
#include "formats/text.hpp"
#include "viewer/detail/pictures_3d.hpp"
#include "viewer/detail/rendering.hpp"
#include "viewer/detail/scene.hpp"
#include "viewer/detail/sheet_pictures.hpp"

namespace angio::viewer::detail {
namespace {

constexpr Rgb kInlet{20, 110, 60};
constexpr Rgb kOutlet{30, 60, 150};
constexpr Rgb kPaper{255, 255, 255};
constexpr Rgb kLine{25, 120, 70};

/// A name at a place of the picture, with what marks the place.
struct Label {
  Spot at;
  std::string text;
  Rgb color;
  double mark_radius = 4.0;  ///< [pixel]
  bool is_ring = false;
};

/// Puts names beside their places so that none covers another name or a mark.
class Labels {
 public:
  explicit Labels(Canvas& canvas) : canvas_(canvas) {}

  void mark(const Label& label) {
    if (label.is_ring) {
      canvas_.draw_circle(label.at, label.mark_radius, label.color, 2);
    } else {
      canvas_.draw_circle(label.at, label.mark_radius, label.color, -1);
      taken_.push_back({label.at.x - 4.0, label.at.y - 4.0, 8.0, 8.0});
    }
  }
  /// @return whether there was room
  bool name(const Label& label) {
    constexpr int kDirections = 16;
    const double outward =
        std::atan2(label.at.y - 0.5 * canvas_.height(), label.at.x - 0.5 * canvas_.width());
    for (double reach = label.mark_radius + 7.0; reach < 130.0; reach *= 1.35)
      for (int step = 0; step < kDirections; ++step) {
        // Outwards first, then further and further to both sides.
        const int aside = (step + 1) / 2;
        const double turn = (step % 2 == 0 ? 1.0 : -1.0) * aside * 6.2832 / kDirections;
        const Box box = box_at(label, reach, outward + turn);
        if (!is_free(box)) continue;
        write(label, box, reach, outward + turn);
        return true;
      }
    return false;
  }

 private:
  static Box box_at(const Label& label, double reach, double angle) {
    const Spot tip{label.at.x + reach * std::cos(angle), label.at.y + reach * std::sin(angle)};
    Box box = Canvas::text_box(label.text, {0.0, 0.0}, kSheetLetters);
    box.x = std::cos(angle) >= 0.0 ? tip.x : tip.x - box.width;
    box.y = tip.y - 0.5 * box.height;
    return box;
  }
  [[nodiscard]] bool is_free(const Box& box) const {
    constexpr double kTitleStrip = 26.0;
    if (box.x < 2.0 || box.y < kTitleStrip || box.x + box.width > canvas_.width() - 2.0 ||
        box.y + box.height > canvas_.height() - 2.0)
      return false;
    return std::none_of(taken_.begin(), taken_.end(),
                        [&](const Box& other) { return box.overlaps(other); });
  }
  void write(const Label& label, const Box& box, double reach, double angle) {
    const auto along = [&](double length) {
      return Spot{label.at.x + length * std::cos(angle), label.at.y + length * std::sin(angle)};
    };
    canvas_.draw_line({along(label.mark_radius), along(reach)}, label.color, 1);
    canvas_.fill(box, kPaper);
    canvas_.write(label.text, {box.x + 2.0, box.y + kSheetLetters + 2.0}, kSheetLetters,
                  label.color);
    taken_.push_back(box);
  }

  Canvas& canvas_;
  std::vector<Box> taken_;
};

/// Where a point of the scene falls on the picture.
struct Projector {
  ViewFrame frame;
  int width = 1, height = 1;
  [[nodiscard]] Spot operator()(const Vec3& point) const {
    const PicturePlace place = place_in_picture(frame, double(width) / height, point);
    return {place.x * width, (1.0 - place.y) * height};
  }
  [[nodiscard]] double pixels_per_mm() const {
    return height / (2.0 * std::max(frame.half_height_mm, frame.half_width_mm * height / width));
  }
};

/// In the order in which they get their room: inlets, lesions, the widest outlets.
std::vector<Label> make_labels(const SheetCase& sheet, const Projector& project) {
  std::vector<Label> labels;
  const auto& paths = sheet.content.tree.paths;
  if (paths.empty()) return labels;
  for (const CenterlineTree& tree : separate_trees(sheet.content.tree)) {
    const CenterlinePath& path = tree.paths.front();
    const double diameter = 2.0 * radius_at_end(path, PathEnd::inlet);
    labels.push_back({project(path.points.front()),
                      "inlet " + formats::fixed_text(diameter, 1) + " mm", kInlet, 7.0});
  }
  for (const SheetLesion& lesion : sheet.lesions)
    for (const CenterlinePath& path : paths) {
      if (path.id != lesion.path) continue;
      const CenterlineSample place = sample(path, lesion.abscissa_mm);
      const double ring = 2.0 * place.inscribed_radius * project.pixels_per_mm();
      labels.push_back({project(place.point),
                        lesion.name + ": " + formats::fixed_text(lesion.stenosis_percent, 0) +
                            " %DS, MLD " + formats::fixed_text(lesion.mld_mm, 2),
                        kSheetLesion, std::clamp(ring, 9.0, 40.0), true});
    }
  std::vector<Label> outlets;
  std::vector<double> radius;
  for (const CenterlinePath& path : paths) {
    radius.push_back(radius_at_end(path, PathEnd::outlet));
    outlets.push_back({project(path.points.back()),
                       std::to_string(path.id) + ": " + formats::fixed_text(2.0 * radius.back(), 1),
                       kOutlet});
  }
  std::vector<std::size_t> order(outlets.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return radius[a] > radius[b]; });
  for (const std::size_t i : order) labels.push_back(outlets[i]);
  return labels;
}

Picture render_tree(const SheetCase& sheet, const Projector& project) {
  const auto renderer = vtkSmartPointer<vtkRenderer>::New();
  renderer->SetBackground(1.0, 1.0, 1.0);
  const auto& content = sheet.content;
  if (!content.lumen.triangles.empty())
    renderer->AddActor(make_surface(content.lumen, {colors::kLumen, 0.22}));
  const double pixel_mm = 1.0 / project.pixels_per_mm();
  for (const CenterlinePath& path : content.tree.paths) {
    const bool is_treated = path.id == content.lesion_path;
    renderer->AddActor(make_tube(path.points, (is_treated ? 1.7 : 1.1) * pixel_mm,
                                 is_treated ? colors::kBalloon : kLine));
  }
  aim(renderer, project.frame, double(project.width) / project.height);
  ScaleBar bar(renderer, kSupersampling, colors::kInk);
  const auto axes = make_axes(kSupersampling, colors::kInk);
  turn_axes(axes, renderer, project.width, project.height);
  return render_offscreen({renderer, axes}, project.width, project.height, [&] { bar.update(); });
}

TriangleMesh points_of(const CenterlineTree& tree) {
  TriangleMesh cloud;
  for (const CenterlinePath& path : tree.paths)
    cloud.vertices.insert(cloud.vertices.end(), path.points.begin(), path.points.end());
  return cloud;
}

}  // namespace

std::vector<Picture> draw_sides_of_surface(const TriangleMesh& lumen, int pixels) {
  std::vector<Picture> pictures;
  if (lumen.triangles.empty()) return pictures;
  struct Side {
    const char* title;
    Vec3 direction, up;
  };
  // As a radiologist looks: axial from the feet, coronal from the front, sagittal from the left.
  const Side sides[3] = {{"along z, x to the right, y down", {0, 0, 1}, {0, -1, 0}},
                         {"along y, x to the right, z up", {0, 1, 0}, {0, 0, 1}},
                         {"along -x, y to the right, z up", {-1, 0, 0}, {0, 0, 1}}};
  const Bounds around = bounds(lumen);
  double half = 1e-3;
  for (const Vec3& vertex : lumen.vertices)
    for (int axis = 0; axis < 3; ++axis)
      half = std::max(half, std::abs(vertex[axis] - around.center[axis]));
  for (const Side& side : sides) {
    const auto renderer = vtkSmartPointer<vtkRenderer>::New();
    renderer->SetBackground(1.0, 1.0, 1.0);
    renderer->AddActor(make_surface(lumen, {colors::kLumen, 1.0}));
    aim(renderer, {around.center, side.direction, side.up, 1.12 * half, 1.12 * half}, 1.0);
    ScaleBar bar(renderer, kSupersampling, colors::kInk);
    Canvas canvas(render_offscreen({renderer}, pixels, pixels, [&] { bar.update(); }));
    canvas.write(side.title, kHeading, kSheetLetters, kSheetInk);
    pictures.push_back(canvas.picture());
  }
  return pictures;
}

Picture draw_named_tree(const SheetCase& sheet, int width, int height) {
  constexpr double kRoomForNames = 1.16;
  const auto& content = sheet.content;
  Projector project{
      content.lumen.vertices.empty() ? frame_tree(points_of(content.tree)) : tree_frame(content),
      width, height};
  project.frame.half_width_mm *= kRoomForNames;
  project.frame.half_height_mm *= kRoomForNames;
  Canvas canvas(render_tree(sheet, project));
  Labels labels(canvas);
  const std::vector<Label> wanted = make_labels(sheet, project);
  for (const Label& label : wanted) labels.mark(label);
  int without_room = 0;
  for (const Label& label : wanted)
    if (!labels.name(label)) ++without_room;
  std::string title = "lines in the lumen; outlets: line, diameter [mm]; blue: the line below";
  if (content.tree.paths.empty()) title = "no lines";
  if (without_room > 0) title += "; " + std::to_string(without_room) + " names found no room";
  canvas.write(title, kHeading, kSheetLetters, kSheetInk);
  return canvas.picture();
}

}  // namespace angio::viewer::detail
