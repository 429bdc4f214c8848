#include "pipeline/cli/inflate_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <omp.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "pipeline/config/balloon_file.hpp"
#include "pipeline/stages/reporter.hpp"
#include "simulation/inflate.hpp"
#include "viewer/inflation_plot.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
using simulation::CatalogueBalloon;
using simulation::InflationPoint;
namespace {

constexpr double kPressureStepAtm = 0.5;

/// The balloon to be inflated, and its catalogue entry if it has one.
struct Subject {
  simulation::FreeBalloon balloon;
  std::optional<CatalogueBalloon> entry;
  std::string title;
};

Subject subject_of(const InflateArguments& a) {
  const bool has_measures = a.radius_mm != 0.0 || a.length_mm != 0.0 || a.wall_mm != 0.0 ||
                            !a.material.empty() || a.ends != "hemispheres";
  Subject subject;
  if (!a.balloon.empty()) {
    if (has_measures)
      throw Error(
          ExitCode::usage,
          "--radius, --length, --wall, --material and --ends describe a balloon of your own: leave "
          "them out, or the name " +
              a.balloon);
    subject.entry = find_balloon(balloon_catalogue(a.catalogue), a.balloon);
    subject.balloon = free_balloon(*subject.entry);
    subject.title =
        subject.entry->name + (subject.entry->representative ? " (representative)" : "");
    return subject;
  }
  if (a.radius_mm == 0.0 || a.length_mm == 0.0 || a.wall_mm == 0.0 || a.material.empty())
    throw Error(ExitCode::usage,
                "`angio inflate` needs a balloon's name (--list shows them), or all of --radius, "
                "--length, --wall and --material");
  subject.balloon.radius_mm = a.radius_mm;
  subject.balloon.length_mm = a.length_mm;
  subject.balloon.material.wall_mm = a.wall_mm;
  subject.balloon.material.name = a.material;
  subject.balloon.ends = a.ends == "tube"           ? simulation::BalloonEnds::tube
                         : a.ends == "fixed_length" ? simulation::BalloonEnds::fixed_length
                                                    : simulation::BalloonEnds::hemispheres;
  subject.balloon.validate();
  subject.title = fmt::format("{}, radius {} mm, length {} mm, wall {} mm", a.material, a.radius_mm,
                              a.length_mm, a.wall_mm);
  return subject;
}

/// From empty to rated burst, through every point of the chart.
std::vector<double> default_pressures(const CatalogueBalloon& entry) {
  std::vector<double> pressures;
  const double last = entry.rated_burst_pressure_atm;
  for (int i = 0; i * kPressureStepAtm < last; ++i) pressures.push_back(i * kPressureStepAtm);
  pressures.push_back(last);
  for (const simulation::ChartPoint& point : entry.chart) pressures.push_back(point.pressure_atm);
  std::sort(pressures.begin(), pressures.end());
  pressures.erase(std::unique(pressures.begin(), pressures.end()), pressures.end());
  return pressures;
}

double chart_diameter(const Subject& subject, double pressure_atm) {
  if (!subject.entry || subject.entry->chart.empty())
    return std::numeric_limits<double>::quiet_NaN();
  return chart_diameter_mm(subject.entry->chart, pressure_atm);
}

/// A number, or an empty cell.
std::string cell(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : ""; }

/// A row is empty where the balloon has no such state; the paper's solver never is at rest, and its
/// rows are what it came to.
bool has_values(const InflationPoint& p, const simulation::InflateOptions& options) {
  return p.converged || options.solver == simulation::InflateSolver::paper;
}

std::string inflation_csv(const Subject& subject, const simulation::InflateOptions& options,
                          const std::vector<InflationPoint>& points) {
  std::string text = "pressure_atm,diameter_mm,length_mm,volume_mm3,wall_mm,chart_diameter_mm\n";
  for (std::size_t i = 0; i < points.size(); ++i) {
    const InflationPoint& p = points[i];
    const bool by_pressure = !options.pressures_atm.empty();
    if (!has_values(p, options)) {
      text += by_pressure ? fmt::format("{},,,,,\n", cell(options.pressures_atm[i]))
                          : fmt::format(",,,{},,\n", cell(options.volumes_mm3[i]));
      continue;
    }
    text += fmt::format("{},{},{},{},{},{}\n", cell(p.pressure_atm), cell(p.diameter_mm),
                        cell(p.length_mm), cell(p.volume_mm3), cell(p.wall_mm),
                        cell(chart_diameter(subject, p.pressure_atm)));
  }
  return text;
}

void plot(const fs::path& file, const Subject& subject, const simulation::InflateOptions& options,
          const std::vector<InflationPoint>& points) {
  viewer::InflationPlot content;
  content.title = subject.title;
  for (const InflationPoint& p : points) {
    if (!has_values(p, options)) continue;
    content.pressure_atm.push_back(p.pressure_atm);
    content.diameter_mm.push_back(p.diameter_mm);
  }
  if (content.pressure_atm.size() < 2) return;  // a single state is in the table
  if (subject.entry) {
    for (const simulation::ChartPoint& point : subject.entry->chart) {
      content.chart_pressure_atm.push_back(point.pressure_atm);
      content.chart_diameter_mm.push_back(point.diameter_mm);
    }
    content.nominal_pressure_atm = subject.entry->nominal_pressure_atm;
    content.rated_burst_pressure_atm = subject.entry->rated_burst_pressure_atm;
  }
  viewer::write_inflation_plot(file, content);
}

void warn_of_points(const Subject& subject, const simulation::InflateOptions& options,
                    const std::vector<InflationPoint>& points, Reporter& reporter) {
  if (options.solver == simulation::InflateSolver::paper)
    reporter.warn("inflate",
                  "the seed paper's solver does not converge: its answer depends on the number of "
                  "iterations, and is there for comparison only");
  const bool by_pressure = !options.pressures_atm.empty();
  std::vector<std::string> lost;
  double highest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (has_values(points[i], options))
      highest = std::max(highest, points[i].pressure_atm);
    else
      lost.push_back(by_pressure ? fmt::format("{:g} atm", options.pressures_atm[i])
                                 : fmt::format("{:g} mm3", options.volumes_mm3[i]));
  }
  if (!lost.empty())
    reporter.warn("inflate",
                  fmt::format("no state of rest was found at {} (their rows are empty){}",
                              fmt::join(lost, ", "),
                              by_pressure ? ": the balloon carries less, past its limit point it "
                                            "continues only with --volumes"
                                          : ""));
  if (subject.entry && highest > subject.entry->rated_burst_pressure_atm)
    reporter.warn("inflate", fmt::format("{:g} atm is above the rated burst pressure, {:g} atm",
                                         highest, subject.entry->rated_burst_pressure_atm));
}

