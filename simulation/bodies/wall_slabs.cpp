#include "simulation/bodies/wall_slabs.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/units.hpp"
#include "simulation/materials/shape_modes.hpp"

namespace angio::simulation::detail {
namespace {

using Members = std::vector<int>;

// A slab shorter than this many edges has too few rings to have a shape.
constexpr double kLeastEdgesPerSlab = 3.0;
// In-plane spread of the normals over its greatest value: 0 for a flat piece, 1 for a full ring.
constexpr double kRingSpread = 0.25;
// Length of the mean normal: 0 for a full ring, 1 for a flat piece.
constexpr double kRingMeanNormal = 0.35;

// What the outermost member of a slab still counts, against 1 for one in its middle.
constexpr double kLeastShare = 0.02;

struct Slab {
  Vec3 centre, axis;
  double radius = 0.0;
  bool ring = false;
};

Slab measure_slab(const Members& members, const std::vector<Vec3>& x,
                  const std::vector<Vec3>& normals, const std::vector<double>& areas) {
  Slab slab;
  double area = 0.0;
  Vec3 mean_normal;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const int v : members) {
    const auto i = std::size_t(v);
    area += areas[i];
    slab.centre += areas[i] * x[i];
    mean_normal += areas[i] * normals[i];
    const Eigen::Vector3d n(normals[i].x, normals[i].y, normals[i].z);
    spread += areas[i] * n * n.transpose();
  }
  slab.centre = slab.centre / area;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread / area);
  const Eigen::Vector3d a = eigen.eigenvectors().col(0);
  slab.axis = normalized(Vec3{a.x(), a.y(), a.z()});
  double radius = 0.0;
  for (const int v : members) {
    const Vec3 d = x[std::size_t(v)] - slab.centre;
    radius += areas[std::size_t(v)] * norm(d - dot(d, slab.axis) * slab.axis);
  }
  slab.radius = radius / area;
  slab.ring = eigen.eigenvalues()(1) > kRingSpread * eigen.eigenvalues()(2) &&
              norm(mean_normal) < kRingMeanNormal * area;
  return slab;
}

