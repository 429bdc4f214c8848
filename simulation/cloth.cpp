#include "simulation/cloth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "core/units.hpp"
#include "simulation/newton/membrane_term.hpp"
#include "simulation/pbd/sheet_solver.hpp"

namespace angio::simulation {
namespace {

using namespace detail;

void check(const ClothOptions& o) {
  if (!(o.side_mm > 0.0) || !(o.thickness_mm > 0.0))
    throw OptionError("the cloth's side and thickness must be positive [mm]");
  if (o.cells < 2 || o.cells > 1000 || o.cells % 2 != 0)
    throw OptionError("the cloth's cells a side must be even, 2 to 1000");
  if (!(o.c1_mpa > 0.0) || o.c2_mpa < 0.0)
    throw OptionError("the cloth's c1_mpa must be positive and c2_mpa not negative");
  if (!(o.stretch > 0.0) || o.stretch > 3.0)
    throw OptionError("the cloth's stretch must lie in (0, 3]");
  if (o.steps < 1 || o.steps > 10000) throw OptionError("the cloth's steps must lie in [1, 10000]");
}

TriangleMesh square(double side, int cells) {
  TriangleMesh mesh;
  const int row = cells + 1;
  for (int j = 0; j < row; ++j)
    for (int i = 0; i < row; ++i)
      mesh.vertices.push_back({side * i / cells, side * j / cells, 0.0});
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = j * row + i, b = a + 1, c = a + row, d = c + 1;
      const bool rising = (i + j) % 2 == 0;
      mesh.triangles.push_back({a, b, rising ? d : c});
      mesh.triangles.push_back({rising ? a : b, d, c});
    }
  return mesh;
}

double area(const std::vector<Vec3>& x, const Triangle& t) {
  const Vec3 &a = x[std::size_t(t[0])], &b = x[std::size_t(t[1])], &c = x[std::size_t(t[2])];
  return 0.5 * norm(cross(b - a, c - a));
}

/// h = H A0 / A
std::vector<double> thickness(const TriangleMesh& rest, const std::vector<Vec3>& x, double before) {
  std::vector<double> result;
  for (const Triangle& t : rest.triangles)
    result.push_back(before * area(rest.vertices, t) / area(x, t));
  return result;
}

/// Finds the cloth's equilibria one after the other.
class Puller {
 public:
  Puller(const ClothOptions& options, const TriangleMesh& rest)
      : options_(options),
        rest_(rest),
        law_{units::pascal_from_megapascal(options.c1_mpa),
             units::pascal_from_megapascal(options.c2_mpa)},
        membrane_({law_, {}, false}, rest.triangles, rest.vertices, options.thickness_mm),
        fixed_(rest.vertices.size(), kFixedZ),
        x_(rest.vertices) {
    const auto row = std::size_t(options.cells) + 1;
    corners_ = {0, row - 1, row * (row - 1), row * row - 1};
    for (const std::size_t c : corners_) fixed_[c] = kFixedAll;
    newton_.longest_move = options.side_mm / options.cells;
    if (options.solver != ClothSolver::vbd) return;
    std::vector<char> held(rest.vertices.size(), 0);
    for (const std::size_t c : corners_) held[c] = 1;
    sheet_.emplace(rest, law_, options.thickness_mm, kDensity, held);
  }

  ClothState pull(double stretch) {
    const Vec3 centre{0.5 * options_.side_mm, 0.5 * options_.side_mm, 0.0};
    for (const std::size_t c : corners_)
      x_[c] = centre + (1.0 + stretch) * (rest_.vertices[c] - centre);
    NewtonOptions options = newton_;
    ClothState state;
    if (sheet_) {
      state.iterations = descend();
      options.most_iterations = 0;  // measures the residual
    }
    const NewtonResult result = minimize({&membrane_}, fixed_, x_, options);
    state.stretch = stretch;
    state.positions = x_;
    state.thickness_mm = thickness(rest_, x_, options_.thickness_mm);
    state.residual = result.residual;
    state.converged = sheet_ ? result.residual < kBalance : result.converged;
    if (!sheet_) state.iterations = result.iterations;
    return state;
  }

 private:
  static constexpr double kDensity = 1.07e-3;  // of what has no inertia here [g/mm^3]
  static constexpr double kBalance = 1e-3;     // single precision's noise is below it
  static constexpr double kRest = 2e-6;        // of the side: vertices go no farther in a step
  static constexpr int kMostSteps = 500;

  /// @return sweeps
  int descend() {
    for (const std::size_t c : corners_) sheet_->set_position(int(c), x_[c]);
    SheetStep step;
    step.dt = 0.0;
    step.relaxation = 1.8;
    int sweeps = 0;
    for (int n = 0; n < kMostSteps; ++n) {
      sheet_->step(step);
      sweeps += step.sweeps;
      const std::vector<Vec3> before = std::exchange(x_, sheet_->positions());
      double moved = 0.0;
      for (std::size_t v = 0; v < x_.size(); ++v)
        moved = std::max(moved, distance(before[v], x_[v]));
      if (moved < kRest * options_.side_mm) break;
    }
    return sweeps;
  }

  const ClothOptions& options_;
  const TriangleMesh& rest_;
  MooneyRivlin<double> law_;
  MembraneTerm membrane_;
  std::vector<char> fixed_;
  std::vector<Vec3> x_;
  std::array<std::size_t, 4> corners_{};
  NewtonOptions newton_;
  std::optional<SheetSolver> sheet_;
};

}  // namespace

TriangleMesh cloth_mesh(const ClothOptions& options) {
  check(options);
  return square(options.side_mm, options.cells);
}

Cloth pull_cloth(const ClothOptions& options) {
  Cloth cloth;
  cloth.rest = cloth_mesh(options);
  const std::vector<Vec3>& start = cloth.rest.vertices;
  cloth.states.push_back(
      {0.0, start, thickness(cloth.rest, start, options.thickness_mm), 0.0, 0, true});
  Puller puller(options, cloth.rest);
  for (int step = 1; step <= options.steps; ++step)
    cloth.states.push_back(puller.pull(options.stretch * step / options.steps));
  return cloth;
}

}  // namespace angio::simulation
