// Is a case that was run again with another setting the case that it would have been from the
// start?
//
//     resume [--until STAGE] [--back] [--only KEY-PREFIX]... [--markdown FILE]
//
// For every setting of the table: a small case is run as it is, then with another value of the
// setting in the same folder; beside it a new case with that value from the start. All files of
// both must be the same, byte for byte, but for times and memory in run.json and metrics.json. A
// value that a stage refuses must be refused alike, and leave no number of a result. --back also
// goes back to the former value, which must give the former case. A row for each setting on
// standard output. Every run is a process of its own. Exit codes: 0 no difference, 1 a difference,
// 64 usage.

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/child_process.hpp"
#include "core/error.hpp"
#include "datasets/phantom.hpp"
#include "formats/files.hpp"
#include "pipeline/experiments/workflow.hpp"
#include "pipeline/stages/run_case.hpp"
#include "testing/pipeline/case_content.hpp"
#include "testing/pipeline/other_value.hpp"
#include "testing/result_table.hpp"
#include "testing/temporary_folder.hpp"

namespace {

namespace fs = std::filesystem;
using angio::pipeline::Config;
using angio::pipeline::Stage;
using nlohmann::json;

struct Arguments {
  Stage until = Stage::simulation;
  bool goes_back = false;
  std::vector<std::string> only;
};

/// A small case to begin with.
struct Base {
  std::string name;
  std::string input;
  std::vector<std::string> presets;
  std::vector<std::string> settings;

  [[nodiscard]] Config config() const {
    Config config;
    for (const std::string& preset : presets) apply_preset(config, preset);
    for (const std::string& setting : settings) apply_setting(config, setting);
    config.simulation.backend = angio::simulation::Backend::cpu;
    return config;
  }
};

std::vector<std::string> with(std::vector<std::string> settings,
                              const std::vector<std::string>& more) {
  settings.insert(settings.end(), more.begin(), more.end());
  return settings;
}

std::map<std::string, Base> make_bases(const fs::path& folder) {
  const std::string volume = "phantom:unilateral,length=10,stenosis=50,spacing=0.3,noise=0",
                    straight = "phantom:straight,length=14,spacing=0.3,noise=0";
  const fs::path surface = folder / "lumen.stl";
  const std::vector<std::string> quick = {"balloon.length_mm=3",
                                          "balloon.ring_count=6",
                                          "balloon.ring_vertex_count=8",
                                          "balloon.guidewire_node_count=6",
                                          "mesh.edges_per_circumference=8",
                                          "simulation.sweeps=20",
                                          "simulation.write_every=2",
                                          "inflation.inflate_s=0.1",
                                          "inflation.hold_s=0.05",
                                          "inflation.deflate_s=0.1",
                                          "inflation.rest_s=0"};
  const std::vector<Base> list = {
      {"volume", volume, {"draft"}, quick},
      {"layered", volume, {"draft"}, with(quick, {"wall.model=layered"})},
      {"rod", volume, {"draft"}, with(quick, {"guidewire.model=rod", "balloon.folds=0"})},
      {"paper", volume, {"draft"}, with(quick, {"simulation.contact_model=paper"})},
      {"inflator", volume, {"draft"}, with(quick, {"inflation.control=volume"})},
      {"narrowed", straight, {"draft"}, with(quick, {"lesion.narrow_percent=50"})},
      {"surface", surface.string(), {"draft"}, quick},
      {"cloth", "phantom:cloth", {"paper-cloth"}, {"cloth.cells=4", "cloth.steps=2"}}};
  std::map<std::string, Base> bases;
  for (const Base& base : list) bases[base.name] = base;
  return bases;
}

void write_surface_input(const fs::path& file) {
  angio::datasets::PhantomOptions phantom;
  phantom.name = "unilateral";
  phantom.length_mm = 12.0;
  phantom.stenosis_percent = 50.0;
  angio::formats::write_surface(file,
                                {angio::datasets::make_phantom_surface(phantom).surface, {}, {}});
}

/// The cases in which a setting counts.
std::vector<std::string> bases_for(const std::string& key) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> rules = {
      {"cloth.", {"cloth"}},
      {"guidewire.", {"rod"}},
      {"balloon.shaft_diameter_mm", {"rod", "volume"}},
      {"wall.model", {"volume", "layered"}},
      {"wall.thickness_ratio", {"volume", "layered"}},
      {"wall.layer_fractions", {"layered"}},
      {"wall.elements_per_layer", {"layered"}},
      {"wall.plaque", {"layered"}},
      {"wall.axial_stretch", {"layered"}},
      {"simulation.paper_volume", {"paper"}},
      {"simulation.gas_model", {"inflator"}},
      {"inflation.peak_volume_mm3", {"inflator"}},
      {"lesion.", {"volume", "narrowed"}},
      {"centerline.inlet_end", {"surface"}},
      {"input.unit", {"surface"}},
      {"mesh.keep", {"surface"}}};
  for (const auto& [prefix, names] : rules)
    if (key.starts_with(prefix)) return names;
  return {"volume"};
}

