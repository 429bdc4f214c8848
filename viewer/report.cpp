#include "viewer/report.hpp"

#include <algorithm>
#include <array>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/html.hpp"
#include "formats/text.hpp"
#include "viewer/detail/chart.hpp"
#include "viewer/detail/offscreen.hpp"
#include "viewer/detail/page_style.hpp"
#include "viewer/detail/pictures_2d.hpp"
#include "viewer/detail/pictures_3d.hpp"
#include "viewer/detail/report_charts.hpp"
#include "viewer/detail/tables.hpp"

namespace angio::viewer {
namespace fs = std::filesystem;
using detail::Figure;
using formats::escape_html;
namespace {

/// Every picture of the report.
struct Figures {
  std::vector<Figure> tree, sequence, cloth, moments, contact, projections, slices, sections;
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
    figures.cloth = detail::draw_cloth(content);
    progress.report(0.55, "contact pressure");
    figures.contact = detail::draw_contact(content);
  }
  progress.report(0.7, "projections and slices");
  figures.projections = detail::draw_projections(content);
  figures.slices = detail::draw_slices(content);
  figures.sections = detail::draw_contact_sheet(content);
  return figures;
}

/// Writes the pictures beside the page and gives their HTML; figures share one block of a class.
class Album {
 public:
  explicit Album(fs::path folder) : folder_(std::move(folder)) {}

  std::string block(const std::vector<Figure>& figures, const std::string& css) const {
    if (figures.empty()) return {};
    std::string out = "<div class=\"" + css + "\">";
    for (const Figure& figure : figures) out += element(figure);
    return out + "</div>\n";
  }

 private:
  [[nodiscard]] std::string element(const Figure& figure) const {
    const std::string png = detail::png_bytes(figure.picture);
    write_text_atomically(folder_ / figure.file, png);
    const std::string caption = formats::escape_html(figure.caption);
    return "<figure><img width=\"" + std::to_string(figure.picture.width) + "\" height=\"" +
           std::to_string(figure.picture.height) + "\" alt=\"" + caption +
           "\" src=\"data:image/png;formats::base64," + formats::base64(png) + "\"><figcaption>" +
           caption + "</figcaption></figure>\n";
  }

