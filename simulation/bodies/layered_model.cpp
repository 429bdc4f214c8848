#include "simulation/bodies/layered_model.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/parallel.hpp"
#include "simulation/materials/solid_flow.hpp"

namespace angio::simulation::detail {
namespace {

constexpr double kPaPerKpa = 1e3;

SolidLaw<double> law_of(const WallRegionMaterial& m) {
  SolidLaw<double> law;
  law.shear = kPaPerKpa * m.shear_kpa;
  law.bulk = kPaPerKpa * m.bulk_kpa;
  law.k1 = kPaPerKpa * m.fiber_k1_kpa;
  law.k2 = m.fiber_k2;
  law.share = m.fiber_share;
  law.yield = kPaPerKpa * m.yield_kpa;
  law.creep = m.creep_per_s;
  return law;
}

// Twice the area of the mean of both triangles, pointing outwards.
Vec3 thickness_direction(const Vec3* x) {
  return cross(x[1] - x[0], x[2] - x[0]) + cross(x[4] - x[3], x[5] - x[3]);
}

void set_directions(const LayeredWall& wall, const WallOptions& options, SolidModel& model) {
  for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
    std::array<Vec3, 6> x;
    for (std::size_t a = 0; a < 6; ++a)
      x[a] = wall.vertices[static_cast<std::size_t>(wall.wedges[w][a])];
    const Vec3 outwards = normalized(thickness_direction(x.data()));
    const Vec3 around = normalized(cross(wall.axial[w], outwards));
    const Vec3 along = cross(outwards, around);  // the vessel's direction within the layer
    const double angle =
        std::numbers::pi / 180.0 *
        options.materials[static_cast<std::size_t>(wall.region[w])].fiber_angle_deg;
    model.around.push_back(around);
    model.fibers.push_back(std::cos(angle) * around + std::sin(angle) * along);
    model.fibers.push_back(std::cos(angle) * around - std::sin(angle) * along);
  }
}

// A side that two wedges of a layer share, by its edge on the lumen's side.
struct Side {
  double length = 0.0;
  std::size_t a = 0, b = 0;  // the wedges
};

std::vector<Side> shared_sides(const LayeredWall& wall) {
  std::map<std::pair<int, int>, std::size_t> open;
  std::vector<Side> sides;
  for (std::size_t w = 0; w < wall.wedges.size(); ++w)
    for (std::size_t a = 0; a < 3; ++a) {
      const int i = wall.wedges[w][a], j = wall.wedges[w][(a + 1) % 3];
      const auto [other, is_new] = open.insert({std::minmax(i, j), w});
      if (is_new || wall.region[other->second] != wall.region[w]) continue;
      sides.push_back({distance(wall.vertices[static_cast<std::size_t>(i)],
                                wall.vertices[static_cast<std::size_t>(j)]),
                       other->second, w});
    }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const Side& a, const Side& b) { return a.length > b.length; });
  return sides;
}

// Wedges in twos across their longest sides; what is left over joins a neighbour's two.
void set_patches(const LayeredWall& wall, SolidModel& model) {
  const std::vector<Side> sides = shared_sides(wall);
  std::vector<int> size;
  model.patch.assign(wall.wedges.size(), -1);
  for (const Side& side : sides)
    if (model.patch[side.a] < 0 && model.patch[side.b] < 0) {
      model.patch[side.a] = model.patch[side.b] = static_cast<int>(size.size());
      size.push_back(2);
    }
  for (const Side& side : sides)
    for (const auto& [one, other] : {std::pair{side.a, side.b}, std::pair{side.b, side.a}})
      if (const int p = model.patch[other];
          model.patch[one] < 0 && p >= 0 && size[static_cast<std::size_t>(p)] < kMostPatchWedges) {
        model.patch[one] = p;
        ++size[static_cast<std::size_t>(p)];
      }
  for (int& p : model.patch)
    if (p < 0) {
      p = static_cast<int>(size.size());
      size.push_back(1);
    }
  model.patch_begin.assign(1, 0);
  for (const int n : size) model.patch_begin.push_back(model.patch_begin.back() + n);
  std::vector<int> next(model.patch_begin.begin(), model.patch_begin.end() - 1);
  model.patch_wedges.resize(wall.wedges.size());
  for (std::size_t w = 0; w < wall.wedges.size(); ++w)
    model.patch_wedges[static_cast<std::size_t>(next[static_cast<std::size_t>(model.patch[w])]++)] =
        static_cast<int>(w);
  model.patch_bulk.assign(size.size(), 0.0);
  for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
    const auto p = static_cast<std::size_t>(model.patch[w]);
    model.patch_bulk[p] +=
        model.laws[static_cast<std::size_t>(wall.region[w])].bulk * model.tissue_ratio[w] / size[p];
  }
}

