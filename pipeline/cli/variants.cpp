#include "pipeline/cli/variants.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "pipeline/case/stage.hpp"
#include "pipeline/cli/stage_commands.hpp"
#include "pipeline/stages/minimal_case.hpp"
#include "pipeline/stages/require_backend.hpp"
#include "pipeline/stages/run_case.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {}  // namespace

void seed_variant(const fs::path& base, const fs::path& variant) {
  if (fs::exists(variant / "run.json")) return;
  fs::create_directories(variant);
  const auto link = [](const fs::path& from, const fs::path& to) {
    std::error_code error;
    fs::create_hard_link(from, to, error);
    if (error) fs::copy_file(from, to, fs::copy_options::overwrite_existing);
  };
  for (int stage = 0; stage < int(Stage::report); ++stage) {
    const fs::path folder = base / name(Stage(stage));
    if (!fs::exists(folder)) continue;
    fs::create_directories(variant / name(Stage(stage)));
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      const fs::path to = variant / fs::relative(entry.path(), base);
      if (entry.is_directory())
        fs::create_directories(to);
      else
        link(entry.path(), to);
    }
  }
  // run.json last: a variant that has none is begun again.
  for (const char* file : {"case.toml", "metrics.json", "run.json"})
    if (fs::exists(base / file)) write_text_atomically(variant / file, read_text(base / file));
}

const std::vector<VariantMeasure>& variant_measures() {
  static const std::vector<VariantMeasure> kMeasures = {
      {"/lesion/mld_mm", "mld_before_mm", "MLD before [mm]"},
      {"/result/mld_mm", "mld_after_mm", "MLD after [mm]"},
      {"/result/acute_gain_mm", "acute_gain_mm", "acute gain [mm]"},
      {"/result/recoil_percent", "recoil_percent", "recoil [% of the lumen at peak]"},
      {"/result/diameter_stenosis_percent", "residual_stenosis_percent", "residual stenosis [%]"},
      {"/balloon/balloon_to_artery_ratio", "balloon_to_artery_ratio", "balloon-to-artery ratio"},
      {"/wall/over_strength_percent", "over_strength_percent", "wall over its strength [%]"},
      {"/wall/over_strength_mm3", "over_strength_mm3", "wall over its strength [mm³]"},
      {"/flow/ffr_after", "ffr_after", "pressure behind the lesion after / inlet's"},
      {"/balloon/widening_beside_lesion", "widening_beside_lesion",
       "widening of the vessel beside the lesion"}};
  return kMeasures;
}

VariantRow read_variant(const fs::path& folder, const BatchCase& variant) {
  VariantRow row{variant, "failed", "",
                 std::vector<double>(variant_measures().size(), kNotMeasured)};
  const fs::path file = folder / variant.name / "metrics.json";
  const json metrics = fs::exists(file) ? json::parse(read_text(file), nullptr, false) : json();
  if (!metrics.is_object()) return row;
  const auto words = [&](const char* key) {
    return metrics.contains(key) && metrics[key].is_string() ? metrics[key].get<std::string>()
                                                             : std::string();
  };
  if (!words("status").empty()) row.status = words("status");
  row.reason = words("status_reason");
  if (row.status != "done") return row;
  for (std::size_t m = 0; m < row.measures.size(); ++m) {
    const json::json_pointer pointer(variant_measures()[m].pointer);
    if (metrics.contains(pointer) && metrics.at(pointer).is_number())
      row.measures[m] = metrics.at(pointer).get<double>();
  }
  return row;
}

double measure_of(const VariantRow& row, std::string_view column) {
  const auto& measures = variant_measures();
  const auto found = std::find_if(measures.begin(), measures.end(),
                                  [&](const VariantMeasure& m) { return m.column == column; });
  ANGIO_EXPECT(found != measures.end());
  return row.measures[std::size_t(found - measures.begin())];
}

std::vector<viewer::SweepPanel> panels_of(const std::vector<VariantRow>& rows,
                                          const std::vector<double>& x,
                                          const std::vector<std::string>& labels) {
  std::vector<viewer::SweepPanel> panels;
  for (std::size_t m = 0; m < variant_measures().size(); ++m) {
    viewer::SweepPanel& panel = panels.emplace_back();
    panel.measure = variant_measures()[m].title;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      auto curve = std::find_if(panel.curves.begin(), panel.curves.end(),
                                [&](const auto& c) { return c.label == labels[r]; });
      if (curve == panel.curves.end())
        curve = panel.curves.insert(curve, viewer::SweepCurve{labels[r], {}, {}});
      const auto place = std::upper_bound(curve->x.begin(), curve->x.end(), x[r]);
      curve->y.insert(curve->y.begin() + (place - curve->x.begin()), rows[r].measures[m]);
      curve->x.insert(place, x[r]);
    }
  }
  return panels;
}

