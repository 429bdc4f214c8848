#include "pipeline/cli/batch_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

#include "formats/html.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
using formats::escape_html;
using nlohmann::json;
namespace {

constexpr const char* kStyle = R"(
:root{color-scheme:light dark;--line:#8886;--soft:#8881;--bad:#c33;--doubt:#a70}
body{font:15px/1.4 system-ui,sans-serif;margin:1.5rem}h1{font-size:1.4rem}h2{font-size:1.1rem}
.tools{display:flex;flex-wrap:wrap;gap:1rem;margin:1rem 0}input,select{font:inherit;padding:.2em .4em}
.wide{overflow:auto;max-height:85vh;max-width:100%;border:1px solid var(--line);
background:linear-gradient(270deg,Canvas 30%,transparent) 100% 0/60px 100% local,
linear-gradient(270deg,#8888,transparent) 100% 0/20px 100% scroll;background-repeat:no-repeat}
.wide::-webkit-scrollbar{width:12px;height:12px}.wide::-webkit-scrollbar-track{background:var(--soft)}
.wide::-webkit-scrollbar-thumb{background:#8888;border-radius:6px}
table{border-collapse:separate;border-spacing:0}td,th{border-bottom:1px solid var(--line);padding:.3em .6em;
text-align:right;vertical-align:middle}thead th{position:sticky;top:0;background:Canvas;z-index:1}
tr>:first-child{position:sticky;left:0;background:Canvas;border-right:1px solid var(--line);min-width:5rem;max-width:40vw;overflow-wrap:break-word}
thead tr>:first-child{z-index:2}th button{font:inherit;font-weight:600;
background:none;border:0;padding:0;cursor:pointer;color:inherit;text-align:inherit}
th[aria-sort=ascending] button::after{content:" \25B2"}th[aria-sort=descending] button::after{content:" \25BC"}
.text{text-align:left;max-width:24rem}.reason:not(:empty){min-width:14rem}td img{width:6rem;height:4.5rem;object-fit:contain;display:block}
small{font-weight:400;opacity:.75}.failed .status,.interrupted .status{color:var(--bad);font-weight:600}
.stale .status,.doubt .status{color:var(--doubt);font-weight:600}
tr[data-status=no_lesion] td.measure{opacity:.6;font-style:italic}
.figures{display:flex;flex-wrap:wrap;gap:1rem}figure{margin:0}figure img{max-width:100%}
.sheet{display:grid;grid-template-columns:repeat(auto-fill,minmax(20rem,1fr));gap:1rem}
.sheet article{border:1px solid var(--line);padding:.6rem}.sheet img{width:100%;display:block;margin-top:.4rem}
)";

constexpr const char* kScript = R"(
const rows=()=>[...document.querySelectorAll('tbody tr')];
const words=document.getElementById('words'),state=document.getElementById('state'),shown=document.getElementById('shown');
function filter(){const w=words.value.toLowerCase().split(/\s+/);let n=0;
for(const r of rows()){const t=r.textContent.toLowerCase();
r.hidden=!(w.every(x=>t.includes(x))&&(!state.value||r.dataset.status===state.value));n+=!r.hidden}
shown.textContent=n+' of '+rows().length+' shown'}
function sort(head){const i=head.cellIndex,up=head.getAttribute('aria-sort')!=='ascending';
for(const h of document.querySelectorAll('th'))h.removeAttribute('aria-sort');
head.setAttribute('aria-sort',up?'ascending':'descending');
const key=r=>r.cells[i].dataset.value??r.cells[i].textContent;
const number=s=>s===''?NaN:Number(s);
rows().sort((a,b)=>{const x=key(a),y=key(b),p=number(x),q=number(y);
const order=isNaN(p)||isNaN(q)?(isNaN(p)&&isNaN(q)?x.localeCompare(y,undefined,{numeric:true}):(isNaN(p)?1:-1)*(up?1:-1)):p-q;
return up?order:-order}).forEach(r=>r.parentNode.append(r))}
words.addEventListener('input',filter);state.addEventListener('change',filter);
for(const b of document.querySelectorAll('th button'))b.addEventListener('click',()=>sort(b.closest('th')));filter();
)";

/// The first of these pictures that a case's report has; empty: none.
std::string picture_of(const fs::path& folder, const std::string& name,
                       const std::vector<std::string>& files) {
  for (const std::string& file : files)
    if (fs::exists(folder / name / "report" / file)) return name + "/report/" + file;
  return {};
}

std::string image(const std::string& source, const std::string& words) {
  if (source.empty()) return {};
  return fmt::format("<img loading=\"lazy\" src=\"{}\" alt=\"{}\">", escape_html(source),
                     escape_html(words));
}

/// "done", or what to look at first.
std::string shown_status(const SummaryCase& one) {
  const bool is_done = one.outcome.status == "done";
  return is_done && !one.case_status.empty() ? one.case_status : one.outcome.status;
}

std::string class_of(const SummaryCase& one) {
  const std::string status = shown_status(one);
  const bool doubts = status == "not_determined" || status == "no_lesion";
  return doubts ? "doubt" : status;
}

/// The case's name, as a link where it has a report.
std::string name_link(const fs::path& folder, const SummaryCase& one) {
  const std::string name = escape_html(one.name);
  const bool has_report = fs::exists(folder / one.name / "report" / "index.html");
  return has_report ? fmt::format("<a href=\"{0}/report/index.html\">{0}</a>", name) : name;
}

std::string name_cell(const fs::path& folder, const SummaryCase& one) {
  const bool has_log = fs::exists(folder / "logs" / (one.name + ".log"));
  return fmt::format("<th scope=\"row\" class=\"text\">{}{}</th>", name_link(folder, one),
                     has_log ? fmt::format(" <small><a href=\"logs/{}.log\">log</a></small>",
                                           escape_html(one.name))
                             : "");
}

std::optional<double> number_at(const SummaryCase& one, const char* pointer) {
  const json value = value_at(one, pointer);
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

std::string number_cell(std::optional<double> value, const std::string& format,
                        const char* kind = "measure") {
  if (!value) return fmt::format("<td class=\"{}\" data-value=\"\">–</td>", kind);
  return fmt::format("<td class=\"{}\" data-value=\"{:.17g}\">{}</td>", kind, *value,
                     fmt::format(fmt::runtime(format), *value));
}

std::string format_of(const SummaryMeasure& measure) {
  return fmt::format("{{:.{}f}}", measure.decimals);
}

/// A measure, and where the scan does not resolve the throat, what it is at most or at least.
std::string measure_cell(const SummaryCase& one, const SummaryMeasure& measure) {
  const std::string_view pointer = measure.pointer;
  const bool is_mld = pointer == "/lesion/mld_mm";
  if (is_mld || pointer == "/lesion/diameter_stenosis_percent") {
    const std::optional<double> bound =
        number_at(one, is_mld ? "/lesion/resolution_mm" : "/lesion/stenosis_at_least_percent");
    if (bound && value_at(one, "/lesion/mld_below_resolution") == true)
      return number_cell(bound, (is_mld ? "&lt; " : "≥ ") + format_of(measure));
  }
  return number_cell(number_at(one, measure.pointer), format_of(measure));
}

std::string row_of(const fs::path& folder, const SummaryCase& one) {
  const std::string status = shown_status(one);
  std::string warnings;
  for (const std::string& warning : one.warnings) warnings += "\n" + warning;
  std::string row = fmt::format(
      "<tr class=\"{}\" data-status=\"{}\">{}<td>{}</td><td class=\"text status\">{}</td>"
      "<td class=\"text reason\">{}</td>",
      escape_html(class_of(one)), escape_html(status), name_cell(folder, one),
      image(picture_of(folder, one.name, {"tree.png"}), "tree of " + one.name), escape_html(status),
      escape_html(one.reason));
  for (const SummaryMeasure& measure : summary_measures()) row += measure_cell(one, measure);
  row += fmt::format("<td data-value=\"{}\" title=\"{}\">{}</td>", one.warnings.size(),
                     escape_html(warnings), one.warnings.size());
  const bool was_run = one.seconds > 0.0;
  row += number_cell(was_run ? std::optional(one.seconds) : std::nullopt, "{:.0f}", "cost");
  row += number_cell(was_run ? std::optional(one.peak_memory_mib) : std::nullopt, "{:.0f}", "cost");
  return row + "</tr>\n";
}

std::string head_cell(const std::string& title, const std::string& unit, const char* kind = "") {
  return fmt::format("<th scope=\"col\"{}><button type=\"button\">{}</button>{}</th>", kind, title,
                     unit.empty() ? "" : "<br><small>" + unit + "</small>");
}

std::string table_head() {
  const char* text = " class=\"text\"";
  std::string head = "<thead><tr>" + head_cell("Case", "", text) + "<th scope=\"col\">Tree</th>" +
                     head_cell("Status", "", text) + head_cell("Reason", "", text);
  for (const SummaryMeasure& measure : summary_measures())
    head += head_cell(measure.title, measure.unit);
  return head + head_cell("Remarks", "") + head_cell("Time", "s") + head_cell("Memory", "MiB") +
         "</tr></thead>\n";
}

std::string page(const std::string& title, const std::string& body) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\"><title>{0}</title><style>{1}</style></head>\n<body><main>"
      "<h1>{0}</h1>\n{2}<p>Not for clinical use.</p></main></body></html>\n",
      title, kStyle, body);
}

/// How many cases have each status, most first.
std::string status_choices(const std::vector<SummaryCase>& cases) {
  std::map<std::string, int> counts;
  for (const SummaryCase& one : cases) ++counts[shown_status(one)];
  std::string choices = fmt::format("<option value=\"\">all ({})</option>", cases.size());
  for (const auto& [status, count] : counts)
    choices += fmt::format("<option value=\"{0}\">{0} ({1})</option>", escape_html(status), count);
  return choices;
}

/// A case's name and its value.
using NamedValue = std::pair<std::string, double>;

/// Of the cases with a stenosis that have the measure, the least first.
std::vector<NamedValue> values_of(const std::vector<SummaryCase>& cases,
                                  const SummaryMeasure& measure) {
  std::vector<NamedValue> values;
  for (const SummaryCase& one : cases) {
    if (class_of(one) == "doubt") continue;  // a trial beside no stenosis
    if (const auto value = number_at(one, measure.pointer)) values.emplace_back(one.name, *value);
  }
  std::stable_sort(values.begin(), values.end(),
                   [](const NamedValue& a, const NamedValue& b) { return a.second < b.second; });
  return values;
}

/// Where a measure's figure is drawn [px].
constexpr double kPlotWidth = 260.0, kPlotHeight = 90.0, kPlotLeft = 10.0, kPlotTop = 26.0;

/// Counts in even steps between the least and the greatest value; as many as the square root of
/// their number, 5 to 20.
std::vector<int> histogram(const std::vector<double>& values) {
  const auto wanted = std::size_t(std::lround(std::sqrt(double(values.size()))));
  std::vector<int> counts(std::clamp<std::size_t>(wanted, 5, 20));
  const double width = (values.back() - values.front()) / double(counts.size());
  for (const double value : values) {
    const auto bin = width > 0.0 ? std::size_t((value - values.front()) / width) : 0;
    ++counts[std::min(bin, counts.size() - 1)];
  }
  return counts;
}

double quantile(const std::vector<double>& sorted, double share) {
  const double place = share * double(sorted.size() - 1);
  const auto below = std::size_t(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - double(below)) * (sorted[above] - sorted[below]);
}

std::string draw_bars(const std::vector<double>& sorted) {
  const std::vector<int> counts = histogram(sorted);
  const int most = *std::max_element(counts.begin(), counts.end());
  std::string bars;
  const double step = kPlotWidth / double(counts.size());
  for (std::size_t b = 0; b < counts.size(); ++b) {
    const double height = kPlotHeight * counts[b] / most;
    bars += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" "
        "height=\"{:.1f}\"><title>{}</title></rect>",
        kPlotLeft + double(b) * step + 1.0, kPlotTop + kPlotHeight - height, step - 2.0, height,
        counts[b]);
  }
  return bars;
}

/// Shapes of an SVG file.
struct Drawing {
  std::string shapes;
  double height = 0.0;  ///< [px]
};

/// A dot a case at its value; one that would lie on another stands above it.
Drawing draw_dots(const std::vector<NamedValue>& values) {
  constexpr double kRadius = 5.0, kDiameter = 2.0 * kRadius;
  const double low = values.front().second, range = values.back().second - low;
  std::vector<double> last;  // x of the last dot of each row, from the lowest
  std::vector<std::size_t> rows;
  std::vector<double> places;
  for (const NamedValue& one : values) {
    const double share = range > 0.0 ? (one.second - low) / range : 0.5;
    places.push_back(kPlotLeft + kRadius + share * (kPlotWidth - kDiameter));
    std::size_t row = 0;
    while (row < last.size() && places.back() - last[row] < kDiameter) ++row;
    if (row == last.size()) last.push_back(places.back());
    last[row] = places.back();
    rows.push_back(row);
  }
  Drawing strip{"", kDiameter * double(last.size()) + 2.0};
  for (std::size_t v = 0; v < values.size(); ++v)
    strip.shapes += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"><title>{}: {:.4g}</title></circle>",
        places[v], kPlotTop + strip.height - kRadius - kDiameter * double(rows[v]), kRadius,
        escape_html(values[v].first), values[v].second);
  return strip;
}