/// Values that mean something in these cases; for the other settings any other value does.
std::string value_for(const Config& config, const std::string& key) {
  const std::map<std::string, std::string> values = {
      {"segmentation.seeds_lps_mm", "[[0.0, 0.0, 0.0]]"},
      {"centerline.inlet_lps_mm", "[0.0, 0.0, 5.0]"},
      {"centerline.outlets_lps_mm", "[[0.0, 0.0, 4.0]]"},
      {"lesion.centerline", "0"},
      {"lesion.abscissa_mm", "6.0"},
      {"cloth.cells", "6"},
      {"flow.diameter_error_mm", "0.25"},
      {"inflation.control", "\"pressure\""}};
  const auto found = values.find(key);
  return found == values.end() ? angio::test::other_value(config, key) : found->second;
}

/// Does something in a process of its own, as a user's next command is.
/// @return why it was refused, or the signal that ended it; empty: it was done
std::string in_a_process(const std::function<void()>& act) {
  angio::ChildLimits wide{std::size_t(1) << 40, 86400, 86400};
  wide.confinement = angio::Confinement::none;
  const angio::ChildResult result = angio::run_guarded(
      wide, [&](angio::ChildOutput&) { act(); }, [](angio::ChildInput&) {});
  if (result.signal != 0) return fmt::format("ended by signal {}", result.signal);
  if (result.end == angio::ChildEnd::refused) return result.message;
  return result.end == angio::ChildEnd::done ? "" : "broke down";
}

std::string run(const Base& base, const Config& config, const fs::path& folder, Stage until) {
  return in_a_process([&] {
    angio::pipeline::RunRequest request;
    request.input = base.input;
    request.case_folder = folder;
    request.config = config;
    request.until = until;
    angio::pipeline::Reporter reporter(angio::pipeline::ReportStyle::quiet);
    run_case(angio::pipeline::workflow_of(config), request, reporter);
  });
}

struct Difference {
  std::size_t files = 0;
  std::vector<std::string> which;
};

Difference compare(const fs::path& a, const fs::path& b) {
  const auto of_a = angio::test::case_content(a), of_b = angio::test::case_content(b);
  Difference difference{of_a.size(), {}};
  for (const auto& [file, text] : of_a)
    if (!of_b.contains(file) || of_b.at(file) != text) difference.which.push_back(file);
  for (const auto& entry : of_b)
    if (!of_a.contains(entry.first)) difference.which.push_back(entry.first);
  return difference;
}

/// What is wrong with a case that was refused with these words when it was run again.
std::vector<std::string> compare_refusals(const fs::path& resumed, const std::string& words,
                                          const std::string& words_fresh) {
  if (words != words_fresh) return {"refused otherwise: " + words + " / " + words_fresh};
  const json metrics = json::parse(angio::read_text(resumed / "metrics.json"));
  if (metrics.at("status") != "failed" && metrics.at("status") != "stale")
    return {"metrics.json: the case is said to be well"};
  if (!metrics.at("result").at("mld_mm").is_null()) return {"metrics.json: there is a result"};
  return {};
}

/// Which stages of a case have been run again since it was copied.
std::string stages_run(const fs::path& before, const fs::path& after) {
  const json old_run = json::parse(angio::read_text(before / "run.json")),
             new_run = json::parse(angio::read_text(after / "run.json"));
  std::string stages;
  for (const auto& [stage, record] : new_run.at("stages").items())
    if (record.at("seconds") != old_run.at("stages").at(stage).at("seconds"))
      stages += (stages.empty() ? "" : " ") + stage;
  return stages.empty() ? "-" : stages;
}

