#include "viewer/cloth_report.hpp"

#include <algorithm>
#include <cmath>

#include "core/atomic_file.hpp"
#include "formats/text.hpp"
#include "viewer/detail/offscreen.hpp"
#include "viewer/detail/rendering.hpp"
#include "viewer/detail/report_page.hpp"
#include "viewer/detail/scene.hpp"
#include "viewer/detail/sheet.hpp"

namespace angio::viewer {
using namespace detail;
namespace {

/// The mesh above its thickness.
Figure draw_cloth(const std::vector<ClothMoment>& moments) {
  constexpr int kPanel = 340, kStrip = 74;
  const int columns = int(moments.size());
  TriangleMesh all;  // one frame for all states
  for (const ClothMoment& moment : moments)
    all.vertices.insert(all.vertices.end(), moment.mesh.vertices.begin(),
                        moment.mesh.vertices.end());
  const Bounds around = bounds(all);
  ViewFrame frame;
  frame.focus = around.center;
  frame.direction = {0, 0, -1};
  frame.up = {0, 1, 0};
  frame.half_width_mm = frame.half_height_mm = 1.25 * around.radius_mm / std::sqrt(2.0);

  // A few vertices at the corners are far thinner than the rest; they get the last colour.
  std::vector<double> last = moments.back().thickness_mm;
  std::sort(last.begin(), last.end());
  const double low = last[last.size() / 30], high = moments.front().thickness_mm.front();
  const auto map = make_thickness_colors(low, high);
  Sheet sheet(columns, 2 * moments.size(), kPanel, kPanel, kStrip);
  for (const bool with_thickness : {false, true})
    for (const ClothMoment& moment : moments) {
      const auto renderer = make_stage();
      const auto surface = make_surface(moment.mesh, {colors::kCloth, 1.0});
      if (with_thickness)
        color_by(surface, moment.thickness_mm, map);
      else
        show_edges(surface);
      renderer->AddActor(surface);
      aim(renderer, frame, 1.0);
      const auto [least, most] =
          std::minmax_element(moment.thickness_mm.begin(), moment.thickness_mm.end());
      add_panel_title(renderer,
                      with_thickness ? formats::fixed_text(*least, 3) + " to " +
                                           formats::fixed_text(*most, 3) + " mm"
                                     : moment.title,
                      kPanel - Sheet::kGutter);
      sheet.add(renderer);
    }
  const auto strip = make_stage();
  const double width = double(columns) * kPanel * kSupersampling;
  add_color_bar(strip, map, "thickness [mm]",
                {0.5 * width, 26.0 * kSupersampling, 0.46 * width, 14.0 * kSupersampling},
                kSupersampling, colors::kInk);
  sheet.add_strip(strip, kStrip, 2.0 * frame.half_width_mm / (kPanel - Sheet::kGutter));
  return {"cloth.png",
          "The cloth pulled at its four corners (growth of the corners' distance): its mesh, and "
          "below its thickness. Thinner than " +
              formats::fixed_text(low, 3) + " mm are only the corners.",
          sheet.take()};
}

std::string make_page(const ClothReport& content, const Figure& figure, const Album& album) {
  const Metrics metrics(content.metrics_json);
  return page_head(content.title, content.version) + use_notice() + status_notice(metrics) +
         first_doubts(content.doubts) + section("The cloth", album.block({figure}, "stack")) +
         page_end(metrics, content.run_json);
}

Figure draw(const ClothReport& content) {
  const OffscreenDisplay display;
  return draw_cloth(content.moments);
}

}  // namespace

void write_cloth_report(const std::filesystem::path& folder, const ClothReport& content,
                        const Progress& progress) {
  progress.report(0.0, "pictures");
  const Figure figure = draw(content);
  make_folder(folder);
  remove_old_pictures(folder);
  progress.report(0.9, "page");
  write_text_atomically(folder / "index.html", make_page(content, figure, Album(folder)));
  progress.report(1.0);
}

}  // namespace angio::viewer
