// What a finer mesh changes of the numbers that a case tells.
//
//     refinement_table CASE... [--markdown FILE]
//
// CASE is a folder that `angio run` has made and whose name ends in -EDGES, the edges around a
// vessel (mesh.edges_per_circumference), as those of refinement.sh do. Every number of metrics.json
// that is measured on the simulation is in the tables: of the lesion, the balloon, the peak, the
// result, the flow and the wall; not those that no mesh touches (inputs, and what the image says).
//
// The difference is in the number's own unit where that is a percentage (points) or an
// eccentricity, else in per cent of the larger of the two. Exit codes: 0 done, 64 usage, 65 a
// folder is no case.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "testing/result_table.hpp"

namespace angio::benchmarks {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kGroups[] = {"lesion", "balloon", "peak", "result", "flow", "wall"};
constexpr int kDefault = 16;  // edges around

/// The numbers of a case by their path in metrics.json.
using Numbers = std::map<std::string, double>;

void add_numbers(const std::string& path, const json& node, Numbers& numbers) {
  if (node.is_object())
    for (const auto& [key, value] : node.items()) add_numbers(path + "." + key, value, numbers);
  else if (node.is_number() && !path.ends_with(".wedges"))
    numbers[path] = node.get<double>();
}

/// By vessel, then by edges around.
using Cases = std::map<std::string, std::map<int, Numbers>>;

void read_case(const fs::path& given, Cases& cases) {
  const fs::path folder = fs::absolute(given / ".").parent_path();
  const std::string name = folder.filename().string();
  const std::size_t dash = name.rfind('-');
  const int edges = dash == std::string::npos ? 0 : std::atoi(name.c_str() + dash + 1);
  if (edges <= 0) throw InputError(name + " does not end in -EDGES, as refinement.sh names cases");
  if (!fs::exists(folder / "metrics.json"))
    throw InputError(name + " has no metrics.json. Name folders that angio run has made");
  const json metrics = json::parse(read_text(folder / "metrics.json"));
  Numbers& numbers = cases[name.substr(0, dash)][edges];
  for (const char* group : kGroups)
    if (metrics.contains(group)) add_numbers(group, metrics[group], numbers);
}

bool is_percentage(const std::string& path) { return path.find("percent") != std::string::npos; }
/// A number between 0 and 1, near 0 as a rule.
bool is_share(const std::string& path) { return path.find("eccentricity") != std::string::npos; }

/// From one number to another; NaN where one is missing.
double change(const std::string& path, const std::map<int, Numbers>& meshes, int from, int to) {
  const auto value = [&](int edges) {
    const auto mesh = meshes.find(edges);
    if (mesh == meshes.end()) return double(NAN);
    const auto number = mesh->second.find(path);
    return number == mesh->second.end() ? double(NAN) : number->second;
  };
  const double a = value(from), b = value(to);
  if (is_percentage(path) || is_share(path) || a == b) return b - a;
  return 100.0 * (b - a) / std::max(std::abs(a), std::abs(b));
}

std::string shown(const std::string& path, double difference) {
  if (std::isnan(difference)) return "";
  if (is_share(path)) return formatted("%+.3f", difference);
  return formatted("%+.2f ", difference) + (is_percentage(path) ? "points" : "%");
}

/// The paths of all numbers that some mesh changes.
std::vector<std::string> moving_numbers(const std::map<int, Numbers>& meshes) {
  std::vector<std::string> moving;
  for (const auto& [path, first] : meshes.begin()->second)
    if (std::any_of(meshes.begin(), meshes.end(), [&, &path = path, &first = first](const auto& m) {
          const auto at = m.second.find(path);
          return at == m.second.end() || at->second != first;
        }))
      moving.push_back(path);
  return moving;
}

void add_case(const std::string& name, const std::map<int, Numbers>& meshes, ResultTable& results) {
  results.section(name);
  std::vector<std::string> header{"number"};
  const int finest = meshes.rbegin()->first, finer = std::prev(std::prev(meshes.end()))->first;
  for (const auto& [edges, numbers] : meshes)
    header.push_back(std::to_string(edges) + (edges == kDefault ? " (default)" : ""));
  header.push_back(formatted("%d to %d", finer, finest));
  header.push_back(formatted("%d to %d", kDefault, finest));
  results.columns(header);
  for (const std::string& path : moving_numbers(meshes)) {
    std::vector<std::string> cells{'`' + path + '`'};
    for (const auto& [edges, numbers] : meshes) {
      const auto at = numbers.find(path);
      cells.push_back(at == numbers.end() ? "" : formatted("%.4g", at->second));
    }
    cells.push_back(shown(path, change(path, meshes, finer, finest)));
    cells.push_back(shown(path, change(path, meshes, kDefault, finest)));
    results.row(cells);
  }
}

/// The greatest change of each number over the cases, the greatest first.
void add_summary(const Cases& cases, ResultTable& results) {
  struct Worst {
    std::string path, finer_in, default_in;
    double finer = 0.0, from_default = 0.0;
  };
  std::map<std::string, Worst> worst;
  for (const auto& [name, meshes] : cases) {
    const int finest = meshes.rbegin()->first, finer = std::prev(std::prev(meshes.end()))->first;
    for (const std::string& path : moving_numbers(meshes)) {
      Worst& w = worst[path];
      w.path = path;
      const double last = change(path, meshes, finer, finest),
                   all = change(path, meshes, kDefault, finest);
      if (std::abs(last) > std::abs(w.finer)) w.finer = last, w.finer_in = name;
      if (std::abs(all) > std::abs(w.from_default)) w.from_default = all, w.default_in = name;
    }
  }
  std::vector<Worst> order;
  for (const auto& [path, w] : worst) order.push_back(w);
  std::stable_sort(order.begin(), order.end(), [](const Worst& a, const Worst& b) {
    return std::abs(a.from_default) > std::abs(b.from_default);
  });
  results.section("Every number, by the most that a finer mesh changes it");
  results.columns({"number", "from the default to the finest", "in", "the last refinement", "in"});
  for (const Worst& w : order)
    results.row({'`' + w.path + '`', shown(w.path, w.from_default), w.default_in,
                 shown(w.path, w.finer), w.finer_in});
}

int run(int argc, char** argv) {
  ResultTable results("Every number of a case under refinement", argc, argv);
  Cases cases;
  for (int i = 1; i < argc; ++i) read_case(argv[i], cases);
  std::erase_if(cases, [](const auto& one) { return one.second.size() < 2; });
  if (cases.empty()) {
    std::cerr << "refinement_table: no vessel has two meshes. Usage: refinement_table CASE... "
                 "[--markdown FILE]\n";
    return 64;
  }
  results.paragraph(
      "Columns are edges around a vessel. Differences of percentages are in points, of "
      "eccentricities as they are, others in per cent of the larger number.");
  add_summary(cases, results);
  for (const auto& [name, meshes] : cases) add_case(name, meshes, results);
  results.write();
  return 0;
}

}  // namespace
}  // namespace angio::benchmarks

int main(int argument_count, char** arguments) {
  return angio::benchmarks::run_benchmark("refinement_table", argument_count, arguments,
                                          angio::benchmarks::run);
}