// Connected pieces of a set of vertices, each in ascending order.
std::vector<Members> connected_pieces(const Members& set,
                                      const std::vector<std::vector<int>>& neighbors) {
  std::map<int, bool> open;
  for (const int v : set) open[v] = true;
  std::vector<Members> pieces;
  for (const int seed : set) {
    if (!open[seed]) continue;
    Members piece{seed};
    open[seed] = false;
    for (std::size_t i = 0; i < piece.size(); ++i)
      for (const int n : neighbors[std::size_t(piece[i])]) {
        const auto found = open.find(n);
        if (found == open.end() || !found->second) continue;
        found->second = false;
        piece.push_back(n);
      }
    std::sort(piece.begin(), piece.end());
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

Members with_one_ring(const Members& members, const std::vector<std::vector<int>>& neighbors) {
  Members wide = members;
  for (const int v : members)
    wide.insert(wide.end(), neighbors[std::size_t(v)].begin(), neighbors[std::size_t(v)].end());
  std::sort(wide.begin(), wide.end());
  wide.erase(std::unique(wide.begin(), wide.end()), wide.end());
  return wide;
}

double mean_edge(const TriangleMesh& mesh) {
  double sum = 0.0;
  const auto edges = unique_edges(mesh);
  for (const auto& e : edges)
    sum += distance(mesh.vertices[std::size_t(e[0])], mesh.vertices[std::size_t(e[1])]);
  return edges.empty() ? 0.0 : sum / double(edges.size());
}

class SlabCutter {
 public:
  explicit SlabCutter(const SimulationModel& model)
      : model_(model),
        neighbors_(vertex_neighbors(model.wall)),
        normals_(vertex_normals(model.wall)),
        areas_(vertex_areas(model.wall)),
        edge_(mean_edge(model.wall)) {}

  // Walks along each group: a slab is as long as its own radius, and the next one begins half a
  // slab further.
  std::vector<Members> cut() const {
    std::map<int, Members> groups;
    for (std::size_t v = 0; v < model_.wall.vertices.size(); ++v)
      groups[model_.wall_group[v]].push_back(int(v));
    std::vector<Members> slabs;
    for (const auto& [group, members] : groups) cut_group(members, slabs);
    return slabs;
  }

  const std::vector<double>& areas() const { return areas_; }
  Slab measure(const Members& members) const {
    Slab slab = measure_slab(members, model_.wall.vertices, normals_, areas_);
    // A piece of a ring lies too near its own centre, a flat piece too far: keep within reason.
    slab.radius =
        std::clamp(slab.radius, 0.2 * model_.reference_radius_mm, 3.0 * model_.reference_radius_mm);
    return slab;
  }

 private:
  Members window(const Members& members, double from, double to) const {
    Members inside;
    for (const int v : members) {
      const double s = model_.wall_abscissa[std::size_t(v)];
      if (s >= from && s <= to) inside.push_back(v);
    }
    return inside;
  }

  void cut_group(const Members& members, std::vector<Members>& slabs) const {
    double low = std::numeric_limits<double>::max(), high = -low;
    for (const int v : members) {
      low = std::min(low, model_.wall_abscissa[std::size_t(v)]);
      high = std::max(high, model_.wall_abscissa[std::size_t(v)]);
    }
    double from = low;
    for (;;) {
      double length = std::max(model_.reference_radius_mm, kLeastEdgesPerSlab * edge_);
      const Members probe = window(members, from, from + length);
      if (!probe.empty())
        length = std::max(std::min(length, measure(probe).radius), kLeastEdgesPerSlab * edge_);
      const bool last = from + length >= high;
      const double begin = last ? std::max(low, high - length) : from;
      for (const Members& piece :
           connected_pieces(window(members, begin, begin + length), neighbors_))
        slabs.push_back(with_one_ring(piece, neighbors_));
      if (last) return;
      from += 0.5 * length;
    }
  }

  const SimulationModel& model_;
  std::vector<std::vector<int>> neighbors_;
  std::vector<Vec3> normals_;
  std::vector<double> areas_;
  double edge_;
};

void index_by_vertex(std::size_t wall_count, WallSlabs& slabs) {
  slabs.slab_vertex_begin.assign(wall_count + 1, 0);
  for (const int v : slabs.vertex) ++slabs.slab_vertex_begin[std::size_t(v) + 1];
  for (std::size_t v = 0; v < wall_count; ++v)
    slabs.slab_vertex_begin[v + 1] += slabs.slab_vertex_begin[v];
  std::vector<int> next(slabs.slab_vertex_begin.begin(), slabs.slab_vertex_begin.end() - 1);
  slabs.slab_vertices.resize(slabs.vertex.size());
  for (std::size_t e = 0; e < slabs.vertex.size(); ++e)
    slabs.slab_vertices[std::size_t(next[std::size_t(slabs.vertex[e])]++)] = int(e);
}

// Offsets from the stiffness-weighted centre, so that the fitted translation is the centre.
void centre_offsets(const std::vector<Vec3>& x, WallSlabs& slabs) {
  for (int c = 0; c < slabs.count(); ++c) {
    const int begin = slabs.begin[std::size_t(c)], end = slabs.begin[std::size_t(c) + 1];
    Vec3 centre;
    double weight = 0.0;
    for (int e = begin; e < end; ++e) {
      const auto i = std::size_t(e);
      centre += slabs.stiffness[i] * x[std::size_t(slabs.vertex[i])];
      weight += slabs.stiffness[i];
    }
    centre = centre / weight;
    for (int e = begin; e < end; ++e)
      slabs.offset[std::size_t(e)] = x[std::size_t(slabs.vertex[std::size_t(e)])] - centre;
  }
}

// The quadratic columns of every slab's map.
void add_modes(WallSlabs& slabs) {
  for (int c = 0; c < slabs.count(); ++c) {
    const auto begin = slabs.begin[std::size_t(c)], end = slabs.begin[std::size_t(c) + 1];
    const std::vector<double> modes =
        quadratic_modes({slabs.offset.begin() + begin, slabs.offset.begin() + end},
                        {slabs.stiffness.begin() + begin, slabs.stiffness.begin() + end});
    slabs.modes.insert(slabs.modes.end(), modes.begin(), modes.end());
  }
}

// Of a wall around a lumen of this radius, t = 2 r a / (1 - 2 a) [mm].
double thickness_of(double radius, double ratio) {
  return 2.0 * radius * ratio / (1.0 - 2.0 * ratio);
}

// Each member's share of its vertex: falling from the middle of the slab to its ends along the
// axis, so that the goals, a mean over slabs by share, have no jump where a slab ends.
std::vector<double> shares_of(const Slab& slab, const Members& members,
                              const std::vector<Vec3>& x) {
  std::vector<double> shares;
  double reach = 0.0;
  for (const int v : members) {
    shares.push_back(std::abs(dot(x[std::size_t(v)] - slab.centre, slab.axis)));
    reach = std::max(reach, shares.back());
  }
  for (double& share : shares) share = kLeastShare + (reach > 0.0 ? 1.0 - share / reach : 0.0);
  return shares;
}

// Wall and plaque between a lumen of the slab's radius and the healthy vessel's outside, per
// circumference of the lumen [mm].
double tissue_depth(double radius, double healthy_radius, double thickness) {
  return thickness +
         std::max(0.0, healthy_radius * healthy_radius - radius * radius) / (2.0 * radius);
}

// WallSlabs::along, once stiffness and offsets are there.
void stiffen_along(double healthy_radius, double ratio, WallSlabs& slabs) {
  constexpr double kPoisson = 0.48;  // nearly incompressible; 0.45 to 0.49 give the same vessel
  constexpr double kConfined =
      (1.0 - kPoisson) / ((1.0 + kPoisson) * (1.0 - 2.0 * kPoisson));  // M / E
  for (int c = 0; c < slabs.count(); ++c) {
    const auto i = std::size_t(c);
    double weight = 0.0, spread = 0.0;
    for (int e = slabs.begin[i]; e < slabs.begin[i + 1]; ++e) {
      const double off = dot(slabs.offset[std::size_t(e)], slabs.axis[i]);
      weight += slabs.stiffness[std::size_t(e)];
      spread += slabs.stiffness[std::size_t(e)] * off * off;
    }
    const double radius = slabs.radius[i], thickness = thickness_of(radius, ratio);
    slabs.along.push_back(slabs.ring[i]
                              ? kConfined * tissue_depth(radius, healthy_radius, thickness) /
                                    thickness * radius * radius * weight / spread
                              : 0.0);
  }
}

// Divides each vertex's stiffness over its slabs, in proportion to the shares.
void divide_stiffness(const std::vector<double>& shares, WallSlabs& slabs) {
  for (std::size_t v = 0; v + 1 < slabs.slab_vertex_begin.size(); ++v) {
    double whole = 0.0;
    for (int n = slabs.slab_vertex_begin[v]; n < slabs.slab_vertex_begin[v + 1]; ++n)
      whole += shares[std::size_t(slabs.slab_vertices[std::size_t(n)])];
    for (int n = slabs.slab_vertex_begin[v]; n < slabs.slab_vertex_begin[v + 1]; ++n) {
      const auto e = std::size_t(slabs.slab_vertices[std::size_t(n)]);
      slabs.stiffness[e] *= shares[e] / whole;
    }
  }
}

}  // namespace

WallSlabs make_slabs(const SimulationModel& model, const WallMaterial& material) {
  WallSlabs slabs;
  slabs.begin.push_back(0);
  const std::size_t wall_count = model.wall.vertices.size();
  if (wall_count == 0) {
    slabs.slab_vertex_begin.push_back(0);
    return slabs;
  }
  const SlabCutter cutter(model);
  const double modulus = units::pascal_from_kilopascal(material.modulus_kpa);
  const double ratio = material.thickness_ratio;
  std::vector<double> shares;  // per entry
  for (const Members& members : cutter.cut()) {
    const Slab slab = cutter.measure(members);
    const double thickness = thickness_of(slab.radius, ratio);
    const std::vector<double> slab_shares = shares_of(slab, members, model.wall.vertices);
    shares.insert(shares.end(), slab_shares.begin(), slab_shares.end());
    for (const int v : members) {
      slabs.vertex.push_back(v);
      slabs.slab_of.push_back(slabs.count());
      slabs.stiffness.push_back(modulus * thickness * cutter.areas()[std::size_t(v)] /
                                (slab.radius * slab.radius));
    }
    slabs.radius.push_back(slab.radius);
    slabs.axis.push_back(slab.axis);
    slabs.ring.push_back(char(slab.ring));
    slabs.begin.push_back(int(slabs.vertex.size()));
  }
  index_by_vertex(wall_count, slabs);
  divide_stiffness(shares, slabs);
  slabs.offset.resize(slabs.vertex.size());
  centre_offsets(model.wall.vertices, slabs);
  stiffen_along(model.reference_radius_mm, ratio, slabs);
  if (material.shape == WallShape::quadratic) add_modes(slabs);
  return slabs;
}

}  // namespace angio::simulation::detail
