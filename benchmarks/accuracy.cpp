// Prints how near the pipeline comes to phantoms whose truth is known. docs/accuracy.md explains
// the columns.
//
//     accuracy [image|surface] [phantoms=a,b] [spacings=0.3] [slices=0] [noises=0.1] [seeds=20]
//              [oblique=0] [blur=0] [stenosis=60] [--markdown FILE]
//
// image:   scan (exact partial volume, blur, noise) -> level set -> centreline -> lesions
// surface: exact surface of about 30,000 triangles, its vertices moved along their normals by noise
//          [mm] -> centreline -> lesions

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "benchmarks/accuracy_measures.hpp"
#include "centerline/centerline.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/statistics.hpp"
#include "datasets/detail/anatomy.hpp"
#include "datasets/detail/lumen_surface.hpp"
#include "datasets/detail/scan.hpp"
#include "datasets/detail/truth.hpp"
#include "datasets/phantom.hpp"
#include "segmentation/segmentation.hpp"
#include "testing/result_table.hpp"

namespace angio {
namespace {

using datasets::PhantomOptions;
using datasets::PhantomTruth;
using datasets::detail::LumenShape;

constexpr int kTriangleCount = 30000;

/// Of all threads together: depends less on what else the machine does than a clock on the wall.
double cpu_seconds_since(std::clock_t start) {
  return double(std::clock() - start) / CLOCKS_PER_SEC;
}

// ---- runs -----------------------------------------------------------------------------------

Accuracy measure_image(const PhantomOptions& options) {
  const datasets::Phantom phantom = datasets::make_phantom_scan(options);
  const LumenShape shape = datasets::detail::make_anatomy(options).shape;
  Accuracy accuracy;
  std::clock_t start = std::clock();
  const segmentation::Segmentation lumen = segmentation::segment_vessels(phantom.volume, {});
  accuracy.segmentation_s = cpu_seconds_since(start);
  start = std::clock();
  centerline::CenterlineOptions lines;
  lines.voxel_mm = phantom.volume.geometry.longest_spacing();
  const CenterlineTree tree = centerline::extract_centerline(lumen.level_set, lines).tree;
  accuracy.centerline_s = cpu_seconds_since(start);
  accuracy.surface_mm = surface_distances(lumen.level_set, shape);
  compare_volumes(lumen.level_set, shape, accuracy);
  compare_trees(tree, phantom.truth, accuracy);
  return accuracy;
}

/// The exact surface of a phantom with about kTriangleCount triangles.
TriangleMesh fine_surface(const LumenShape& shape) {
  double coarse = 0.8 * shape.least_radius_mm(), fine = 0.1 * shape.least_radius_mm();
  TriangleMesh mesh;
  for (int round = 0; round < 8; ++round) {
    const double cell = std::sqrt(coarse * fine);
    mesh = datasets::detail::tree_surface(shape, cell);
    const double ratio = double(mesh.triangles.size()) / kTriangleCount;
    if (std::abs(ratio - 1.0) < 0.1) break;
    (ratio > 1.0 ? fine : coarse) = cell;
  }
  return mesh;
}

void move_vertices(TriangleMesh& mesh, double noise_mm, std::uint64_t seed) {
  if (noise_mm <= 0.0) return;
  std::vector<Vec3> normals(mesh.vertices.size());
  for (const Triangle& triangle : mesh.triangles)
    for (int v : triangle) normals[std::size_t(v)] += area_vector_doubled(mesh, triangle);
  for (std::size_t v = 0; v < normals.size(); ++v)
    mesh.vertices[v] +=
        noise_mm * datasets::detail::normal_number(seed, v) * normalized(normals[v]);
}

/// A surface and its truth, the same for every seed of the noise.
struct ExactSurface {
  TriangleMesh mesh;
  PhantomTruth truth;
};

ExactSurface make_exact_surface(const PhantomOptions& options) {
  const datasets::detail::Anatomy anatomy = datasets::detail::make_anatomy(options);
  return {fine_surface(anatomy.shape), datasets::detail::derive_truth(anatomy)};
}

Accuracy measure_surface(const ExactSurface& exact, double noise_mm, std::uint64_t seed) {
  TriangleMesh mesh = exact.mesh;
  move_vertices(mesh, noise_mm, seed);
  Accuracy accuracy;
  const std::clock_t start = std::clock();
  const CenterlineTree tree = centerline::extract_centerline(mesh, {}).tree;
  accuracy.centerline_s = cpu_seconds_since(start);
  compare_trees(tree, exact.truth, accuracy);
  return accuracy;
}

// ---- tables ---------------------------------------------------------------------------------

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (double v : values) sum += v;
  return values.empty() ? NAN : sum / double(values.size());
}
double standard_deviation(const std::vector<double>& values) {
  const double middle = mean(values);
  double sum = 0.0;
  for (double v : values) sum += (v - middle) * (v - middle);
  return values.size() < 2 ? NAN : std::sqrt(sum / double(values.size() - 1));
}

void append(std::vector<double>& all, const std::vector<double>& part) {
  all.insert(all.end(), part.begin(), part.end());
}

/// Runs of one phantom with several seeds, put together. The standard deviation at the throat is
/// over the seeds, for each lesion by itself.
struct Row {
  std::string phantom;
  double spacing_mm = 0.0;
  double slice_mm = 0.0;  ///< 0: cubes
  double noise = 0.0;
  int run_count = 0;
  int failure_count = 0;
  Accuracy pooled;
  std::vector<double> dice, volume, segmentation_s, centerline_s;
  std::map<std::size_t, std::vector<double>> throat_of_lesion;

