#include "meshing/detail/contact_region.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "air_mesh/build/whole_piece.hpp"
#include "core/error.hpp"
#include "meshing/detail/nearest_line.hpp"
#include "meshing/detail/remesh.hpp"

namespace angio::meshing::detail {
namespace {

/// A section across a line: what lies past it is out.
struct Section {
  Plane plane;            ///< its normal leaves the region
  double abscissa = 0.0;  ///< [mm] of its place on the line
  double radius = 0.0;    ///< of the lumen there [mm]
};

Section section_at(const CenterlinePath& path, double abscissa, double direction) {
  const CenterlineSample at = sample(path, abscissa);
  // The mean direction over a radius: a section must not follow every kink of the line.
  const double reach = 0.5 * at.inscribed_radius;
  const Vec3 along =
      normalized(sample(path, abscissa + reach).point - sample(path, abscissa - reach).point);
  return {{at.point, direction * (norm_squared(along) > 0.0 ? along : at.tangent)},
          abscissa,
          at.inscribed_radius};
}

/// Where a path leaves the main one.
struct Fork {
  bool leaves = false;     ///< false: the path is the main one or has no point in common
  double shared_to = 0.0;  ///< abscissa of the last shared point [mm], the same on both paths
  double mouth = 0.0;      ///< on the branch: where its line leaves the main lumen [mm]
  double zone_first = 0.0, zone_last = 0.0;  ///< on the main path: a section here cuts both [mm]
};

Fork find_fork(const CenterlinePath& branch, const CenterlinePath& main) {
  Fork fork;
  const int shared = shared_point_count(branch, main);
  fork.leaves =
      shared > 0 && shared < int(branch.points.size()) && shared < int(main.points.size());
  if (shared > 0) fork.shared_to = branch.abscissa[std::size_t(shared) - 1];
  if (!fork.leaves) return fork;
  const double last = branch.abscissa.back();
  const double radius = sample(main, fork.shared_to).inscribed_radius;
  const double step = 0.1 * std::max(radius, 1e-3);
  for (fork.mouth = fork.shared_to; fork.mouth < last; fork.mouth += step) {
    const Vec3 point = sample(branch, fork.mouth).point;
    const CenterlineSample on_main = sample(main, project(main, point));
    if (distance(point, on_main.point) > on_main.inscribed_radius) break;
  }
  fork.mouth = std::min(fork.mouth, last);
  const double mouth_on_main = project(main, sample(branch, fork.mouth).point);
  fork.zone_first = fork.shared_to - 0.5 * radius;
  fork.zone_last = mouth_on_main + sample(main, mouth_on_main).inscribed_radius;
  return fork;
}

/// Moves the end sections out of forks, where no plane cuts across one vessel only.
RegionExtent avoid_forks(RegionExtent extent, const std::vector<Fork>& forks) {
  for (bool moved = true; moved;) {
    moved = false;
    for (const Fork& fork : forks) {
      if (!fork.leaves) continue;
      const auto in_zone = [&](double s) { return s > fork.zone_first && s < fork.zone_last; };
      if (in_zone(extent.first_abscissa)) {
        extent.first_abscissa = fork.zone_first;
        moved = true;
      }
      if (in_zone(extent.last_abscissa)) {
        extent.last_abscissa = fork.zone_last;
        moved = true;
      }
    }
  }
  return extent;
}

class RegionTest {
 public:
  RegionTest(const CenterlineTree& tree, const RegionExtent& wished) : path_(wished.path) {
    for (const CenterlinePath& path : tree.paths) forks_.push_back(find_fork(path, *wished.path));
    const RegionExtent extent = avoid_forks(wished, forks_);
    main_ = section_at(*extent.path, extent.first_abscissa, -1.0);
    far_ = section_at(*extent.path, extent.last_abscissa, 1.0);
    for (std::size_t p = 0; p < tree.paths.size(); ++p) {
      const CenterlinePath& path = tree.paths[p];
      const Fork& fork = forks_[p];
      Branch branch;
      branch.shared_to = fork.leaves ? fork.shared_to : path.abscissa.back() + 1.0;
      branch.inside = fork.leaves && fork.shared_to >= extent.first_abscissa &&
                      fork.shared_to <= extent.last_abscissa;
      if (branch.inside)
        branch.end = section_at(path, branch_end(tree, path, *wished.path, fork), 1.0);
      branches_.push_back(branch);
    }
  }

  [[nodiscard]] bool inside(const Vec3& point, const LinePlace& place) const {
    const Branch& branch = branches_[std::size_t(place.path)];
    const bool on_main = place.abscissa <= branch.shared_to;
    if (on_main)
      return !past(main_, point, main_.abscissa - place.abscissa) &&
             !past(far_, point, place.abscissa - far_.abscissa);
    if (!branch.inside) return is_fused_wall(point);
    return !past(branch.end, point, place.abscissa - branch.end.abscissa);
  }

 private:
  /// @param ahead  how far the nearest place of the line lies past the section [mm]
  static bool past(const Section& section, const Vec3& point, double ahead) {
    const double near = 2.0 * section.radius;
    if (std::abs(ahead) > near) return ahead > 0.0;
    return section.plane.signed_distance(point) > 0.0;
  }

