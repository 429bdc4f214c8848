#include "simulation/cloth.hpp"

#include <cmath>

#include "core/error.hpp"
#include "core/units.hpp"
#include "simulation/detail/membrane_term.hpp"

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

}  // namespace

TriangleMesh cloth_mesh(const ClothOptions& options) {
  check(options);
  return square(options.side_mm, options.cells);
}

Cloth pull_cloth(const ClothOptions& options) {
  Cloth cloth;
  cloth.rest = cloth_mesh(options);
  const auto& rest = cloth.rest.vertices;
  SkinLaw<double> law;
  law.base = {units::pascal_from_megapascal(options.c1_mpa),
              units::pascal_from_megapascal(options.c2_mpa)};
  const MembraneTerm skin(law, cloth.rest.triangles, rest, options.thickness_mm);
  const auto row = std::size_t(options.cells) + 1;
  const std::size_t corners[] = {0, row - 1, row * (row - 1), row * row - 1};
  std::vector<char> fixed(rest.size(), kFixedZ);
  for (const std::size_t c : corners) fixed[c] = kFixedAll;

  std::vector<Vec3> x = rest;
  cloth.states.push_back({0.0, x, thickness(cloth.rest, x, options.thickness_mm), 0.0, true});
  const Vec3 centre{0.5 * options.side_mm, 0.5 * options.side_mm, 0.0};
  NewtonOptions newton;
  newton.longest_move = options.side_mm / options.cells;
  for (int step = 1; step <= options.steps; ++step) {
    const double stretch = options.stretch * step / options.steps;
    for (const std::size_t c : corners) x[c] = centre + (1.0 + stretch) * (rest[c] - centre);
    const NewtonResult result = minimize({&skin}, fixed, x, newton);
    cloth.states.push_back({stretch, x, thickness(cloth.rest, x, options.thickness_mm),
                            result.residual, result.converged});
  }
  return cloth;
}

}  // namespace angio::simulation
