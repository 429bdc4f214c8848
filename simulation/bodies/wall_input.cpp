#include <cmath>
#include <numbers>
#include <numeric>
#include <string>

#include "core/error.hpp"
#include "core/require.hpp"
#include "simulation/materials/solid.hpp"
#include "simulation/option_names.hpp"
#include "simulation/wall.hpp"

/// The wall's names, materials and checks.
namespace angio::simulation {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

void validate(const WallRegionMaterial& m, const std::string& region) {
  const auto within = [&](const char* field, double value, double low, double high) {
    require_within("wall." + region + "." + field, value, low, high);
  };
  within("shear_kpa", m.shear_kpa, 0.1, 1e6);
  within("bulk_kpa", m.bulk_kpa, 5.0 * m.shear_kpa, 1e8);
  within("fiber_k1_kpa", m.fiber_k1_kpa, 0.0, 1e5);
  within("fiber_k2", m.fiber_k2, 1e-6, 1e3);
  within("fiber_angle_deg", m.fiber_angle_deg, 0.0, 90.0);
  within("fiber_share", m.fiber_share, 0.0, 1.0);
  within("yield_kpa", m.yield_kpa, 0.0, 1e6);
  within("creep_per_s", m.creep_per_s, 0.0, 1e6);
  within("density_g_mm3", m.density_g_mm3, 1e-5, 0.1);
}

std::string label(const LayeredWall& wall, std::size_t w) {
  return "wedge " + std::to_string(w) + " (layer " + std::to_string(wall.layer[w]) + ", " +
         name(wall.region[w]) + ")";
}

void check_shapes(const LayeredWall& wall) {
  const std::size_t count = wall.wedges.size();
  if (count == 0 || wall.lumen_triangles.empty() || wall.outer_triangles.empty())
    throw InputError("the layered wall has no wedges or no surface. Build it from the lumen again");
  if (wall.layer.size() != count || wall.region.size() != count || wall.axial.size() != count ||
      (!wall.tissue_ratio.empty() && wall.tissue_ratio.size() != count) ||
      wall.fixed.size() != wall.vertices.size())
    throw InputError(
        "the layered wall's arrays differ in length (layer, region, axial and tissue ratio are per "
        "wedge, fixed "
        "is per vertex). Build it from the lumen again");
  for (std::size_t w = 0; w < wall.tissue_ratio.size(); ++w)
    require_within("the layered wall's tissue ratio of wedge " + std::to_string(w),
                   wall.tissue_ratio[w], kLeastTissueRatio, kMostTissueRatio);
  for (std::size_t v = 0; v < wall.vertices.size(); ++v)
    if (!std::isfinite(norm(wall.vertices[v])))
      throw InputError("vertex " + std::to_string(v) +
                       " of the layered wall is not a number. Build it from the lumen again");
}

void check_indices(const LayeredWall& wall) {
  const int count = static_cast<int>(wall.vertices.size());
  const auto known = [&](int v) { return v >= 0 && v < count; };
  for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
    const int region = static_cast<int>(wall.region[w]);
    if (region < 0 || region >= kWallRegionCount)
      throw InputError("wedge " + std::to_string(w) +
                       " of the layered wall has no known region. Use intima, media, adventitia or "
                       "plaque");
    for (const int v : wall.wedges[w])
      if (!known(v))
        throw InputError(label(wall, w) + " has a corner that does not exist, " +
                         std::to_string(v) + ". Build the wall from the lumen again");
  }
  for (const std::vector<Triangle>* surface : {&wall.lumen_triangles, &wall.outer_triangles})
    for (const Triangle& t : *surface)
      for (const int v : t)
        if (!known(v))
          throw InputError("a surface of the layered wall has a corner that does not exist, " +
                           std::to_string(v) + ". Build the wall from the lumen again");
}