/// "12 cases, median 3.1, quartiles 2.9, 3.4"; of few cases no quartiles.
std::string spread_words(const std::vector<double>& sorted, bool is_few) {
  const std::string words =
      fmt::format("{} cases, median {:.3g}", sorted.size(), quantile(sorted, 0.5));
  return is_few ? words
                : words + fmt::format(", quartiles {:.3g}, {:.3g}", quantile(sorted, 0.25),
                                      quantile(sorted, 0.75));
}

}  // namespace

const std::vector<SummaryMeasure>& summary_measures() {
  static const std::vector<SummaryMeasure> kMeasures = {
      {"/lesion/mld_mm", "MLD before", "mm", 2},
      {"/lesion/reference_diameter_mm", "Reference", "mm", 2},
      {"/lesion/diameter_stenosis_percent", "Stenosis before", "%", 0},
      {"/lesion/length_mm", "Length", "mm", 2},
      {"/balloon/nominal_diameter_mm", "Balloon", "mm", 2},
      {"/balloon/peak_pressure_atm", "Peak pressure", "atm", 1},
      {"/balloon/peak_diameter_mm", "Balloon at peak", "mm", 2},
      {"/peak/mld_mm", "MLD at peak", "mm", 2},
      {"/result/mld_mm", "MLD after", "mm", 2},
      {"/result/diameter_stenosis_percent", "Stenosis after", "%", 0},
      {"/result/acute_gain_mm", "Acute gain", "mm", 2},
      {"/result/recoil_percent", "Recoil", "%", 0},
      {"/simulation/max_penetration_mm", "Penetration", "mm", 4},
      {"/flow/ffr_before", "Pd/Pa before", "FFR of coronaries", 2},
      {"/flow/ffr_after", "Pd/Pa after", "FFR of coronaries", 2}};
  return kMeasures;
}

