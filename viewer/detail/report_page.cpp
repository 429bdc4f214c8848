#include "viewer/detail/report_page.hpp"

#include <array>

#include "core/atomic_file.hpp"
#include "formats/html.hpp"
#include "formats/text.hpp"
#include "viewer/detail/page_style.hpp"
#include "viewer/detail/xray_frames.hpp"

namespace angio::viewer::detail {
namespace fs = std::filesystem;
namespace {

constexpr const char* kMethodNotes =
    "<p>Coordinates in every file are DICOM patient space, LPS, in millimetres: x to the patient's "
    "left, y to the back, z to the head.</p>"
    "<p>MLD is twice the largest inscribed radius at the narrowest place; MLA the least area of a "
    "section at right angles to the vessel. Diameter stenosis = 100 (1 − MLD / reference "
    "diameter); the interpolated reference is the healthy vessel's diameter at the narrowest "
    "place, read off a line through the healthy stretches before and behind; the average reference "
    "is the mean of the healthy diameters on both sides. Before, at peak and after, MLD and MLA "
    "are of the simulated wall, between the lesion's "
    "edges along the treated vessel, as far as the balloon goes; the stenoses' table is of the "
    "lumen before it was meshed. Acute gain = MLD after − "
    "MLD before. Recoil = MLD at peak, the lumen that the balloon holds open, − MLD after. Where "
    "the simulation was run twice, from starts that nobody could tell apart, the range of both is "
    "how well the solver repeats itself; a finer mesh may change more. "
    "Pressures are above the outside.</p>\n";

}  // namespace

std::string Album::block(const std::vector<Figure>& figures, const std::string& css) const {
  if (figures.empty()) return {};
  std::string out = "<div class=\"" + css + "\">";
  for (const Figure& figure : figures) out += element(figure);
  return out + "</div>\n";
}

std::string Album::element(const Figure& figure) const {
  const std::string png = png_bytes(figure.picture);
  write_text_atomically(folder_ / figure.file, png);
  const std::string caption = formats::escape_html(figure.caption);
  return "<figure><img width=\"" + std::to_string(figure.picture.width) + "\" height=\"" +
         std::to_string(figure.picture.height) + "\" alt=\"" + caption +
         "\" src=\"data:image/png;base64," + formats::base64(png) + "\"><figcaption>" + caption +
         "</figcaption></figure>\n";
}

std::string section(const std::string& title, const std::string& body) {
  return body.empty()
             ? ""
             : "<section><h2>" + formats::escape_html(title) + "</h2>\n" + body + "</section>\n";
}

std::string page_head(const std::string& title_text, const std::string& version,
                      const std::string& case_name) {
  const std::string title = formats::escape_html(title_text),
                    name = formats::escape_html(case_name);
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src "
         "data:; "
         "style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         title + (name.empty() ? "" : " – " + name) +
         " – balloon angioplasty report</title>\n<style>" + kPageStyle +
         "</style>\n</head>\n<body>\n<header><h1>" + title + "</h1><p class=\"sub\">" +
         (name.empty() ? "" : "Case " + name + " · ") + "Simulated balloon angioplasty · angio " +
         formats::escape_html(version) + "</p></header>\n<main>\n";
}

std::string use_notice() {
  return "<div class=\"notice\"><strong>Not for clinical use.</strong> A research computation; it "
         "is not a medical device and must not guide the treatment of a patient.</div>\n";
}

namespace {

std::string list_of(const std::vector<std::string>& texts) {
  std::string out = "<ul>";
  for (const std::string& text : texts) out += "<li>" + formats::escape_html(text) + "</li>";
  return out + "</ul>\n";
}

}  // namespace

std::string first_doubts(const std::vector<Doubts>& doubts) {
  if (doubts.empty()) return {};
  const std::vector<std::string>& first = doubts.front().texts;
  std::string others;
  for (std::size_t i = 1; i < doubts.size(); ++i) {
    if (doubts[i].texts.empty()) continue;
    others += (others.empty() ? "" : ", ") + std::to_string(doubts[i].texts.size()) + " on " +
              formats::escape_html(doubts[i].about);
  }
  if (first.empty() && others.empty()) return {};
  std::string out = "<div class=\"notice\"><strong>What to doubt</strong>";
  if (!first.empty()) out += list_of(first);
  if (!others.empty())
    out += "<p><a href=\"#doubts\">" + std::string(first.empty() ? "Remarks" : "More remarks") +
           "</a>: " + others + ".</p>";
  return out + "</div>\n";
}

std::string other_doubts(const std::vector<Doubts>& doubts) {
  std::string body;
  for (std::size_t i = 1; i < doubts.size(); ++i)
    if (!doubts[i].texts.empty())
      body +=
          "<h3>On " + formats::escape_html(doubts[i].about) + "</h3>" + list_of(doubts[i].texts);
  return body.empty() ? body : "<div id=\"doubts\">" + section("Remarks", body) + "</div>\n";
}

std::string page_end(const Metrics& metrics, const std::string& run_json) {
  const std::string tables = metrics.tables() + run_tables(run_json);
  std::string page = section(
      "All numbers", tables.empty()
                         ? tables
                         : "<p>Than the default mesh a finer one changes the lesion's diameters, "
                           "areas and gain and the "
                           "flow by up to 4 %, the pressure drop that is left by 9 %, under the "
                           "balloon strains by up to 16 % (plastic ones by 33 %) and stresses by "
                           "up to 27 %, the volume over its strength by 11 %, contact's gap, area "
                           "and pressures by 16 to 48 %.</p>\n<div "
                           "class=\"tables\">" +
                               tables + "</div>\n");
  page += section("Conventions", kMethodNotes);
  return page + "</main>\n</body>\n</html>\n";
}

void remove_old_pictures(const fs::path& folder) {
  constexpr std::array kNames{"tree.png",
                              "sequence.png",
                              "cloth.png",
                              "corrections.svg",
                              "contact.png",
                              "frames_sheet.png",
                              "cross_sections.png",
                              "close_up_1.png",
                              "close_up_2.png",
                              "close_up_3.png",
                              "angiogram_1.png",
                              "angiogram_2.png",
                              "angiogram_3.png",
                              "angiogram_4.png",
                              "slice_axial.png",
                              "straightened.png",
                              "slice_coronal.png",
                              "slice_sagittal.png",
                              "projection_axial.png",
                              "projection_coronal.png",
                              "projection_sagittal.png"};
  std::error_code ignored;
  for (int n = 1; fs::remove(folder / xray_file(n), ignored); ++n) {
  }
  for (const char* name : kNames) fs::remove(folder / name, ignored);
}

}  // namespace angio::viewer::detail