constexpr int kMostFresh = 8;

/// One setting in one case. @return how many files differ
std::size_t try_setting(const Base& base, const std::string& key, const fs::path& folder,
                        const Arguments& arguments, angio::benchmarks::ResultTable& results) {
  const auto start = std::chrono::steady_clock::now();
  Config config = base.config();
  const fs::path first = folder / base.name, resumed = folder / "resumed", fresh = folder / "fresh";
  if (!fs::exists(first)) run(base, config, first, arguments.until);
  for (const fs::path& used : {resumed, fresh}) fs::remove_all(used);
  fs::copy(first, resumed, fs::copy_options::recursive);
  const std::string value = value_for(config, key);
  apply_setting(config, key + "=" + value);
  const std::string words = run(base, config, resumed, arguments.until),
                    words_fresh = run(base, config, fresh, arguments.until);
  Difference difference;
  bool is_unsteady = false;
  if (words.empty() && words_fresh.empty()) {
    difference = compare(fresh, resumed);
    // TetGen does not give the same mesh each time: then the case must be one of the fresh ones.
    for (int again = 0; again < kMostFresh && !difference.which.empty(); ++again) {
      is_unsteady = true;
      fs::remove_all(fresh);
      run(base, config, fresh, arguments.until);
      difference = compare(fresh, resumed);
    }
  } else {
    difference.which = compare_refusals(resumed, words, words_fresh);
  }
  const std::string again = stages_run(first, resumed);
  if (arguments.goes_back) {
    run(base, base.config(), resumed, arguments.until);
    for (const std::string& file : compare(first, resumed).which)
      difference.which.push_back("back: " + file);
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  results.row({key, base.name, value, again,
               words.empty()                ? fmt::format("{} files", difference.files)
               : words.starts_with("ended") ? words
                                            : "refused alike",
               !difference.which.empty() ? "DIFFERS"
               : is_unsteady             ? "same as another fresh one (fresh ones differ)"
                                         : "same",
               fmt::format("{:.1f}", seconds)});
  for (const std::string& file : difference.which) fmt::print(stderr, "    {}\n", file);
  return difference.which.size();
}

bool is_asked_for(const Arguments& arguments, const std::string& key) {
  bool is_asked = arguments.only.empty();
  for (const std::string& prefix : arguments.only) is_asked = is_asked || key.starts_with(prefix);
  return is_asked;
}

/// @return false if they make no sense
bool parse(int argc, char** argv, Arguments& arguments) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--back")
      arguments.goes_back = true;
    else if (word == "--until" && i + 1 < argc)
      arguments.until = angio::pipeline::parse_stage(argv[++i]);
    else if (word == "--only" && i + 1 < argc)
      arguments.only.emplace_back(argv[++i]);
    else
      return false;
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) try {
  constexpr int kUsage = 64;
  angio::benchmarks::ResultTable results("Cases that went on against cases begun anew", argc, argv);
  results.columns({"setting", "case", "value", "stages run again", "compared", "result", "s"});
  Arguments arguments;
  if (!parse(argc, argv, arguments)) {
    fmt::print(stderr,
               "usage: resume [--until STAGE] [--back] [--only KEY-PREFIX]... [--markdown FILE]\n");
    return kUsage;
  }
  const angio::test::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  const std::map<std::string, Base> bases = make_bases(folder);
  in_a_process([&] { write_surface_input(bases.at("surface").input); });
  Config config;
  std::size_t settings_tried = 0, rows = 0, differences = 0;
  for (const angio::pipeline::Setting& setting : settings(config)) {
    if (!is_asked_for(arguments, setting.key)) continue;
    ++settings_tried;
    for (const std::string& base : bases_for(setting.key)) {
      differences += try_setting(bases.at(base), setting.key, folder, arguments, results);
      ++rows;
    }
  }
  results.paragraph(
      fmt::format("{} settings, {} rows, {} differences.", settings_tried, rows, differences));
  results.write();
  return differences == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
} catch (const std::exception& error) {
  fmt::print(stderr, "resume: {}\n", error.what());
  return EXIT_FAILURE;
}