json value_at(const SummaryCase& one, const char* pointer) {
  const json::json_pointer place(pointer);
  return one.metrics.is_object() && one.metrics.contains(place) ? one.metrics.at(place) : json();
}

std::string spread_figure(const std::vector<SummaryCase>& cases, const SummaryMeasure& measure) {
  constexpr std::size_t kFewestForBars = 8;
  const std::vector<NamedValue> named = values_of(cases, measure);
  if (named.size() < 2) return {};
  std::vector<double> values;
  for (const NamedValue& one : named) values.push_back(one.second);
  const bool is_few = values.size() < kFewestForBars;
  const Drawing drawing = is_few ? draw_dots(named) : Drawing{draw_bars(values), kPlotHeight};
  const double base = kPlotTop + drawing.height;
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" role=\"img\" "
      "font-family=\"sans-serif\" font-size=\"12\"><title>{2}</title><rect width=\"100%\" "
      "height=\"100%\" fill=\"#fff\"/><text x=\"{3}\" y=\"16\" font-weight=\"600\">{2}</text>"
      "<g fill=\"#36c\">{4}</g><path d=\"M{3} {5}h{6}\" stroke=\"#333\"/><text x=\"{3}\" "
      "y=\"{7}\">{8:.4g}</text><text x=\"{9}\" y=\"{7}\" text-anchor=\"end\">{10:.4g}</text>"
      "<text x=\"{3}\" y=\"{11}\">{12}</text></svg>\n",
      kPlotWidth + 2 * kPlotLeft, base + 40.0,
      fmt::format("{}{}", measure.title, *measure.unit ? fmt::format(" [{}]", measure.unit) : ""),
      kPlotLeft, drawing.shapes, base, kPlotWidth, base + 15.0, values.front(),
      kPlotLeft + kPlotWidth, values.back(), base + 32.0, spread_words(values, is_few));
}