int list_balloons(const InflateArguments& a) {
  fmt::print("{:<14} {:>8} {:>8} {:>8} {:>9} {:>9}  {}\n", "name", "diameter", "length", "wall",
             "nominal", "burst", "description");
  for (const CatalogueBalloon& b : balloon_catalogue(a.catalogue))
    fmt::print("{:<14} {:>5.2f} mm {:>5g} mm {:>5g} um {:>5g} atm {:>5g} atm  {}{}\n", b.name,
               b.nominal_diameter_mm, b.length_mm, 1000.0 * b.wall_mm, b.nominal_pressure_atm,
               b.rated_burst_pressure_atm, b.description,
               b.representative ? " (representative)" : "");
  return int(ExitCode::done);
}

}  // namespace

CLI::App& add_inflate_command(CLI::App& app, InflateArguments& a) {
  CLI::App& command =
      *app.add_subcommand("inflate",
                          "a balloon alone, no vessel: its diameter under pressure\n"
                          "writes inflation.csv and inflation.svg");
  command.add_option("BALLOON", a.balloon, "a name of the catalogue");
  command.add_option("-o,--output", a.folder, "folder of the table and the plot")->type_name("DIR");
  command.add_flag("--list", a.list, "show the catalogue and end");
  command.add_option("--catalogue", a.catalogue, "balloons of your own, TOML as balloons.toml")
      ->type_name("FILE");
  command.add_option("--radius", a.radius_mm, "of the mid-surface, unloaded, 0.1 to 50")
      ->type_name("MM");
  command.add_option("--length", a.length_mm, "of the cylindrical part, unloaded, 0.5 to 500")
      ->type_name("MM");
  command.add_option("--wall", a.wall_mm, "thickness before inflation, 0.001 to 1")
      ->type_name("MM");
  command.add_option("--material", a.material, "pa12, pet or polyurethane")->type_name("NAME");
  command
      .add_option("--pressures", a.pressures_atm,
                  "above the outside, 0 to 100; otherwise, of a catalogue's balloon, up to rated "
                  "burst")
      ->type_name("ATM,ATM,...")
      ->delimiter(',');
  command.add_option("--volumes", a.volumes_mm3, "enclosed volumes instead of pressures")
      ->type_name("MM3,...")
      ->delimiter(',');
  command
      .add_option("--ends", a.ends,
                  "hemispheres, or a piece of an endless tube: tube (closed somewhere, free to "
                  "lengthen) or fixed_length")
      ->check(CLI::IsMember({"hemispheres", "tube", "fixed_length"}))
      ->capture_default_str();
  command
      .add_option("--solver", a.solver,
                  "newton (exact), vbd (the simulation's) or paper (the seed paper's, not "
                  "convergent)")
      ->check(CLI::IsMember({"newton", "vbd", "paper"}))
      ->capture_default_str();
  command.add_option("--backend", a.backend, "of vbd: auto, cpu or cuda")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  command.add_option("--around", a.around, "vertices around the balloon, 8, 12, .. 256; 0: 24")
      ->capture_default_str();
  command.add_option("--threads", a.threads, "CPU threads, 1 to 1024; 0: as many as there are")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command.add_flag("--quiet", a.quiet, "warnings and errors only");
  command.add_flag("--json", a.json, "results and events as JSON on standard output");
  return command;
}

