// cloth [FILE.svg] [--markdown FILE]: the seed paper's section 6.1. Prints, for every step of the
// pull, the thickness, how symmetric the cloth is, and how well its volume is kept, by Newton's
// method and by vertex block descent, and how far the two are apart; with a file, draws the
// thickness at four moments as the paper's Figure 5 does.
#include "simulation/cloth.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "testing/result_table.hpp"

namespace {

using angio::Triangle;
using angio::Vec3;
using angio::simulation::Cloth;
using angio::simulation::ClothOptions;
using angio::simulation::ClothState;

double triangle_area(const std::vector<Vec3>& x, const Triangle& t) {
  const Vec3 &a = x[std::size_t(t[0])], &b = x[std::size_t(t[1])], &c = x[std::size_t(t[2])];
  return 0.5 * norm(cross(b - a, c - a));
}

/// sum h A over what it was, less one.
double volume_change(const Cloth& cloth, const ClothState& state, double thickness) {
  double before = 0.0, after = 0.0;
  for (std::size_t t = 0; t < state.thickness_mm.size(); ++t) {
    before += thickness * triangle_area(cloth.rest.vertices, cloth.rest.triangles[t]);
    after += state.thickness_mm[t] * triangle_area(state.positions, cloth.rest.triangles[t]);
  }
  return after / before - 1.0;
}

/// The greatest distance [mm] of a vertex from the mirror image of its partner, over the mirrors
/// x = side / 2 and x = y, which make all eight symmetries.
double asymmetry(const ClothState& state, const ClothOptions& options) {
  const int row = options.cells + 1;
  double worst = 0.0;
  for (int j = 0; j < row; ++j)
    for (int i = 0; i < row; ++i) {
      const Vec3& p = state.positions[std::size_t(j * row + i)];
      const Vec3& m = state.positions[std::size_t(j * row + row - 1 - i)];
      const Vec3& t = state.positions[std::size_t(i * row + j)];
      worst = std::max({worst, distance(p, Vec3{options.side_mm - m.x, m.y, 0.0}),
                        distance(p, Vec3{t.y, t.x, 0.0})});
    }
  return worst;
}

/// Blue where thin, over white, to red where thick, by the rank that `share` in [0, 1] gives.
std::string color(double share) {
  const auto part = [](double v) { return int(std::lround(255.0 * std::clamp(v, 0.0, 1.0))); };
  char text[16];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", part(2.0 * share),
                part(1.0 - 0.8 * std::abs(2.0 * share - 1.0)), part(2.0 - 2.0 * share));
  return text;
}

void draw(const Cloth& cloth, const ClothOptions& options, const std::string& file) {
  constexpr double kPanel = 420.0, kMargin = 60.0;
  // The colours span 0.95 H to H: only at the corners it is thinner.
  constexpr double kThinnest = 0.95;
  std::ofstream out(file);
  out << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << 4 * kPanel << "\" height=\""
      << kPanel + 30 << "\"><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>";
  const double scale = (kPanel - 2 * kMargin) / options.side_mm;
  for (int panel = 0; panel < 4; ++panel) {
    const ClothState& state = cloth.states[std::size_t(panel) * (cloth.states.size() - 1) / 3];
    out << "<g stroke-width=\"0.3\">";
    for (std::size_t t = 0; t < cloth.rest.triangles.size(); ++t) {
      const double share =
          (state.thickness_mm[t] / options.thickness_mm - kThinnest) / (1.0 - kThinnest);
      const std::string fill = color(share);
      out << "<polygon fill=\"" << fill << "\" stroke=\"" << fill << "\" points=\"";
      for (const int v : cloth.rest.triangles[t]) {
        const Vec3& p = state.positions[std::size_t(v)];
        out << panel * kPanel + kMargin + scale * p.x << ',' << kPanel - kMargin - scale * p.y
            << ' ';
      }
      out << "\"/>";
    }
    char label[120];
    std::snprintf(label, sizeof label, "+%.0f %%, thickness %.2f to %.3f mm", 100.0 * state.stretch,
                  *std::min_element(state.thickness_mm.begin(), state.thickness_mm.end()),
                  *std::max_element(state.thickness_mm.begin(), state.thickness_mm.end()));
    out << "</g><text x=\"" << (panel + 0.5) * kPanel << "\" y=\"" << kPanel + 10
        << "\" text-anchor=\"middle\" font-family=\"Arial\" font-size=\"16\">" << label
        << "</text>";
  }
  out << "</svg>\n";
}

void print(const Cloth& cloth, const ClothOptions& options,
           angio::benchmarks::ResultTable& results) {
  using angio::benchmarks::formatted;
  results.columns({"stretch %", "thickness, least mm", "in the centre mm", "greatest mm",
                   "sum of h A, change", "asymmetry mm", "residual", "iterations"});
  const std::size_t centre = 2 * std::size_t(options.cells / 2 * options.cells + options.cells / 2);
  for (const ClothState& s : cloth.states)
    results.row({formatted("%.1f", 100.0 * s.stretch),
                 formatted("%.4f", *std::min_element(s.thickness_mm.begin(), s.thickness_mm.end())),
                 formatted("%.4f", s.thickness_mm[centre]),
                 formatted("%.4f", *std::max_element(s.thickness_mm.begin(), s.thickness_mm.end())),
                 formatted("%.1e", volume_change(cloth, s, options.thickness_mm)),
                 formatted("%.1e", asymmetry(s, options)), formatted("%.1e", s.residual),
                 formatted("%d%s", s.iterations, s.converged ? "" : " (not converged)")});
}

void print_difference(const Cloth& a, const Cloth& b, angio::benchmarks::ResultTable& results) {
  double distance_mm = 0.0, thickness = 0.0;
  for (std::size_t s = 0; s < a.states.size(); ++s) {
    const ClothState &p = a.states[s], &q = b.states[s];
    for (std::size_t v = 0; v < p.positions.size(); ++v)
      distance_mm = std::max(distance_mm, distance(p.positions[v], q.positions[v]));
    for (std::size_t t = 0; t < p.thickness_mm.size(); ++t)
      thickness = std::max(thickness, std::abs(q.thickness_mm[t] / p.thickness_mm[t] - 1.0));
  }
  results.paragraph(angio::benchmarks::formatted(
      "Greatest difference of the two methods over all states: vertices %.1e mm, thickness %.1e of "
      "itself.",
      distance_mm, thickness));
}

}  // namespace

int main(int argc, char** argv) try {
  angio::benchmarks::ResultTable results("The seed paper's cloth, pulled at its corners", argc,
                                         argv);
  ClothOptions options;
  results.section("Newton's method, double precision");
  const Cloth newton = angio::simulation::pull_cloth(options);
  print(newton, options, results);
  options.solver = angio::simulation::ClothSolver::vbd;
  results.section("Vertex block descent, single precision");
  const Cloth vbd = angio::simulation::pull_cloth(options);
  print(vbd, options, results);
  print_difference(newton, vbd, results);
  if (argc > 1) draw(newton, options, argv[1]);
  results.write();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "cloth: %s\n", error.what());
  return 1;
}