// The Jacobian at the corners and at the points: positive everywhere that counts.
void check_wedge(const LayeredWall& wall, std::size_t w) {
  Vec3 x[6];
  for (int a = 0; a < 6; ++a) x[a] = wall.vertices[at(wall.wedges[w][at(a)])];
  double size = 0.0;
  for (int a = 0; a < 3; ++a) size = std::max(size, distance(x[a], x[(a + 1) % 3]));
  for (int a = 0; a < 3; ++a)
    if (!(distance(x[a], x[a + 3]) > 1e-6 * size))
      throw InputError(label(wall, w) + " has no thickness at vertex " +
                       std::to_string(wall.wedges[w][at(a)]) +
                       " (a wall that is not there carries nothing). Give every layer a thickness");
  double least = 1e300;
  for (int q = 0; q < detail::kWedgePoints; ++q)
    least = std::min(least, determinant(detail::solid::jacobian(x, q)));
  for (int a = 0; a < 3; ++a)
    for (int level = 0; level < 2; ++level) {
      const int o = 3 * level, b = (a + 1) % 3, c = (a + 2) % 3;
      least =
          std::min(least, dot(cross(x[b + o] - x[a + o], x[c + o] - x[a + o]), x[a + 3] - x[a]));
    }
  if (!(least > 0.0))
    throw InputError(label(wall, w) +
                     " is inside out or flat (its layers cross or its triangle turns the wrong "
                     "way). Smooth the lumen, or make the wall thinner there");
  const Vec3 n = normalized(cross(x[1] - x[0], x[2] - x[0]));
  const Vec3 axial = wall.axial[w];
  if (!(std::abs(norm(axial) - 1.0) < 1e-6) || !(norm(cross(axial, n)) > 1e-3))
    throw InputError(label(wall, w) +
                     " has no axial direction within its layer (its fibres would have none). Give "
                     "the vessel's direction as a unit vector");
}

void check_whole(const LayeredWall& wall, const WallOptions& options) {
  std::vector<int> root(wall.vertices.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int v) {
    while (root[at(v)] != v) v = root[at(v)] = root[at(root[at(v)])];
    return v;
  };
  for (const Wedge& wedge : wall.wedges)
    for (const int v : wedge) root[at(find(v))] = find(wedge[0]);
  const int whole = find(wall.wedges[0][0]);
  std::vector<char> is_held(root.size(), 0);  // a piece, at its root
  is_held[at(whole)] = 1;
  for (std::size_t v = 0; v < root.size(); ++v)
    if (wall.fixed[v] != 0) is_held[at(find(static_cast<int>(v)))] = 1;
  for (std::size_t v = 0; v < root.size(); ++v)
    if (is_held[at(find(static_cast<int>(v)))] == 0)
      throw InputError("the layered wall is in pieces: vertex " + std::to_string(v) +
                       " is not joined to vertex " + std::to_string(wall.wedges[0][0]) +
                       ", nor held (a loose piece would fly off). Keep one connected piece of the "
                       "wall");
  bool held = options.foundation_kpa_per_mm > 0.0;
  for (const char f : wall.fixed) held = held || f != 0;
  if (!held)
    throw InputError(
        "nothing holds the layered wall: no vertex is fixed and the foundation is zero. Fix its "
        "rims or set wall.foundation_kpa_per_mm");
}

// Fibrous: E 1.84 MPa, perfect plasticity at 0.4 MPa (Morlacchi, Chiastra). Hypocellular and
// calcified: the circumferential tangent moduli at 25 kPa of Loree, Grodzinsky, Park, Gibson, Lee,
// J. Biomech. 27 (1994) 195; the same yield stress. Lipid: it tears at 69 kPa, stretched by 1.25
// (Teng et al. 2015, PMC4655866), and G is what leads a neo-Hookean
// strip there: stress = G (lambda^2 - 1 / lambda). Else G = E / 3.
WallRegionMaterial plaque_material(Plaque plaque) {
  constexpr double kTears = 69.0, kStretch = 1.25;
  const double lipid_shear = kTears / (kStretch * kStretch - 1.0 / kStretch);
  switch (plaque) {
    case Plaque::fibrous:
      return {.shear_kpa = 1840.0 / 3.0, .yield_kpa = 400.0};
    case Plaque::hypocellular:
      return {.shear_kpa = 2312.0 / 3.0, .yield_kpa = 400.0};
    case Plaque::calcified:
      return {.shear_kpa = 1466.0 / 3.0, .yield_kpa = 400.0};
    case Plaque::lipid:
      return {.shear_kpa = lipid_shear, .yield_kpa = kTears};
  }
  return {};
}

}  // namespace

const char* name(WallRegion region) { return enum_name(region); }

const char* name(Plaque plaque) { return enum_name(plaque); }