int do_inflate(const InflateArguments& a) {
  if (a.list) return list_balloons(a);
  if (a.folder.empty())
    throw Error(ExitCode::usage, "`angio inflate` needs -o DIR. See `angio inflate --help`");
  if (!a.pressures_atm.empty() && !a.volumes_mm3.empty())
    throw Error(ExitCode::usage, "--pressures and --volumes exclude each other: give one of them");
  if (a.threads > 0) omp_set_num_threads(a.threads);
  const Subject subject = subject_of(a);
  simulation::InflateOptions options;
  options.pressures_atm = a.pressures_atm;
  options.volumes_mm3 = a.volumes_mm3;
  options.solver = a.solver == "vbd"     ? simulation::InflateSolver::vbd
                   : a.solver == "paper" ? simulation::InflateSolver::paper
                                         : simulation::InflateSolver::newton;
  options.backend = backend_of(a.backend);
  if (a.around != 0) options.around = a.around;
  if (options.pressures_atm.empty() && options.volumes_mm3.empty()) {
    if (!subject.entry)
      throw Error(ExitCode::usage,
                  "a balloon of your own needs --pressures ATM,... or --volumes MM3,...");
    options.pressures_atm = default_pressures(*subject.entry);
  }
  options.validate();

  Reporter reporter(a.json ? ReportStyle::json
                           : (a.quiet ? ReportStyle::quiet : ReportStyle::automatic));
  reporter.begin_stage("inflate");
  const auto points = simulation::inflate(subject.balloon, options, reporter.progress());
  write_text_atomically(a.folder / "inflation.csv", inflation_csv(subject, options, points));
  plot(a.folder / "inflation.svg", subject, options, points);
  warn_of_points(subject, options, points, reporter);
  reporter.result((a.folder / "inflation.csv").string());
  return int(ExitCode::done);
}

}  // namespace angio::pipeline
