#include "viewer/detail/pictures_3d.hpp"

#include <algorithm>
#include <cmath>

#include "formats/text.hpp"
#include "viewer/detail/rendering.hpp"
#include "viewer/detail/scene.hpp"
#include "viewer/detail/sheet.hpp"

namespace angio::viewer::detail {
namespace {

constexpr int kCloseUpWidth = 900;  // [pixel]
constexpr int kTreeLongSide = 820;  // [pixel]

/// All moments' walls as one cloud, so that one frame holds them all.
TriangleMesh all_walls(const ReportContent& content) {
  TriangleMesh cloud;
  for (const Moment& moment : content.moments) {
    cloud.vertices.insert(cloud.vertices.end(), moment.wall.vertices.begin(),
                          moment.wall.vertices.end());
    cloud.vertices.insert(cloud.vertices.end(), moment.balloon.vertices.begin(),
                          moment.balloon.vertices.end());
  }
  return cloud;
}

/// What every close-up shares.
struct CloseUp {
  ViewFrame frame;
  TriangleMesh context;  ///< the lumen around the wall
  int height = 0;        ///< of the picture [pixel]

  explicit CloseUp(const ReportContent& content) {
    const TriangleMesh walls = all_walls(content);
    const Bounds around = bounds(walls);
    const CenterlinePath* path = lesion_path(content);
    context = surroundings(content.lumen, content.moments.front().wall, around.center,
                           1.4 * around.radius_mm);
    frame =
        path ? frame_lesion(walls, context, *path, content.lesion_abscissa_mm) : frame_tree(walls);
    const double aspect = frame.half_width_mm / frame.half_height_mm;
    height = int(std::clamp(double(kCloseUpWidth) / aspect, 240.0, 620.0));
    // A tall frame must still fit: then the width shows more than asked for.
    frame.half_width_mm =
        std::max(frame.half_width_mm, frame.half_height_mm * kCloseUpWidth / height);
  }
};

constexpr int kBarStrip = 46;  // free paper below a scene, for its scale bar [pixel]

/// The same view with free paper below it.
ViewFrame with_strip(ViewFrame frame, int width, int height, int strip_height) {
  const double mm_per_pixel = 2.0 * frame.half_width_mm / width;
  frame.half_height_mm = 0.5 * mm_per_pixel * (height + strip_height);
  frame.focus -= (0.5 * mm_per_pixel * strip_height) * frame.up;
  return frame;
}

/// @param strip_height  free paper below the scene [pixel]
Picture render_close_up(vtkRenderer* renderer, const CloseUp& close_up, int strip_height) {
  if (!close_up.context.triangles.empty())
    renderer->AddActor(make_surface(close_up.context, {colors::kSurroundings, 0.25}));
  const int height = close_up.height + strip_height;
  aim(renderer, with_strip(close_up.frame, kCloseUpWidth, close_up.height, strip_height),
      double(kCloseUpWidth) / height);
  ScaleBar bar(renderer, kSupersampling, colors::kInk);
  // The bar needs the picture's size, which only a window gives a renderer.
  return render_offscreen({renderer}, kCloseUpWidth, height, [&] { bar.update(); });
}

std::string kpa_text(double pressure) {
  return formats::fixed_text(pressure, pressure < 10.0 ? 2 : 0) + " kPa";
}

double highest(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

}  // namespace

ViewFrame close_up_frame(const ReportContent& content) { return CloseUp(content).frame; }

double usual_peak(const std::vector<Moment>& moments) {
  double peak = 1e-3;
  for (const Moment& moment : moments) {
    std::vector<double> pressed;
    for (const double p : moment.contact_pressure_kpa)
      if (p > 0.0) pressed.push_back(p);
    if (pressed.empty()) continue;
    std::sort(pressed.begin(), pressed.end());
    peak = std::max(peak, pressed[(pressed.size() - 1) * 49 / 50]);
  }
  return peak;
}

ViewFrame tree_frame(const ReportContent& content) {
  const CenterlinePath* path = lesion_path(content);
  if (!path || content.lumen.vertices.empty()) return frame_tree(content.lumen);
  return frame_tree(content.lumen,
                    frame_lesion(content.lumen, {}, *path, content.lesion_abscissa_mm).direction);
}

Figure draw_tree(const ReportContent& content) {
  constexpr int kStrip = 120;    // for the scale bar and the axes
  constexpr double kRing = 4.0;  // radii of the lumen
  ViewFrame frame = tree_frame(content);
  const CenterlinePath* path = lesion_path(content);
  const CenterlineSample lesion =
      path ? sample(*path, content.lesion_abscissa_mm) : CenterlineSample{};
  if (path) include_circle(frame, lesion.point, std::max(kRing * lesion.inscribed_radius, 1e-3));
  const double aspect = std::clamp(frame.half_width_mm / frame.half_height_mm, 0.6, 2.0);
  const int width = aspect >= 1.0 ? kTreeLongSide : int(kTreeLongSide * aspect);
  const int scene_height = aspect >= 1.0 ? int(kTreeLongSide / aspect) : kTreeLongSide;
  frame.half_width_mm = std::max(frame.half_width_mm, frame.half_height_mm * width / scene_height);
  frame = with_strip(frame, width, scene_height, kStrip);
  const int height = scene_height + kStrip;
  const double picture_aspect = double(width) / height;

  const auto renderer = make_stage();
  renderer->AddActor(make_surface(content.lumen, {colors::kLumen, 1.0}));
  aim(renderer, frame, picture_aspect);
  if (path) {
    constexpr double kLeastRing = 0.03;  // of the picture's height
    const double ring =
        std::max(kRing * lesion.inscribed_radius / (2.0 * frame.half_height_mm), kLeastRing);
    add_mark(renderer, place_in_picture(frame, picture_aspect, lesion.point), ring,
             site_name(content), width * kSupersampling, height * kSupersampling, kSupersampling);
  }
  ScaleBar bar(renderer, kSupersampling, colors::kInk);
  const auto axes = make_axes(kSupersampling, colors::kInk);
  turn_axes(axes, renderer, width, height);
  return {"tree.png",
          "The vessel tree as segmented and meshed; the ring marks the " + site_name(content) +
              ". "
              "Arrows: L to the patient's left, P to the back, H to the head.",
          render_offscreen({renderer, axes}, width, height, [&] { bar.update(); })};
}

std::vector<Figure> draw_moments(const ReportContent& content) {
  std::vector<Figure> figures;
  if (content.moments.empty()) return figures;
  const CloseUp close_up(content);
  for (const Moment& moment : content.moments) {
    const auto renderer = make_stage();
    for (const auto& actor : make_balloon(moment.balloon, moment.guidewire))
      renderer->AddActor(actor);
    renderer->AddActor(make_surface(moment.wall, {colors::kLumen, 0.25}));
    figures.push_back({"close_up_" + std::to_string(figures.size() + 1) + ".png", moment.title,
                       render_close_up(renderer, close_up, kBarStrip)});
  }
  return figures;
}

std::vector<Figure> draw_sequence(const ReportContent& content) {
  if (content.sequence.empty()) return {};
  constexpr int kColumns = 3, kPanelWidth = 460, kStrip = 74, kTitle = 24;
  CloseUp close_up(content);
  const int height = std::max(96, close_up.height * kPanelWidth / kCloseUpWidth) + kTitle;
  const auto map = make_pressure_colors(usual_peak(content.sequence));
  Sheet sheet(kColumns, content.sequence.size(), kPanelWidth, height, kStrip);
  const int panel_width = kPanelWidth - Sheet::kGutter, panel_height = height - Sheet::kGutter;
  const double aspect = double(panel_width) / panel_height;
  for (const Moment& moment : content.sequence) {
    const auto renderer = make_stage();
    for (const auto& actor : make_balloon(moment.balloon, moment.guidewire))
      renderer->AddActor(actor);
    const auto wall = make_surface(moment.wall, {colors::kLumen, 1.0});
    color_by_translucent(wall, moment.contact_pressure_kpa, map);
    renderer->AddActor(wall);
    if (!close_up.context.triangles.empty())
      renderer->AddActor(make_surface(close_up.context, {colors::kSurroundings, 0.25}));
    aim(renderer, close_up.frame, aspect);
    add_panel_title(renderer, moment.title, panel_height);
    sheet.add(renderer);
  }
  const auto strip = make_stage();
  const int width = kColumns * kPanelWidth;
  add_color_bar(strip, map, "contact pressure [kPa]",
                {0.6 * width * kSupersampling, 26.0 * kSupersampling, 0.36 * width * kSupersampling,
                 14.0 * kSupersampling},
                kSupersampling, colors::kInk);
  const double half_height =
      std::max(close_up.frame.half_height_mm, close_up.frame.half_width_mm / aspect);
  sheet.add_strip(strip, kStrip, 2.0 * half_height / panel_height);
  return {{"sequence.png",
           "The balloon (blue, its guidewire dark) in the vessel from its insertion to the end of "
           "its deflation; the "
           "wall's colour is the pressure of the balloon on it.",
           sheet.take()}};
}

std::vector<Figure> draw_contact(const ReportContent& content) {
  const Moment* pressed = nullptr;
  double high = 0.0;
  for (const Moment& moment : content.moments)
    if (moment.contact_pressure_kpa.size() == moment.wall.vertices.size() &&
        highest(moment.contact_pressure_kpa) > high) {
      high = highest(moment.contact_pressure_kpa);
      pressed = &moment;
    }
  if (!pressed) return {};
  const CloseUp close_up(content);
  const auto renderer = make_stage();
  const double shown = usual_peak(content.sequence.empty() ? content.moments : content.sequence);
  const auto map = make_pressure_colors(shown);
  const auto wall = make_surface(pressed->wall, {colors::kLumen, 1.0});
  color_by(wall, pressed->contact_pressure_kpa, map);
  renderer->AddActor(wall);
  constexpr int kStrip = 70;  // for the colour bar
  add_color_bar(renderer, map, "contact pressure [kPa]",
                {0.45 * kCloseUpWidth * kSupersampling, 24.0 * kSupersampling,
                 0.5 * kCloseUpWidth * kSupersampling, 14.0 * kSupersampling},
                kSupersampling, colors::kInk);
  return {{"contact.png",
           pressed->title + ": pressure of the balloon on the wall, at most " + kpa_text(high) +
               " (seen from outside)." +
               (high > shown ? " The colours end at " + kpa_text(shown) + ": few places bear more."
                             : ""),
           render_close_up(renderer, close_up, kStrip)}};
}

}  // namespace angio::viewer::detail