WallStress stress_of(const SolidModel& model, std::size_t w, const std::array<Vec3, 6>& x,
                     const WallState& state, const LayeredWall& wall) {
  const SolidView<double> view = model.view(state.vertices.data());
  const SolidWedge<double> wedge = view.wedge(static_cast<int>(w));
  WallStress out;
  out.volume_ratio = wedge_volume(x.data()) / model.volume[w];
  // The tissue's pressure: the wedge carries that of tissue_ratio times as much.
  const double pressure = patch_energy(view, model.patch[w]).d1 / model.tissue_ratio[w];
  Mat3 sum, seen;
  for (std::size_t q = 0; q < kWedgePoints; ++q) {
    const Mat3 f = solid::deformation(wedge.points[q], x.data());
    SolidTangent<double> tangent;
    const SolidStress<double> s = solid_stress(wedge.law, wedge.fiber, f, tangent);
    Mat3 cauchy = (1.0 / determinant(f)) * (s.p * transpose(f));
    for (int i = 0; i < 3; ++i) cauchy(i, i) += pressure;
    sum += (1.0 / kWedgePoints) * cauchy;
    seen += (1.0 / kWedgePoints) *
            solid::deformation(model.mesh_points[kWedgePoints * w + q], x.data());
    out.plastic_strain += state.plastic_strain[kWedgePoints * w + q] / kWedgePoints;
  }
  const Vec3 principal = eigen_decomposition(sum).value;
  const Vec3 stretch = eigen_decomposition(transpose(seen) * seen).value;
  const Vec3 around = normalized(seen * model.around[w]), along = normalized(seen * wall.axial[w]);
  out.principal_kpa = std::max({principal.x, principal.y, principal.z}) / kPaPerKpa;
  out.circumferential_kpa = dot(around, sum * around) / kPaPerKpa;
  out.axial_kpa = dot(along, sum * along) / kPaPerKpa;
  out.von_mises_kpa = std::sqrt(1.5) * frobenius_norm(deviator(sum)) / kPaPerKpa;
  out.log_strain = 0.5 * std::log(std::max({stretch.x, stretch.y, stretch.z}));
  return out;
}

std::vector<double> volumes_around(const SolidModel& model, const LayeredWall& wall) {
  std::vector<double> sum(wall.vertices.size(), 0.0);
  for (std::size_t w = 0; w < wall.wedges.size(); ++w)
    for (const int v : wall.wedges[w]) sum[static_cast<std::size_t>(v)] += model.volume[w];
  return sum;
}

void add(const WallStress& s, double weight, WallStress& sum) {
  sum.principal_kpa += weight * s.principal_kpa;
  sum.circumferential_kpa += weight * s.circumferential_kpa;
  sum.axial_kpa += weight * s.axial_kpa;
  sum.von_mises_kpa += weight * s.von_mises_kpa;
  sum.log_strain += weight * s.log_strain;
  sum.plastic_strain += weight * s.plastic_strain;
  sum.volume_ratio += weight * s.volume_ratio;
}

}  // namespace

SolidView<double> SolidModel::view(const Vec3* x) const {
  SolidView<double> out;
  out.x = x;
  out.corners = corners.data();
  out.points = points.data();
  out.fibers = fibers.data();
  out.patch = patch.data();
  out.patch_begin = patch_begin.data();
  out.patch_wedges = patch_wedges.data();
  out.patch_volume = patch_volume.data();
  out.patch_bulk = patch_bulk.data();
  out.region = region.data();
  out.laws = laws.data();
  return out;
}

std::array<Vec3, 6> corners_of(const SolidModel& model, int wedge, const std::vector<Vec3>& x) {
  std::array<Vec3, 6> out;
  for (std::size_t a = 0; a < 6; ++a)
    out[a] = x[static_cast<std::size_t>(model.corners[6 * static_cast<std::size_t>(wedge) + a])];
  return out;
}

SolidModel make_solid_model(const LayeredWall& wall, const WallOptions& options) {
  SolidModel model;
  for (const WallRegionMaterial& m : options.materials) model.laws.push_back(law_of(m));
  model.tissue_ratio = wall.tissue_ratio;
  model.tissue_ratio.resize(wall.wedges.size(), 1.0);
  model.mass.assign(wall.vertices.size(), 0.0);
  for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
    model.corners.insert(model.corners.end(), wall.wedges[w].begin(), wall.wedges[w].end());
    model.region.push_back(static_cast<int>(wall.region[w]));
    const std::array<Vec3, 6> x = corners_of(model, static_cast<int>(w), wall.vertices);
    for (int q = 0; q < kWedgePoints; ++q)
      model.mesh_points.push_back(make_solid_point(x.data(), q));
    const double density =
        options.materials[static_cast<std::size_t>(wall.region[w])].density_g_mm3;
    for (const int v : wall.wedges[w])
      model.mass[static_cast<std::size_t>(v)] +=
          model.tissue_ratio[w] * density * wedge_volume(x.data()) / 6.0;
  }
  set_directions(wall, options, model);
  set_patches(wall, model);
  model.foundation.assign(wall.vertices.size(), 0.0);
  for (const Triangle& t : wall.outer_triangles) {
    const Vec3 a = wall.vertices[static_cast<std::size_t>(t[0])];
    const double area = 0.5 * norm(cross(wall.vertices[static_cast<std::size_t>(t[1])] - a,
                                         wall.vertices[static_cast<std::size_t>(t[2])] - a));
    for (const int v : t)
      model.foundation[static_cast<std::size_t>(v)] +=
          kPaPerKpa * options.foundation_kpa_per_mm * area / 3.0;
  }
  set_memory(unloaded_state(wall), model);
  return model;
}

