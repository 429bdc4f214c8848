#include "viewer/report.hpp"

#include <algorithm>
#include <cmath>
#include <future>

#include "core/atomic_file.hpp"
#include "core/clinical_limits.hpp"
#include "core/error.hpp"
#include "formats/html.hpp"
#include "formats/text.hpp"
#include "viewer/detail/angiograms.hpp"
#include "viewer/detail/case_headline.hpp"
#include "viewer/detail/chart.hpp"
#include "viewer/detail/offscreen.hpp"
#include "viewer/detail/pictures_2d.hpp"
#include "viewer/detail/pictures_3d.hpp"
#include "viewer/detail/report_charts.hpp"
#include "viewer/detail/report_page.hpp"
#include "viewer/detail/report_scene.hpp"
#include "viewer/detail/section_slider.hpp"
#include "viewer/detail/tables.hpp"
#include "viewer/detail/view_map.hpp"
#include "viewer/detail/xray_frames.hpp"

namespace angio::viewer {
namespace fs = std::filesystem;
using detail::Figure;
namespace {

/// Every picture of the report.
struct Figures {
  std::vector<Figure> tree, sequence, moments, contact, angiograms, projections, slices, sections,
      straightened, frames;
};

Figures draw_all(const ReportContent& content, const Progress& progress) {
  Figures figures;
  {
    const detail::OffscreenDisplay display;
    progress.report(0.05, "vessel tree");
    if (!content.lumen.triangles.empty()) figures.tree.push_back(detail::draw_tree(content));
    progress.report(0.25, "close-ups");
    figures.moments = detail::draw_moments(content);
    figures.sequence = detail::draw_sequence(content);
    progress.report(0.55, "contact pressure");
    figures.contact = detail::draw_contact(content);
  }
  progress.report(0.7, "projections and slices");
  figures.angiograms = detail::draw_angiograms(content);
  figures.frames = detail::draw_xray_frames(content);
  figures.projections = detail::draw_projections(content);
  figures.slices = detail::draw_slices(content);
  figures.sections = detail::draw_contact_sheet(content);
  figures.straightened = detail::draw_straightened(content);
  return figures;
}

std::string chart_figure(const detail::Chart& chart) {
  const std::string drawing = detail::svg_for_page(chart);
  if (drawing.empty()) return {};
  return "<figure><h3>" + formats::escape_html(chart.title) + "</h3>" + drawing + "</figure>\n";
}

std::string chart_grid(const std::vector<detail::Chart>& charts) {
  std::string out;
  for (const detail::Chart& chart : charts) out += chart_figure(chart);
  return out.empty() ? out : "<div class=\"charts\">" + out + "</div>\n";
}

std::string moments_section(const detail::Album& album, const std::vector<Figure>& moments) {
  if (moments.empty()) return {};
  return album.block(moments, "stack") +
         "<p class=\"sub\">Blue: the balloon, on its guidewire. Pink: the wall that is simulated, "
         "as "
         "far as the balloon may reach. Grey: the rest of the lumen, which does not move.</p>\n";
}

std::string contour_key(bool has_after) {
  std::string out =
      "<p class=\"sub\">Contours: <span class=\"key\" style=\"background:#46c8ff\"></span>lumen "
      "before (light blue)";
  if (has_after)
    out +=
        ", <span class=\"key\" style=\"background:#ffa028\"></span>lumen after (orange; in the "
        "sections)";
  return out + "</p>\n";
}

std::string image_section(const detail::Album& album, const Figures& figures, bool has_after) {
  std::string out = album.block(figures.projections, "row") + album.block(figures.slices, "row") +
                    album.block(figures.sections, "stack");
  if (!out.empty()) out = contour_key(has_after) + out;
  if (!figures.projections.empty())
    out +=
        "<p class=\"sub\">Projections are maximum intensity projections through the box around "
        "the vessel tree. R, L, A, P, H: the patient's right, left, front, back, head.</p>\n";
  return out;
}

std::string flow_section(const ReportContent& content, const detail::Metrics& metrics) {
  const std::string drawing = detail::svg_for_page(detail::flow_chart(content, metrics));
  if (drawing.empty()) return {};
  const std::string flow =
      formats::fixed_text(metrics.number("flow", "inlet_flow_ml_min").value_or(0.0), 0);
  return drawing +
         "<p class=\"sub\">An estimate of a reduced model, not a measurement: friction and the "
         "losses behind throats (Young, Tsai 1973) in front of small vessels that would let " +
         flow +
         " mL/min, a guess from the inlet's diameter, into a healthy tree. Dashed: one standard "
         "deviation of diameters and flow; shaded: the lesion. " +
         (detail::is_coronary(metrics)
              ? "At " + formats::fixed_text(limits::kFlowLimitingFfr, 2) +
                    " and less a stenosis limits flow."
              : "In a coronary artery this ratio is the fractional flow reserve (flow.vessel); "
                "nothing says that this is one, so that no threshold applies.") +
         "</p>\n";
}

std::string pressure_section(const ReportContent& content, const detail::Metrics& metrics) {
  const std::string drawing =
      detail::svg_for_page(detail::pressure_diameter_chart(content, metrics));
  if (drawing.empty()) return {};
  std::string words = "The balloon's diameter at the lesion";
  if (const auto below = metrics.number("balloon", "below_chart_mm"))
    words += ", at the peak " + formats::fixed_text(std::abs(*below), 2) + " mm " +
             (*below < 0.0 ? "above" : "below") + " what its chart says of the balloon alone";
  const auto rated = metrics.number("balloon", "rated_burst_atm"),
             peak = metrics.number("balloon", "peak_pressure_atm");
  if (rated && peak && *peak > *rated)
    words += ". <strong>The peak is above the rated burst pressure</strong>";
  return drawing + "<p class=\"sub\">" + words + ".</p>\n";
}

std::string view_section(const ReportContent& content, const detail::Metrics& metrics,
                         const detail::Album& album, const std::vector<Figure>& angiograms) {
  const std::string seen =
      metrics.text("status") == "no_lesion" ? "the vessel at the trial place" : "the lesion";
  const std::string others =
      content.tree.paths.size() > 1 ? "other vessels" : "other parts of the vessel";
  std::string out;
  if (content.views.working) {
    const angiogram::SeenSegment& best = content.views.working->best;
    out = "<p><strong>" + angiogram::c_arm_label(best.angles) + "</strong> shortens " + seen +
          " by " + formats::fixed_text(best.foreshortening_percent, 0) + " %; " + others +
          " overlap " + formats::fixed_text(best.overlap_percent, 0) +
          " % of it. Of views within 0.5 % those are taken in which the "
          "throat looks narrowest, and of these the one nearest to the front.</p>\n" +
          "<figure>" + detail::view_map_for_page(*content.views.working) + "</figure>\n" +
          detail::view_map_key(seen, others);
  }
  if (!angiograms.empty())
    out += "<h3>Virtual angiograms</h3>\n" + album.block(angiograms, "pairs") +
           "<p class=\"sub\">The lumen as X-ray, filled with contrast medium, nothing else in the "
           "beam, diluted where a vessel is wide; parallel rays. One scale of grey.</p>\n";
  return out;
}

std::string frames_section(const ReportContent& content, const detail::Album& album,
                           const std::vector<Figure>& figures) {
  if (figures.empty()) return {};
  return album.block(figures, "tiles") +
         "<p class=\"sub\"><span class=\"key\" style=\"background:#ff5a1e\"></span>The lumen's "
         "outline as the C-arm sees it from where each frame was taken to be; where it leaves the "
         "vessel's shadow, that place or the lumen is off. Dark: the beam is weakened" +
         std::string(content.frames.front().is_subtracted
                         ? ", by contrast medium alone"
                         : "; what is broader than vessels was taken out") +
         ".</p>\n";
}

std::string make_page(const ReportContent& content, const Figures& figures,
                      const detail::Album& album, const std::string& scene) {
  const detail::Metrics metrics(content.metrics_json);
  const std::string headline = detail::case_headline(metrics, content.input_kind);
  std::string page = headline.empty() ? detail::page_head(content.title, content.version)
                                      : detail::page_head(headline, content.version, content.title);
  page += detail::use_notice();
  page += detail::status_notice(metrics);
  page += detail::headline(metrics);
  page += detail::first_doubts(content.doubts);
  page += detail::section("Vessel tree", album.block(figures.tree, "tree"));
  page += detail::section("Stenoses", detail::lesion_table(content.lesions_json));
  page += detail::section("Dilation", moments_section(album, figures.moments) +
                                          album.block(figures.contact, "stack") +
                                          album.block(figures.sequence, "stack"));
  page +=
      detail::section("Working view", view_section(content, metrics, album, figures.angiograms));
  page += scene;
  page += detail::section("Diameter along the vessel",
                          detail::svg_for_page(detail::diameter_chart(content, metrics)));
  page +=
      detail::section("Sections along the vessel", detail::section_slider(content, metrics) +
                                                       album.block(figures.straightened, "stack"));
  page += detail::section(
      detail::is_coronary(metrics) ? "Fractional flow reserve" : "Pressure along the vessel",
      flow_section(content, metrics));
  page += detail::section("Pressure and diameter", pressure_section(content, metrics));
  page += detail::section("Course of the inflation",
                          chart_grid(detail::time_charts(content.time_series)));
  page += detail::section("X-ray frames", frames_section(content, album, figures.frames));
  page += detail::section("Images", image_section(album, figures, content.moments.size() > 1));
  page += detail::other_doubts(content.doubts);
  page += detail::section("Solver", chart_grid(detail::solver_charts(content.time_series)));
  return page + detail::page_end(metrics, content.run_json);
}

}  // namespace

void write_report(const fs::path& folder, const ReportContent& content, const Progress& progress) {
  progress.report(0.0, "pictures");
  // Its meshes are thinned beside the drawing.
  std::future<std::string> scene =
      std::async(std::launch::async, [&content] { return detail::scene_section(content); });
  const Figures figures = draw_all(content, progress);
  make_folder(folder);
  detail::remove_old_pictures(folder);
  progress.report(0.9, "page");
  const std::string page = make_page(content, figures, detail::Album(folder), scene.get());
  if (!figures.frames.empty())
    write_text_atomically(folder / "frames_sheet.png",
                          detail::png_bytes(detail::sheet_of(figures.frames)));
  const std::string corrections = detail::svg_file(detail::correction_charts(content.time_series));
  if (!corrections.empty()) write_text_atomically(folder / "corrections.svg", corrections);
  write_text_atomically(folder / "index.html", page);
  progress.report(1.0);
}

std::vector<std::size_t> sequence_places(std::size_t frame_count, std::size_t peak) {
  constexpr int kToPeak = 5, kToEnd = 3;
  const double last = double(frame_count) - 1.0, top = double(peak);
  std::vector<std::size_t> places;
  for (int i = 0; i <= kToPeak; ++i) places.push_back(std::size_t(std::lround(top * i / kToPeak)));
  for (int i = 1; i <= kToEnd; ++i)
    places.push_back(std::size_t(std::lround(top + (last - top) * i / kToEnd)));
  return places;
}

}  // namespace angio::viewer
