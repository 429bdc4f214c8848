// Random lesions of coronary arteries, dilated by default, against what is published of patients.
//
//     random_lesions make COUNT FOLDER     surfaces, lesions.csv, and manifest.csv for
//     angio batch FOLDER/manifest.csv -o FOLDER/cases -j N
//     random_lesions table FOLDER [--markdown FILE] [--figure FILE.svg]
//
// The distributions below and all of the program's options are fixed beforehand: nothing is fitted
// to recoil. Exit codes: 0 done, 64 usage, 65 a file is not what make and batch have written.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "formats/files.hpp"
#include "testing/result_table.hpp"
#include "viewer/detail/chart.hpp"

namespace angio::benchmarks {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

struct Lesion {
  std::string name, plaque;
  double reference_mm = 0.0;  ///< diameter of the healthy lumen
  double stenosis = 0.0;      ///< of the diameter, before
  double length_mm = 0.0;     ///< from shoulder to shoulder
  double eccentricity = 0.0;  ///< 0: from all sides; 1: the lumen lies at the healthy wall
  double balloon_mm = 0.0;    ///< nominal
  [[nodiscard]] double ratio() const { return balloon_mm / reference_mm; }
};

/// A normal deviate, drawn again until it lies within the range.
double normal_within(std::mt19937_64& random, double mean, double sd, double low, double high) {
  // Box and Muller's formula: std::normal_distribution differs between libraries.
  const auto uniform = [&] { return (double(random() >> 11U) + 0.5) * 0x1p-53; };
  for (;;) {
    const double x = mean + sd * std::sqrt(-2.0 * std::log(uniform())) *
                                std::cos(2.0 * std::numbers::pi * uniform());
    if (x >= low && x <= high) return x;
  }
}

/// Reference diameter 3.01 +- 0.46 mm, stenosis 64 +- 10 % and length 7.0 +- 2.6 mm: patients of
/// Serruys et al., N. Engl. J. Med. 331 (1994) 489. Angiographic calcium in 38 %: Mintz et al.,
/// Circulation 91 (1995) 1959; of the others half are fibrous, a quarter hypocellular, a quarter
/// lipid (a choice). Eccentricity uniform: about half of the lesions are eccentric (Mintz et al.,
/// Circulation 93 (1996) 924). Balloon to artery 1.0 +- 0.15 (0.9 to 1.2 in the studies compared
/// with), then the nearest quarter of a millimetre, as balloons are sold.
Lesion draw(int number) {
  std::mt19937_64 random(0x1e510000ULL + std::uint64_t(number));
  const auto uniform = [&] { return (double(random() >> 11U) + 0.5) * 0x1p-53; };
  Lesion lesion;
  lesion.name = formatted("lesion_%03d", number);
  lesion.reference_mm = normal_within(random, 3.01, 0.46, 2.2, 4.0);
  lesion.stenosis = normal_within(random, 0.64, 0.10, 0.40, 0.85);
  lesion.length_mm = normal_within(random, 7.0, 2.6, 3.0, 14.0);
  lesion.eccentricity = uniform();
  const double kind = uniform();
  lesion.plaque = kind < 0.38    ? "calcified"
                  : kind < 0.69  ? "fibrous"
                  : kind < 0.845 ? "hypocellular"
                                 : "lipid";
  const double ratio = normal_within(random, 1.0, 0.15, 0.75, 1.35);
  lesion.balloon_mm = std::round(4.0 * ratio * lesion.reference_mm) / 4.0;
  return lesion;
}

/// A straight open tube with the lesion in its middle: circles, narrowed along a cosine and put
/// aside.
TriangleMesh surface_of(const Lesion& lesion) {
  constexpr int kAround = 64;
  constexpr double kHealthy = 12.0, kStep = 0.12;  // mm: on each side; between rings
  const double length = lesion.length_mm + 2.0 * kHealthy, radius = 0.5 * lesion.reference_mm;
  const int rings = int(std::ceil(length / kStep)) + 1;
  TriangleMesh mesh;
  for (int k = 0; k < rings; ++k) {
    const double z = length * k / (rings - 1), x = (z - 0.5 * length) / lesion.length_mm;
    const double depth =
        std::abs(x) < 0.5 ? 0.5 * (1.0 + std::cos(2.0 * std::numbers::pi * x)) : 0.0;
    const double r = radius * (1.0 - lesion.stenosis * depth);
    const double aside = lesion.eccentricity * (radius - r);
    for (int i = 0; i < kAround; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kAround;
      mesh.vertices.push_back({aside + r * std::cos(angle), r * std::sin(angle), z});
    }
  }
  for (int k = 0; k + 1 < rings; ++k)
    for (int i = 0; i < kAround; ++i) {
      const int a = k * kAround + i, b = k * kAround + (i + 1) % kAround;
      mesh.triangles.push_back({a, b, b + kAround});
      mesh.triangles.push_back({a, b + kAround, a + kAround});
    }
  return mesh;
}

void make(int count, const fs::path& folder) {
  fs::create_directories(folder);
  std::string manifest =
      "case,input,balloon.nominal_diameter_mm,wall.plaque,simulation.guard,volume.fill\n";
  std::string list = "case,reference_mm,stenosis,length_mm,eccentricity,plaque,balloon_mm\n";
  for (int number = 1; number <= count; ++number) {
    const Lesion l = draw(number);
    formats::write_surface(folder / (l.name + ".vtp"), {surface_of(l), {}, {}});
    manifest += formatted("%s,%s.vtp,%.2f,%s,false,false\n", l.name.c_str(), l.name.c_str(),
                          l.balloon_mm, l.plaque.c_str());
    list += formatted("%s,%.17g,%.17g,%.17g,%.17g,%s,%.2f\n", l.name.c_str(), l.reference_mm,
                      l.stenosis, l.length_mm, l.eccentricity, l.plaque.c_str(), l.balloon_mm);
  }
  write_text_atomically(folder / "manifest.csv", manifest);
  write_text_atomically(folder / "lesions.csv", list);
}

/// What a case has come to; NaN where it has not.
struct Row {
  Lesion lesion;
  std::string status;
  double before = NAN, peak = NAN, after = NAN, recoil = NAN, residual = NAN, below_chart = NAN,
         over_strength = NAN, penetration = NAN;
  [[nodiscard]] double gain() const { return after - before; }
};

std::vector<Lesion> read_lesions(const fs::path& file) {
  std::vector<Lesion> lesions;
  const auto rows = formats::parse_csv(read_text(file));
  for (std::size_t r = 1; r < rows.size(); ++r) {
    if (rows[r].size() != 7) throw InputError(file.filename().string() + " was not made by make");
    const auto number = [&](std::size_t column) { return std::atof(rows[r][column].c_str()); };
    Lesion l;
    l.name = rows[r][0];
    l.reference_mm = number(1);
    l.stenosis = number(2);
    l.length_mm = number(3);
    l.eccentricity = number(4);
    l.plaque = rows[r][5];
    l.balloon_mm = number(6);
    lesions.push_back(l);
  }
  return lesions;
}

Row read_case(const Lesion& lesion, const fs::path& folder) {
  Row row;
  row.lesion = lesion;
  const fs::path file = folder / lesion.name / "metrics.json";
  if (!fs::exists(file)) {
    row.status = "not run";
    return row;
  }
  const json metrics = json::parse(read_text(file));
  row.status = metrics.at("status").is_string() ? metrics["status"].get<std::string>() : "not run";
  const auto number = [&](const char* pointer) {
    const json::json_pointer at(pointer);
    return metrics.contains(at) && metrics.at(at).is_number() ? metrics.at(at).get<double>() : NAN;
  };
  row.before = number("/lesion/mld_mm");
  row.peak = number("/peak/mld_mm");
  row.after = number("/result/mld_mm");
  row.recoil = number("/result/recoil_mm");
  row.below_chart = number("/balloon/below_chart_mm");
  row.over_strength = number("/wall/over_strength_percent");
  row.penetration = number("/simulation/max_penetration_mm");
  row.residual = 100.0 * (1.0 - row.after / lesion.reference_mm);
  return row;
}

using Measure = std::function<double(const Row&)>;
using Rows = std::vector<const Row*>;

struct Moments {
  std::size_t count = 0;
  double mean = NAN, sd = NAN;
};

Moments moments(const Rows& rows, const Measure& of) {
  Moments m;
  double sum = 0.0, squares = 0.0;
  for (const Row* row : rows) {
    const double x = of(*row);
    if (std::isnan(x)) continue;
    ++m.count;
    sum += x;
    squares += x * x;
  }
  if (m.count == 0) return m;
  m.mean = sum / double(m.count);
  if (m.count > 1) m.sd = std::sqrt(std::max(0.0, squares - sum * m.mean) / double(m.count - 1));
  return m;
}

double correlation(const Rows& rows, const Measure& x, const Measure& y) {
  const Moments mx = moments(rows, x), my = moments(rows, y);
  double sum = 0.0;
  for (const Row* row : rows) sum += (x(*row) - mx.mean) * (y(*row) - my.mean);
  return sum / (double(mx.count - 1) * mx.sd * my.sd);
}

std::string spread(const Moments& m, const char* format = "%.2f +- %.2f") {
  return m.count == 0
             ? ""
             : formatted(format, m.mean, m.sd);  // NOLINT(clang-diagnostic-format-nonliteral)
}

Rows those(const Rows& rows, const std::function<bool(const Row&)>& wanted) {
  Rows found;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(found),
               [&](const Row* row) { return wanted(*row); });
  return found;
}