void set_memory(const WallState& state, SolidModel& model) {
  model.points.resize(model.mesh_points.size());
  model.volume.assign(model.region.size(), 0.0);
  model.patch_volume.assign(model.patch_begin.size() - 1, 0.0);
  for (std::size_t p = 0; p < model.points.size(); ++p) {
    model.points[p] =
        prestressed(model.mesh_points[p], state.prestress[p] * inverse(state.plastic[p]));
    model.volume[p / kWedgePoints] += model.points[p].weight;
    model.patch_volume[static_cast<std::size_t>(model.patch[p / kWedgePoints])] +=
        model.points[p].weight;
    model.points[p].weight *= model.tissue_ratio[p / kWedgePoints];
  }
}

double flow(SolidModel& model, WallState& state, double dt) {
  std::vector<double> added(model.region.size(), 0.0);
  parallel_for(static_cast<std::ptrdiff_t>(model.region.size()), [&](std::ptrdiff_t index) {
    const auto w = static_cast<std::size_t>(index);
    const SolidWedge<double> wedge = model.view(nullptr).wedge(static_cast<int>(w));
    if (!(wedge.law.yield > 0.0)) return;
    const std::array<Vec3, 6> x = corners_of(model, static_cast<int>(w), state.vertices);
    for (std::size_t q = 0; q < kWedgePoints; ++q) {
      const std::size_t p = kWedgePoints * w + q;
      const FlowStep<double> step =
          flow_solid(wedge.law, wedge.fiber, solid::deformation(model.points[p], x.data()), dt);
      if (!(step.strain > 0.0)) continue;
      state.plastic[p] = step.growth * state.plastic[p];
      state.plastic_strain[p] += step.strain;
      added[w] = std::max(added[w], step.strain);
    }
  });
  double most = 0.0;
  for (const double a : added) most = std::max(most, a);
  if (most > 0.0) set_memory(state, model);
  return most;
}

std::vector<WallStress> wedge_stresses(const SolidModel& model, const LayeredWall& wall,
                                       const WallState& state) {
  std::vector<WallStress> out;
  out.reserve(wall.wedges.size());
  for (std::size_t w = 0; w < wall.wedges.size(); ++w)
    out.push_back(
        stress_of(model, w, corners_of(model, static_cast<int>(w), state.vertices), state, wall));
  return out;
}

std::vector<double> wedge_plastic_strain(const SolidModel& model,
                                         const std::vector<double>& plastic_strain) {
  std::vector<double> means(static_cast<std::size_t>(model.wedge_count()), 0.0);
  for (std::size_t p = 0; p < plastic_strain.size(); ++p)
    means[p / kWedgePoints] += plastic_strain[p] / kWedgePoints;
  return means;
}

std::vector<double> vertex_means(const SolidModel& model, const LayeredWall& wall,
                                 const std::vector<double>& of_wedges) {
  const std::vector<double> weight = volumes_around(model, wall);
  std::vector<double> means(wall.vertices.size(), 0.0);
  for (std::size_t w = 0; w < wall.wedges.size(); ++w)
    for (const int v : wall.wedges[w]) {
      const auto i = static_cast<std::size_t>(v);
      means[i] += model.volume[w] / weight[i] * of_wedges[w];
    }
  return means;
}

WallFields fields(const SolidModel& model, const LayeredWall& wall, const WallState& state) {
  WallFields out;
  out.wedges = wedge_stresses(model, wall, state);
  out.vertices.assign(wall.vertices.size(), WallStress{.volume_ratio = 0.0});
  const std::vector<double> weight = volumes_around(model, wall);
  for (std::size_t w = 0; w < wall.wedges.size(); ++w)
    for (const int v : wall.wedges[w])
      add(out.wedges[w], model.volume[w] / weight[static_cast<std::size_t>(v)],
          out.vertices[static_cast<std::size_t>(v)]);
  return out;
}

}  // namespace angio::simulation::detail