  void add(const Accuracy& a) {
    ++run_count;
    append(pooled.surface_mm, a.surface_mm);
    append(pooled.line_mm, a.line_mm);
    append(pooled.radius_mm, a.radius_mm);
    append(pooled.wall_mm, a.wall_mm);
    append(pooled.equivalent_mm, a.equivalent_mm);
    append(pooled.throat, a.throat);
    append(pooled.throat_area, a.throat_area);
    for (std::size_t l = 0; l < a.throat.size(); ++l) throat_of_lesion[l].push_back(a.throat[l]);
    pooled.branches_missed += a.branches_missed;
    pooled.branches_invented += a.branches_invented;
    pooled.lesions_missed += a.lesions_missed;
    pooled.lesions_invented += a.lesions_invented;
    dice.push_back(a.dice);
    volume.push_back(a.volume);
    segmentation_s.push_back(a.segmentation_s);
    centerline_s.push_back(a.centerline_s);
  }

  [[nodiscard]] double throat_sd() const {
    double worst = NAN;
    for (const auto& [lesion, errors] : throat_of_lesion)
      worst = std::isnan(worst) ? standard_deviation(errors)
                                : std::max(worst, standard_deviation(errors));
    return worst;
  }
};

/// A number as it is printed; an empty cell where it does not apply.
std::string cell(const char* format, double value) {
  return std::isnan(value) ? std::string() : benchmarks::formatted(format, value);
}
std::string pair(const char* format, double a, double b) {
  return cell(format, a) + (std::isnan(b) ? "" : " / " + cell("%.2f", b));
}

/// Of a scan and of a surface: where a surface is given nothing is segmented.
std::vector<std::string> column_names(bool is_surface) {
  std::vector<std::string> names{"phantom"};
  if (!is_surface) names.emplace_back("voxel mm");
  names.insert(names.end(), {is_surface ? "noise mm" : "noise", "line, mean / 95 % mm",
                             "radius bias, tube; inscribed mm", "equivalent radius bias mm",
                             "throat radius, bias / sd %", "least area %"});
  if (!is_surface) names.insert(names.end(), {"surface, mean / 95 % mm", "Dice", "volume %"});
  names.insert(names.end(), {"branches missed / invented", "stenoses missed / invented"});
  if (!is_surface) names.emplace_back("segmentation CPU s");
  names.insert(names.end(), {"line CPU s", "failed"});
  return names;
}

std::vector<std::string> cells(const Row& r, bool is_surface) {
  const Accuracy& a = r.pooled;
  std::vector<std::string> row{r.phantom};
  if (!is_surface)
    row.push_back(r.slice_mm > 0.0 ? fmt::format("{0:g} x {0:g} x {1:g}", r.spacing_mm, r.slice_mm)
                                   : cell("%g", r.spacing_mm));
  row.insert(row.end(), {cell("%g", r.noise),
                         fmt::format("{:.4f} / {:.4f}", mean(a.line_mm),
                                     quantile(a.line_mm, 0.95, std::nan(""))),
                         fmt::format("{:+.4f}; {:+.4f}", mean(a.radius_mm), mean(a.wall_mm)),
                         cell("%+.4f", mean(a.equivalent_mm)),
                         pair("%+.2f", 100.0 * mean(a.throat), 100.0 * r.throat_sd()),
                         cell("%+.2f", 100.0 * mean(a.throat_area))});
  if (!is_surface)
    row.insert(row.end(), {fmt::format("{:.4f} / {:.4f}", mean(a.surface_mm),
                                       quantile(a.surface_mm, 0.95, std::nan(""))),
                           cell("%.4f", mean(r.dice)), cell("%+.2f", 100.0 * mean(r.volume))});
  row.insert(row.end(), {fmt::format("{} / {}", a.branches_missed, a.branches_invented),
                         fmt::format("{} / {}", a.lesions_missed, a.lesions_invented)});
  if (!is_surface) row.push_back(cell("%.2f", quantile(r.segmentation_s, 0.5, std::nan(""))));
  row.insert(row.end(), {cell("%.2f", quantile(r.centerline_s, 0.5, std::nan(""))),
                         fmt::format("{} of {}", r.failure_count, r.run_count + r.failure_count)});
  return row;
}

struct Plan {
  bool is_surface = false;
  std::vector<std::string> phantoms{"straight", "concentric", "unilateral",  "bilateral",
                                    "tandem",   "helix",      "torus",       "ytype",
                                    "aneurysm", "coronary",   "trifurcation"};
  std::vector<double> spacings{0.3}, noises{0.1};
  int seed_count = 20;
  double oblique_degrees = 0.0;
  double blur_mm = 0.0;
  std::vector<double> slices{0.0};  ///< [mm]; 0: cubes
  double stenosis_percent = 60.0;
};

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> parts;
  std::istringstream in(list);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  return parts;
}
std::vector<double> numbers(const std::string& list) {
  std::vector<double> values;
  for (const std::string& part : split(list)) values.push_back(std::stod(part));
  return values;
}