std::string summary_page(const fs::path& folder, const std::vector<SummaryCase>& cases) {
  std::string body = fmt::format(
      "<div class=\"tools\"><label>Words <input id=\"words\" type=\"search\"></label><label>Status "
      "<select id=\"state\">{}</select></label><output id=\"shown\"></output>"
      "<a href=\"sheet.html\">Pictures of all cases</a></div>\n<div "
      "class=\"wide\" role=\"region\" aria-label=\"Table of the cases\" "
      "tabindex=\"0\"><table>{}<tbody>\n",
      status_choices(cases), table_head());
  for (const SummaryCase& one : cases) body += row_of(folder, one);
  body += "</tbody></table></div>\n";
  if (std::any_of(cases.begin(), cases.end(),
                  [](const SummaryCase& one) { return shown_status(one) == "no_lesion"; }))
    body +=
        "<p><small>In italics: no stenosis was found there; what stands in the columns is a trial "
        "balloon's in a healthy vessel, and not in the figures below.</small></p>\n";
  std::string figures;
  for (const SummaryMeasure& measure : summary_measures()) {
    const std::string figure = spread_figure(cases, measure);
    if (!figure.empty()) figures += "<figure>" + figure + "</figure>";
  }
  if (!figures.empty())
    body +=
        "<h2>How the cases with a stenosis and a result are spread</h2><div class=\"figures\">" +
        figures + "</div>\n";
  return page("Cases", body + fmt::format("<script>{}</script>\n", kScript));
}

std::string quality_page(const fs::path& folder, const std::vector<SummaryCase>& cases) {
  const std::array<std::pair<const char*, std::vector<std::string>>, 3> kinds = {{
      {"contour", {"cross_sections.png", "slice_axial.png", "frames_sheet.png"}},
      {"tree", {"tree.png"}},
      {"balloon", {"sequence.png", "contact.png"}},
  }};
  std::string body =
      "<p><a href=\"summary.html\">Table of the cases</a></p><div class=\"sheet\">\n";
  for (const SummaryCase& one : cases) {
    body += fmt::format("<article class=\"{}\"><h2>{} <small class=\"status\">{}</small></h2>{}",
                        escape_html(class_of(one)), name_link(folder, one),
                        escape_html(shown_status(one)),
                        one.reason.empty() ? "" : "<p>" + escape_html(one.reason) + "</p>");
    for (const auto& [what, files] : kinds)
      body += image(picture_of(folder, one.name, files), std::string(what) + " of " + one.name);
    body += "</article>\n";
  }
  return page("Pictures of all cases", body + "</div>\n");
}

}  // namespace angio::pipeline