const Measure kRecoilMm = [](const Row& r) { return r.recoil; };
const Measure kRecoilOfBalloon = [](const Row& r) { return 100.0 * r.recoil / r.peak; };
/// Rozenman's and Rensing's: of the gain that the balloon had while it was full.
const Measure kRecoilOfGain = [](const Row& r) { return 100.0 * r.recoil / (r.peak - r.before); };
const Measure kAreaLost = [](const Row& r) {
  return 100.0 * (1.0 - r.after * r.after / (r.peak * r.peak));
};
const Measure kResidual = [](const Row& r) { return r.residual; };
const Measure kRatio = [](const Row& r) { return r.lesion.ratio(); };
const Measure kEccentricity = [](const Row& r) { return r.lesion.eccentricity; };
const Measure kOverStrength = [](const Row& r) { return r.over_strength; };

void add_comparison(const Rows& all, ResultTable& results) {
  const Rows tight = those(all, [](const Row& r) { return r.lesion.ratio() <= 1.0; });
  const Rows wide = those(all, [](const Row& r) { return r.lesion.ratio() > 1.0; });
  const Rows round = those(all, [](const Row& r) { return r.lesion.eccentricity < 0.5; });
  const Rows aside = those(all, [](const Row& r) { return r.lesion.eccentricity >= 0.5; });
  results.section("Beside what is published");
  results.columns({"measure", "lesions", "here", "published", "source"});
  const auto row = [&](const char* what, const Rows& rows, const Measure& of, const char* published,
                       const char* source) {
    const Moments m = moments(rows, of);
    results.row({what, std::to_string(m.count), spread(m), published, source});
  };
  row("recoil, % of the full balloon's diameter", all, kRecoilOfBalloon, "27.9; 34.3 +- 20.4",
      "PMID 1486573; PMID 8731316");
  row("recoil, % of the gain at the peak", all, kRecoilOfGain, "23", "Rozenman, 696 lesions");
  row("recoil, mm", all, kRecoilMm, "0.93 +- 0.43; 0.42 +- 0.64", "Hanet; Rozenman");
  row("area lost, %", all, kAreaLost, "46", "Rensing 1990");
  row("recoil, ratio to 1, mm", tight, kRecoilMm, "0.71; 0.90", "Hanet; PMID 8731316");
  row("recoil, ratio over 1, mm", wide, kRecoilMm, "1.20; 1.20", "Hanet; PMID 8731316");
  row("recoil, concentric (under 0.5), mm", round, kRecoilMm, "0.70", "Hanet");
  row("recoil, eccentric, mm", aside, kRecoilMm, "1.13", "Hanet");
  row("residual stenosis, %", all, kResidual, "32; 33 +- 8", "STRESS; Serruys 1994");
  row(
      "gain, mm", all, [](const Row& r) { return r.gain(); }, "1.26 (0.65 to 1.91)",
      "PMID 8731316");
  row(
      "balloon below its chart, mm", all, [](const Row& r) { return r.below_chart; },
      "0.65 +- 0.27 (stents)", "Aziz 2007");
  results.paragraph(formatted(
      "Recoil [mm] rises with the ratio with r = %.2f (published 0.49, Rozenman), with the "
      "eccentricity with r = %.2f.",
      correlation(all, kRatio, kRecoilMm), correlation(all, kEccentricity, kRecoilMm)));
}