Plan parse(int argc, char** argv) {
  Plan plan;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const std::string key = argument.substr(0, argument.find('='));
    const std::string value = argument.substr(std::min(argument.size(), key.size() + 1));
    if (key == "surface")
      plan.is_surface = true;
    else if (key == "phantoms")
      plan.phantoms = split(value);
    else if (key == "spacings")
      plan.spacings = numbers(value);
    else if (key == "noises")
      plan.noises = numbers(value);
    else if (key == "seeds")
      plan.seed_count = std::stoi(value);
    else if (key == "oblique")
      plan.oblique_degrees = std::stod(value);
    else if (key == "blur")
      plan.blur_mm = std::stod(value);
    else if (key == "slices")
      plan.slices = numbers(value);
    else if (key == "stenosis")
      plan.stenosis_percent = std::stod(value);
    else if (key != "image")
      throw OptionError("no such option: " + argument);
  }
  if (plan.is_surface) plan.spacings = {0.0};
  return plan;
}

PhantomOptions options_of(const Plan& plan, const std::string& phantom, double spacing,
                          double slice, double noise) {
  PhantomOptions options;
  options.name = phantom;
  options.stenosis_percent = plan.stenosis_percent;
  if (spacing > 0.0) options.spacing_mm = spacing;
  options.noise_sd = noise;
  options.blur_mm = plan.blur_mm;
  options.slice_mm = slice;
  options.oblique_degrees = plan.oblique_degrees;
  return options;
}

Row measure_row(const Plan& plan, const std::string& phantom, double spacing, double slice,
                double noise) {
  Row row{phantom, spacing, slice, noise, 0, 0, {}, {}, {}, {}, {}, {}};
  PhantomOptions options = options_of(plan, phantom, spacing, slice, noise);
  const ExactSurface exact = plan.is_surface ? make_exact_surface(options) : ExactSurface{};
  const int seed_count = noise > 0.0 ? plan.seed_count : 1;
  for (options.seed = 1; options.seed <= std::uint64_t(seed_count); ++options.seed) {
    try {
      row.add(plan.is_surface ? measure_surface(exact, noise, options.seed)
                              : measure_image(options));
    } catch (const Error& error) {
      ++row.failure_count;
      fmt::print(stderr, "{} seed {}: {}\n", phantom, options.seed, error.what());
    }
  }
  return row;
}

}  // namespace
}  // namespace angio

int main(int argc, char** argv) try {
  angio::benchmarks::ResultTable results("Accuracy on phantoms with known truth", argc, argv);
  const angio::Plan plan = angio::parse(argc, argv);
  results.columns(angio::column_names(plan.is_surface));
  for (double spacing : plan.spacings)
    for (double slice : plan.slices)
      for (double noise : plan.noises)
        for (const std::string& phantom : plan.phantoms)
          results.row(angio::cells(angio::measure_row(plan, phantom, spacing, slice, noise),
                                   plan.is_surface));
  results.write();
  return EXIT_SUCCESS;
} catch (const std::exception& error) {
  fmt::print(stderr, "accuracy: {}\n", error.what());
  return EXIT_FAILURE;
}