std::array<WallRegionMaterial, kWallRegionCount> wall_materials(Plaque plaque) {
  // Holzapfel et al. 2005 (H2048): mu = G/2, k1, k2, phi, rho of the human left anterior descending
  // artery; a layer yields at the mean of its circumferential and axial ultimate stress there.
  WallRegionMaterial intima{.shear_kpa = 2.0 * 27.90, .fiber_k1_kpa = 263.66, .fiber_k2 = 170.88};
  intima.fiber_angle_deg = 60.3;
  intima.fiber_share = 0.51;
  intima.yield_kpa = 392.5;
  WallRegionMaterial media{.shear_kpa = 2.0 * 1.27, .fiber_k1_kpa = 21.60, .fiber_k2 = 8.21};
  media.fiber_angle_deg = 20.61;
  media.fiber_share = 0.25;
  media.yield_kpa = 432.5;
  WallRegionMaterial adventitia{.shear_kpa = 2.0 * 7.56, .fiber_k1_kpa = 38.57, .fiber_k2 = 85.03};
  adventitia.fiber_angle_deg = 67.0;
  adventitia.fiber_share = 0.55;
  adventitia.yield_kpa = 1365.0;
  return {intima, media, adventitia, plaque_material(plaque), plaque_material(Plaque::calcified)};
}

void WallOptions::validate() const {
  for (int r = 0; r < kWallRegionCount; ++r)
    simulation::validate(materials[at(r)], name(static_cast<WallRegion>(r)));
  require_within("wall.blood_pressure_kpa", blood_pressure_kpa, 0.0, 50.0);
  require_within("wall.axial_stretch", axial_stretch, 0.9, 1.5);
  require_within("wall.foundation_kpa_per_mm", foundation_kpa_per_mm, 0.0, 1e5);
}

void check_wall(const LayeredWall& wall, const WallOptions& options) {
  check_shapes(wall);
  check_indices(wall);
  for (std::size_t w = 0; w < wall.wedges.size(); ++w) check_wedge(wall, w);
  check_whole(wall, options);
}

LayeredWall make_tube_wall(const TubeWall& tube) {
  const int levels = static_cast<int>(tube.layer_shares.size()) + 1;
  const double total = std::accumulate(tube.layer_shares.begin(), tube.layer_shares.end(), 0.0);
  const int ring_count = tube.along + 1, surface = tube.around * ring_count;
  LayeredWall wall;
  double share = 0.0;
  for (int level = 0; level < levels; ++level) {
    for (int ring = 0; ring < ring_count; ++ring)
      for (int i = 0; i < tube.around; ++i) {
        // Every other ring is turned by half an edge: near equilateral triangles.
        const double angle =
            2.0 * std::numbers::pi * (i + 0.5 * (ring % 2)) / static_cast<double>(tube.around);
        const double z = tube.length_mm * ring / static_cast<double>(tube.along);
        const double inner = tube.inner_radius_mm(angle, z), outer = tube.outer_radius_mm(angle, z);
        const double r = inner + (share / total) * (outer - inner);
        wall.vertices.push_back({r * std::cos(angle), r * std::sin(angle), z});
        wall.fixed.push_back(ring == 0 || ring == tube.along ? tube.rim : char(0));
      }
    if (level + 1 < levels) share += tube.layer_shares[at(level)];
  }
  for (int ring = 0; ring < tube.along; ++ring)
    for (int i = 0; i < tube.around; ++i) {
      const int j = (i + 1) % tube.around, below = ring * tube.around, above = below + tube.around;
      const Triangle lower = ring % 2 == 0 ? Triangle{below + i, below + j, above + i}
                                           : Triangle{below + i, below + j, above + j};
      const Triangle upper = ring % 2 == 0 ? Triangle{above + i, below + j, above + j}
                                           : Triangle{above + i, below + i, above + j};
      for (const Triangle& t : {lower, upper}) wall.lumen_triangles.push_back(t);
    }
  for (int level = 0; level + 1 < levels; ++level)
    for (const Triangle& t : wall.lumen_triangles) {
      const int in = level * surface, out = in + surface;
      wall.wedges.push_back({t[0] + in, t[1] + in, t[2] + in, t[0] + out, t[1] + out, t[2] + out});
      wall.layer.push_back(level);
      wall.region.push_back(tube.layer_regions[at(level)]);
      wall.axial.push_back({0, 0, 1});
    }
  for (const Triangle& t : wall.lumen_triangles) {
    const int out = (levels - 1) * surface;
    wall.outer_triangles.push_back({t[0] + out, t[1] + out, t[2] + out});
  }
  return wall;
}

}  // namespace angio::simulation
