#include "viewer/detail/section_slider.hpp"

#include <array>
#include <cmath>

#include "formats/html.hpp"
#include "formats/text.hpp"
#include "viewer/detail/grey_window.hpp"
#include "viewer/detail/path_sections.hpp"
#include "viewer/detail/report_charts.hpp"
#include "viewer/detail/scale_length.hpp"
#include "viewer/page_scripts.hpp"

namespace angio::viewer::detail {
namespace {

constexpr int kPlaces = 33;      // odd: the tightest place is in the middle
constexpr int kTile = 128;       // [pixel]
constexpr double kSide = 420.0;  // of the drawing [px], as wide as the page shows it

std::string px(double value) { return formats::fixed_text(value, 1); }

/// What the lumen is at one moment, near the treated line.
struct LumenAt {
  const char* name;
  const char* css;
  const char* color;  ///< of its contour, in a word
  const DiameterProfile* profile;
  TriangleMesh mesh;
};

std::vector<LumenAt> moments_of(const ReportContent& content,
                                const std::vector<PathSection>& sections) {
  std::vector<LumenAt> moments{
      {"before", "before", "blue", &content.before, near_sections(content.lumen, sections)}};
  if (content.moments.size() > 2) {
    moments.push_back({"at peak", "peak", "green, dashed", &content.peak, content.moments[1].wall});
    moments.push_back({"after", "after", "orange", &content.after, content.moments[2].wall});
  }
  return moments;
}

std::string contour_paths(const LumenAt& moment, const PlaneWindow& window) {
  const double scale = 0.5 * kSide / window.half_size_mm;
  std::string path;
  for (const auto& line : section_contours(moment.mesh, window)) {
    const char* pen = "M";
    for (const SectionPoint& point : line) {
      path += pen + px(scale * point[0]) + " " + px(scale * point[1]);
      pen = "L";
    }
  }
  return path.empty() ? path
                      : "<path class=\"" + std::string(moment.css) + "\" d=\"" + path + "\"/>";
}

/// The tiles below each other.
Picture scan_strip(const Volume<float>& volume, const std::vector<PathSection>& sections) {
  const float outside = lowest(volume.values);
  std::vector<float> values;
  for (const PathSection& section : sections) {
    const auto tile = sample_plane(volume, section.window, kTile, outside);
    values.insert(values.end(), tile.begin(), tile.end());
  }
  const GreyWindow grey = window_of(values);
  Picture strip{kTile, kTile * int(sections.size()), {}};
  for (const float value : values) strip.rgb.insert(strip.rgb.end(), 3, grey.shade(value));
  return strip;
}

std::string diameter_at(const DiameterProfile& profile, double abscissa_mm) {
  double nearest = 1.0, diameter = std::nan("");  // no measure further than 1 mm away
  for (std::size_t i = 0; i < profile.abscissa_mm.size(); ++i) {
    const double away = std::abs(profile.abscissa_mm[i] - abscissa_mm);
    if (away >= nearest) continue;
    nearest = away;
    diameter = profile.inscribed_diameter_mm[i];
  }
  return formats::fixed_text(diameter, 2);
}

/// @param tightest_mm  the place of the MLD before
std::string place_text(const ReportContent& content, const std::vector<LumenAt>& moments,
                       double tightest_mm, double abscissa_mm) {
  std::string text = formats::fixed_text(abscissa_mm, 1) + " mm from the inlet, " +
                     formats::fixed_text(abscissa_mm - tightest_mm, 1) +
                     " mm from the tightest place.";
  if (content.before.abscissa_mm.empty()) return text;
  text += " Diameter";
  const char* comma = " ";
  for (const LumenAt& moment : moments) {
    text += comma + std::string(moment.name) + " " + diameter_at(*moment.profile, abscissa_mm);
    comma = ", ";
  }
  return text + " mm";
}

/// Of the scale bar: a sixth of the section long at most.
double bar_mm(const std::vector<PathSection>& sections) {
  return scale_length(sections.front().window.half_size_mm / 3.0);
}

std::string drawing(const ReportContent& content, const std::vector<PathSection>& sections,
                    const std::vector<LumenAt>& moments) {
  const std::size_t shown = sections.size() / 2;
  const std::string low = px(-0.5 * kSide), side = px(kSide);
  std::string out =
      "<svg id=\"section-view\" role=\"img\" aria-label=\"Section at right angles to "
      "the vessel with the lumen's contours\" data-size=\"" +
      side + "\" viewBox=\"" + low + " " + low + " " + side + " " + side + "\">";
  if (content.volume)
    out += "<image x=\"" + low + "\" y=\"" + px(-(0.5 + double(shown)) * kSide) + "\" width=\"" +
           side + "\" height=\"" + px(kSide * double(sections.size())) +
           "\" preserveAspectRatio=\"none\" href=\"data:image/png;base64," +
           formats::base64(png_bytes(scan_strip(*content.volume, sections))) + "\"/>";
  for (std::size_t i = 0; i < sections.size(); ++i) {
    out += std::string("<g") + (i == shown ? "" : " display=\"none\"") + " data-text=\"" +
           formats::escape_html(
               place_text(content, moments, sections[shown].abscissa_mm, sections[i].abscissa_mm)) +
           "\">";
    for (const LumenAt& moment : moments) out += contour_paths(moment, sections[i].window);
    out += "</g>";
  }
  const double corner = 0.46 * kSide;
  return out + "<path class=\"scale\" d=\"M" + px(-corner) + " " + px(corner) + "h" +
         px(0.5 * kSide * bar_mm(sections) / sections.front().window.half_size_mm) + "\"/></svg>";
}

}  // namespace

std::string section_slider(const ReportContent& content, const Metrics& metrics) {
  const CenterlinePath* path = lesion_path(content);
  if (!path || content.lumen.triangles.empty()) return {};
  const double narrowest = mld_place(content.before, metrics).value_or(content.lesion_abscissa_mm);
  const std::vector<PathSection> sections =
      path_sections(content, *path, places_around(content, *path, narrowest, kPlaces));
  const std::vector<LumenAt> moments = moments_of(content, sections);
  std::string key;
  for (const LumenAt& moment : moments)
    key += std::string(key.empty() ? " " : ", ") + "<span class=\"key " + moment.css +
           "\"></span>" + moment.name + " (" + moment.color + ")";
  const std::string shown = std::to_string(kPlaces / 2);
  return "<figure class=\"sections\">" + drawing(content, sections, moments) +
         "<figcaption><p>Lumen:" + key + "; the bar is " + formats::number_text(bar_mm(sections)) +
         " mm.</p>\n<p><label id=\"section-slider\" hidden>Place along the vessel "
         "<input type=\"range\" id=\"section-place\" min=\"0\" max=\"" +
         std::to_string(kPlaces - 1) + "\" value=\"" + shown +
         "\"></label></p>\n<p><output id=\"section-text\" for=\"section-place\">" +
         formats::escape_html(place_text(content, moments,
                                         sections[sections.size() / 2].abscissa_mm,
                                         sections[sections.size() / 2].abscissa_mm)) +
         "</output></p></figcaption></figure>\n<script>" + kSectionScript + "</script>\n";
}

}  // namespace angio::viewer::detail