void add_kinds(const Rows& all, ResultTable& results) {
  results.section("By plaque");
  results.columns({"plaque", "lesions", "recoil mm", "recoil % of the balloon",
                   "residual stenosis %", "balloon below its chart mm",
                   "wall over its strength %"});
  for (const char* kind : {"fibrous", "hypocellular", "calcified", "lipid"}) {
    const Rows rows = those(all, [&](const Row& r) { return r.lesion.plaque == kind; });
    results.row({kind, std::to_string(rows.size()), spread(moments(rows, kRecoilMm)),
                 spread(moments(rows, kRecoilOfBalloon)), spread(moments(rows, kResidual)),
                 spread(moments(rows, [](const Row& r) { return r.below_chart; })),
                 spread(moments(rows, kOverStrength))});
  }
}

constexpr double kRatioBins[] = {0.7, 0.85, 0.95, 1.05, 1.15, 1.25, 1.45};

void add_ratios(const Rows& all, ResultTable& results) {
  results.section("By the ratio of balloon to artery");
  results.columns({"ratio", "lesions", "recoil mm", "recoil % of the balloon",
                   "residual stenosis %", "wall over its strength %"});
  for (std::size_t b = 0; b + 1 < std::size(kRatioBins); ++b) {
    const Rows rows = those(all, [&](const Row& r) {
      return r.lesion.ratio() >= kRatioBins[b] && r.lesion.ratio() < kRatioBins[b + 1];
    });
    results.row({formatted("%.2f to %.2f", kRatioBins[b], kRatioBins[b + 1]),
                 std::to_string(rows.size()), spread(moments(rows, kRecoilMm)),
                 spread(moments(rows, kRecoilOfBalloon)), spread(moments(rows, kResidual)),
                 spread(moments(rows, kOverStrength), "%.1f +- %.1f")});
  }
}