  /// A vessel that leaves elsewhere may be fused with the main one here (by the scan's blur, or as
  /// a loop). The wall ends then not halfway between the two lines, but out of the balloon's way.
  [[nodiscard]] bool is_fused_wall(const Vec3& point) const {
    constexpr double kReach = 1.5;  // radii from the line
    const double abscissa = project(*path_, point);
    const CenterlineSample at = sample(*path_, abscissa);
    return distance(point, at.point) < kReach * at.inscribed_radius &&
           !past(main_, point, main_.abscissa - abscissa) &&
           !past(far_, point, abscissa - far_.abscissa);
  }

  /// One diameter past a branch's mouth, and past forks of its own there.
  static double branch_end(const CenterlineTree& tree, const CenterlinePath& branch,
                           const CenterlinePath& main, const Fork& fork) {
    const int shared = shared_point_count(branch, main);
    double end = fork.mouth + 2.0 * sample(branch, fork.mouth).inscribed_radius;
    std::vector<Fork> own_forks;
    for (const CenterlinePath& other : tree.paths)
      if (shared_point_count(other, branch) > shared) own_forks.push_back(find_fork(other, branch));
    for (bool moved = true; moved;) {
      moved = false;
      for (const Fork& own : own_forks)
        if (own.leaves && end > own.zone_first && end < own.zone_last) {
          end = own.zone_last;
          moved = true;
        }
    }
    return std::min(end, branch.abscissa.back());
  }

  struct Branch {
    double shared_to = 0.0;  ///< up to here the path is the main one [mm]
    bool inside = false;     ///< does it leave between the sections?
    Section end;
  };

  const CenterlinePath* path_;
  Section main_, far_;
  std::vector<Fork> forks_;
  std::vector<Branch> branches_;
};

/// Compacts the vertices that triangles use and copies their data from `source`.
ContactRegion compact(const std::vector<Triangle>& triangles, const ContactRegion& source) {
  std::vector<int> index(source.mesh.vertices.size(), -1);
  for (const Triangle& t : triangles)
    for (const int v : t) index[std::size_t(v)] = 0;
  ContactRegion region;
  for (std::size_t v = 0; v < index.size(); ++v) {
    if (index[v] < 0) continue;
    index[v] = int(region.mesh.vertices.size());
    region.mesh.vertices.push_back(source.mesh.vertices[v]);
    region.lumen_vertex.push_back(source.lumen_vertex[v]);
    region.abscissa.push_back(source.abscissa[v]);
    region.group.push_back(source.group[v]);
  }
  for (const Triangle& t : triangles)
    region.mesh.triangles.push_back(
        {index[std::size_t(t[0])], index[std::size_t(t[1])], index[std::size_t(t[2])]});
  region.fixed.assign(region.mesh.vertices.size(), 0);
  for (const auto& loop : boundary_loops(region.mesh))
    for (const int v : loop) region.fixed[std::size_t(v)] = 1;
  return region;
}

/// Vertices inside the sections that hang together with those nearest to the seeds.
std::vector<char> propagate(const TriangleMesh& mesh, const std::vector<char>& inside,
                            const std::vector<Vec3>& seeds) {
  std::vector<char> reached(mesh.vertices.size(), 0);
  std::vector<int> stack;
  for (const Vec3& seed : seeds) {
    int best = -1;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
      if (inside[v] && (best < 0 || norm_squared(mesh.vertices[v] - seed) <
                                        norm_squared(mesh.vertices[std::size_t(best)] - seed)))
        best = int(v);
    if (best < 0 || reached[std::size_t(best)]) continue;
    reached[std::size_t(best)] = 1;
    stack.push_back(best);
  }
  const auto neighbors = vertex_neighbors(mesh);
  while (!stack.empty()) {
    const int v = stack.back();
    stack.pop_back();
    for (const int u : neighbors[std::size_t(v)]) {
      if (!inside[std::size_t(u)] || reached[std::size_t(u)]) continue;
      reached[std::size_t(u)] = 1;
      stack.push_back(u);
    }
  }
  return reached;
}

}  // namespace

ContactRegion extract_region(const TriangleMesh& open_lumen, const CenterlineTree& tree,
                             const RegionExtent& extent, const std::vector<Vec3>& seeds) {
  const NearestLine lines(tree);
  const RegionTest test(tree, extent);
  ContactRegion whole;  // every vertex of the lumen, with its data
  whole.mesh.vertices = open_lumen.vertices;
  std::vector<char> inside;
  for (std::size_t v = 0; v < open_lumen.vertices.size(); ++v) {
    const LinePlace place = lines.find(open_lumen.vertices[v]);
    inside.push_back(test.inside(open_lumen.vertices[v], place) ? 1 : 0);
    whole.lumen_vertex.push_back(int(v));
    whole.abscissa.push_back(0.0);
    whole.group.push_back(place.group_id);
  }
  const std::vector<char> reached = propagate(open_lumen, inside, seeds);
  std::vector<Triangle> triangles;
  for (const Triangle& t : open_lumen.triangles)
    if (reached[std::size_t(t[0])] && reached[std::size_t(t[1])] && reached[std::size_t(t[2])])
      triangles.push_back(t);
  air_mesh::make_whole(triangles, open_lumen.vertices.size());
  if (triangles.empty())
    throw InputError(
        "there is no wall around the balloon (the line does not run inside the mesh "
        "there). Run the stages centerline and meshing again");
  ContactRegion region = compact(triangles, whole);
  for (std::size_t v = 0; v < region.abscissa.size(); ++v)
    region.abscissa[v] = project(*extent.path, region.mesh.vertices[v]);
  return region;
}

ContactRegion with_triangles(const ContactRegion& region, const std::vector<Triangle>& triangles) {
  return compact(triangles, region);
}

}  // namespace angio::meshing::detail