std::string value_of(const BatchCase& variant, std::size_t setting) {
  const std::string& text = variant.settings[setting];
  return text.substr(text.find('=') + 1);
}

std::string cell_of(double value) { return std::isnan(value) ? "" : fmt::format("{:.4g}", value); }

json measures_json(const VariantRow& row) {
  json measures = json::object();
  for (std::size_t m = 0; m < row.measures.size(); ++m)
    measures[variant_measures()[m].column] =
        std::isnan(row.measures[m]) ? json() : json(row.measures[m]);
  return measures;
}

std::string csv_text(const std::vector<formats::CsvRow>& rows) {
  std::string csv;
  for (const formats::CsvRow& cells : rows) {
    for (std::size_t c = 0; c < cells.size(); ++c)
      csv += (c == 0 ? "" : ",") + formats::csv_cell(cells[c]);
    csv += "\n";
  }
  return csv;
}

std::string aligned_text(const std::vector<formats::CsvRow>& rows) {
  std::vector<std::size_t> width(rows.empty() ? 0 : rows[0].size(), 0);
  for (const formats::CsvRow& cells : rows)
    for (std::size_t c = 0; c < cells.size(); ++c) width[c] = std::max(width[c], cells[c].size());
  std::string text;
  for (const formats::CsvRow& cells : rows) {
    for (std::size_t c = 0; c < cells.size(); ++c)
      text += fmt::format("{}{:>{}}", c == 0 ? "" : "  ", cells[c], width[c]);
    text += "\n";
  }
  return text;
}

void add_variant_options(CLI::App& command, VariantArguments& arguments,
                         const std::string& otherwise) {
  command
      .add_option("-o,--output", arguments.request.folder,
                  "folder of the variants and the table; otherwise " + otherwise)
      ->type_name("DIR");
  command.add_option("-j,--jobs", arguments.request.jobs, "variants at a time, 1 to 256")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command.add_flag("--reports", arguments.reports, "make each variant's report, too");
  command.add_option("--backend", arguments.shared.backend, "where they run: auto, cpu or cuda")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  command
      .add_option("--threads", arguments.shared.threads,
                  "CPU threads of a variant; 0: the computer's, shared out")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  add_output_options(command, arguments.shared);
}

Config base_config(const fs::path& base) {
  const CaseFolder case_folder(base);
  Config config = case_config(case_folder);
  if (is_minimal(case_folder.read_record()))
    throw InputError(fmt::format("the stages' files of {0} were removed (--keep minimal; variants "
                                 "go on from them). Make them again: `angio run INPUT -o {0}`",
                                 base.string()),
                     ExitCode::no_input);
  return config;
}

VariantResults run_variants(VariantArguments& arguments, const Config& config,
                            const std::vector<BatchCase>& variants, const std::string& verb,
                            Reporter& reporter) {
  require_backend(backend_of(arguments.shared.backend));
  for (const BatchCase& variant : variants) {
    Config changed = config;
    for (const std::string& setting : variant.settings) apply_setting(changed, setting);
    changed.validate();
    refuse_other_input(config, changed, verb);
  }
  BatchRequest& request = arguments.request;
  if (request.folder.empty())
    request.folder = fs::absolute(arguments.base).lexically_normal().string() + "-" + verb;
  if (fs::exists(request.folder / "run.json"))
    throw IoError(fmt::format("{} is a case (the variants need a folder of their own). Name "
                              "another -o",
                              request.folder.string()),
                  ExitCode::cannot_create);
  for (const BatchCase& variant : variants)
    seed_variant(arguments.base, request.folder / variant.name);
  const fs::path settings = request.folder / "base.toml";
  write_text_atomically(settings, to_toml(config));
  request.config = config;
  request.program = fs::read_symlink("/proc/self/exe");
  request.threads = arguments.shared.threads;
  request.shared.config_file = settings.string();
  request.shared.backend = arguments.shared.backend;
  request.arguments = {"--quiet"};
  if (!arguments.reports)
    request.arguments.insert(request.arguments.end(), {"--until", "simulation"});
  request.resume = true;  // what is done with these very settings stays
  VariantResults results;
  results.failed = run_batch(request, variants, reporter).failed;
  for (const BatchCase& variant : variants)
    results.rows.push_back(read_variant(request.folder, variant));
  return results;
}

}  // namespace angio::pipeline