void write_figure(const Rows& all, const fs::path& file) {
  using viewer::detail::Chart;
  using viewer::detail::ChartSeries;
  std::vector<Chart> charts;
  const auto add = [&](const char* title, const char* x_label, const char* y_label,
                       const Measure& x, const Measure& y,
                       const std::vector<viewer::detail::ChartLevel>& levels) {
    Chart chart;
    chart.title = title;
    chart.x_label = x_label;
    chart.y_label = y_label;
    ChartSeries points{"a lesion", {}, {}, 1, false};
    for (const Row* row : all) {  // a short stroke each
      if (std::isnan(y(*row))) continue;
      const double at = x(*row);
      points.x.insert(points.x.end(), {at - 0.002, at + 0.002, NAN});
      points.y.insert(points.y.end(), {y(*row), y(*row), NAN});
    }
    chart.series = {points};
    chart.levels = levels;
    charts.push_back(chart);
  };
  add("Recoil and the balloon's size", "balloon to artery", "recoil [mm]", kRatio, kRecoilMm,
      {{0.71, "ratio to 1 (Hanet)"}, {1.20, "ratio over 1 (Hanet)"}});
  add("Recoil and eccentricity", "eccentricity", "recoil [mm]", kEccentricity, kRecoilMm,
      {{0.70, "concentric (Hanet)"}, {1.13, "eccentric (Hanet)"}});
  add("Residual stenosis", "balloon to artery", "residual stenosis [%]", kRatio, kResidual,
      {{32.0, "STRESS"}});
  add("Wall over its strength", "balloon to artery", "share of the wall [%]", kRatio, kOverStrength,
      {});
  write_text_atomically(file, viewer::detail::svg_file(charts));
}

void table(const fs::path& folder, const std::string& figure, ResultTable& results) {
  std::vector<Row> rows;
  for (const Lesion& lesion : read_lesions(folder / "lesions.csv"))
    rows.push_back(read_case(lesion, folder / "cases"));
  Rows all;
  std::size_t not_run = 0, crossed = 0;
  for (const Row& row : rows) {
    if (row.status == "not run") ++not_run;
    if (row.penetration > 0.0) ++crossed;
    if (!std::isnan(row.recoil)) all.push_back(&row);
  }
  results.paragraph(formatted(
      "%zu random lesions (the distributions, with sources, stand at draw() in the program), "
      "balloons at their nominal pressure, every option by default but the second run. %zu gave "
      "a result, %zu failed, %zu were not run; balloon and wall crossed in %zu.",
      rows.size(), all.size(), rows.size() - all.size() - not_run, not_run, crossed));
  if (all.size() < 3) return;
  add_comparison(all, results);
  add_ratios(all, results);
  add_kinds(all, results);
  if (!figure.empty()) write_figure(all, figure);
}

int run(int argc, char** argv) {
  ResultTable results("Random lesions against patients", argc, argv);
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() == 3 && words[0] == "make") {
    make(std::atoi(words[1].c_str()), words[2]);
    return 0;
  }
  const bool drawn = words.size() == 4 && words[2] == "--figure";
  if (words.empty() || words[0] != "table" || (words.size() != 2 && !drawn)) {
    std::cerr << "usage: random_lesions make COUNT FOLDER | table FOLDER [--figure FILE.svg] "
                 "[--markdown FILE]\n";
    return int(ExitCode::usage);
  }
  table(words[1], drawn ? words[3] : "", results);
  results.write();
  return 0;
}

}  // namespace
}  // namespace angio::benchmarks

int main(int argument_count, char** arguments) {
  return angio::benchmarks::run_benchmark("random_lesions", argument_count, arguments,
                                          angio::benchmarks::run);
}