  fs::path folder_;
};

std::string section(const std::string& title, const std::string& body) {
  return body.empty()
             ? ""
             : "<section><h2>" + formats::escape_html(title) + "</h2>\n" + body + "</section>\n";
}

std::string notices(const ReportContent& content) {
  std::string out =
      "<div class=\"notice\"><strong>Not for clinical use.</strong> A research computation; it is "
      "not a medical device and must not guide the treatment of a patient.</div>\n";
  if (content.warnings.empty()) return out;
  out += "<div class=\"notice\"><strong>Please note</strong><ul>";
  for (const std::string& warning : content.warnings)
    out += "<li>" + formats::escape_html(warning) + "</li>";
  return out + "</ul></div>\n";
}

std::string chart_figure(const detail::Chart& chart) {
  const std::string drawing = detail::svg(chart);
  if (drawing.empty()) return {};
  return "<figure><h3>" + formats::escape_html(chart.title) + "</h3>" + drawing + "</figure>\n";
}

std::string chart_grid(const TimeSeries& series) {
  std::string out;
  for (const detail::Chart& chart : detail::time_charts(series)) out += chart_figure(chart);
  return out.empty() ? out : "<div class=\"charts\">" + out + "</div>\n";
}

std::string contour_key(bool has_after) {
  std::string out =
      "<p class=\"sub\">Contours: <span class=\"key\" style=\"background:#46c8ff\"></span>lumen "
      "before";
  if (has_after) out += "<span class=\"key\" style=\"background:#ffa028\"></span>lumen after";
  return out + "</p>\n";
}

std::string image_section(const Album& album, const Figures& figures, bool has_after) {
  std::string out = album.block(figures.projections, "row") + album.block(figures.slices, "row") +
                    album.block(figures.sections, "stack");
  if (!out.empty()) out = contour_key(has_after) + out;
  if (!figures.projections.empty())
    out +=
        "<p class=\"sub\">Projections are maximum intensity projections through the box around "
        "the vessel tree. R, L, A, P, H: the patient's right, left, front, back, head.</p>\n";
  return out;
}

constexpr const char* kMethodNotes =
    "<p>Coordinates in every file are DICOM patient space, LPS, in millimetres: x to the patient's "
    "left, y to the back, z to the head.</p>"
    "<p>MLD is twice the largest inscribed radius at the narrowest place; MLA the least area of a "
    "section at right angles to the vessel. Diameter stenosis = 100 (1 − MLD / reference "
    "diameter); the interpolated reference is the healthy vessel's diameter at the narrowest "
    "place, read off a line through the healthy stretches before and behind; the average reference "
    "is the mean of the healthy diameters on both sides. Acute gain = MLD after − MLD before. "
    "Recoil = balloon diameter at peak − MLD "
    "after. Pressures are above the outside.</p>\n";

/// Of the scan's voxels [mm]; 0 without a scan.
double largest_spacing(const ReportContent& content) {
  if (!content.volume) return 0.0;
  const Vec3& spacing = content.volume->geometry.spacing;
  return std::max({spacing.x, spacing.y, spacing.z});
}

std::string make_page(const ReportContent& content, const Figures& figures, const Album& album) {
  const detail::Metrics metrics(content.metrics_json);
  const std::string title = formats::escape_html(content.title);
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      title + " – balloon angioplasty report</title>\n<style>" + detail::kPageStyle +
      "</style>\n</head>\n<body>\n<header><h1>" + title +
      "</h1><p class=\"sub\">Simulated balloon angioplasty · angio " +
      formats::escape_html(content.version) + "</p></header>\n<main>\n";
  page += detail::status_notice(metrics);
  page += notices(content);
  if (content.cloth.empty())
    page += "<div class=\"cards\">" + detail::headline_cards(metrics) + "</div>\n";
  page += section("The cloth", album.block(figures.cloth, "stack"));
  page += section("Vessel tree", album.block(figures.tree, "tree"));
  page += section("Stenoses", detail::lesion_table(content.lesions_json, largest_spacing(content)));
  page += section("Dilation", album.block(figures.moments, "stack") +
                                  album.block(figures.contact, "stack") +
                                  album.block(figures.sequence, "stack"));
  page +=
      section("Diameter along the vessel", detail::svg(detail::diameter_chart(content, metrics)));
  page += section("Course of the inflation", chart_grid(content.time_series));
  page += section("Images", image_section(album, figures, content.moments.size() > 1));
  const std::string tables = metrics.tables() + detail::run_tables(content.run_json);
  page += section("All numbers",
                  tables.empty() ? tables : "<div class=\"tables\">" + tables + "</div>\n");
  page += section("Conventions", kMethodNotes);
  return page + "</main>\n</body>\n</html>\n";
}

/// Pictures of an earlier report that this one does not have would tell of another state.
void remove_old_pictures(const fs::path& folder) {
  constexpr std::array kNames{"tree.png",
                              "sequence.png",
                              "cloth.png",
                              "corrections.svg",
                              "contact.png",
                              "cross_sections.png",
                              "close_up_1.png",
                              "close_up_2.png",
                              "close_up_3.png",
                              "slice_axial.png",
                              "slice_coronal.png",
                              "slice_sagittal.png",
                              "projection_axial.png",
                              "projection_coronal.png",
                              "projection_sagittal.png"};
  std::error_code ignored;
  for (const char* name : kNames) fs::remove(folder / name, ignored);
}

}  // namespace

void write_report(const fs::path& folder, const ReportContent& content, const Progress& progress) {
  progress.report(0.0, "pictures");
  const Figures figures = draw_all(content, progress);
  make_folder(folder);
  remove_old_pictures(folder);
  progress.report(0.9, "page");
  const std::string page = make_page(content, figures, Album(folder));
  const std::string corrections = detail::svg_file(detail::correction_charts(content.time_series));
  if (!corrections.empty()) write_text_atomically(folder / "corrections.svg", corrections);
  write_text_atomically(folder / "index.html", page);
  progress.report(1.0);
}

}  // namespace angio::viewer
