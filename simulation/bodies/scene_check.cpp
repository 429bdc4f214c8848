#include "simulation/bodies/scene_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string>

#include "core/error.hpp"
#include "core/units.hpp"

namespace angio::simulation::detail {
namespace {

// A triangle's height over its longest edge, below which it is a line.
constexpr double kLeastHeight = 1e-7;

std::string number(std::size_t i) { return std::to_string(i); }

std::string vertex_of(const std::string& surface, std::size_t v) {
  return "vertex " + number(v) + " of the " + surface;
}

[[noreturn]] void refuse(const std::string& what) {
  throw InputError(what + ". Run the stage meshing again, or repair the surface");
}

void check_numbers(const std::vector<Vec3>& points, const std::string& surface) {
  for (std::size_t v = 0; v < points.size(); ++v)
    if (!std::isfinite(points[v].x) || !std::isfinite(points[v].y) || !std::isfinite(points[v].z))
      refuse(vertex_of(surface, v) + " is not a number (it has no place)");
}

void check_corners(const TriangleMesh& mesh, const std::string& surface) {
  const int count = int(mesh.vertices.size());
  std::vector<char> used(mesh.vertices.size(), 0);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    for (const int v : t) {
      if (v < 0 || v >= count)
        refuse("triangle " + number(i) + " of the " + surface + " has a corner " +
               std::to_string(v) + " that does not exist (there are " + std::to_string(count) +
               " vertices)");
      used[std::size_t(v)] = 1;
    }
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
      refuse("triangle " + number(i) + " of the " + surface +
             " has the same corner twice (it has no area)");
  }
  const auto loose = std::find(used.begin(), used.end(), char(0));
  if (loose != used.end())
    refuse(vertex_of(surface, std::size_t(loose - used.begin())) +
           " is in no triangle (nothing would hold it)");
}

void check_places(const TriangleMesh& mesh, const std::string& surface) {
  std::vector<std::size_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  const auto key = [&](std::size_t v) {
    const Vec3& p = mesh.vertices[v];
    return std::array{p.x, p.y, p.z};
  };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return key(a) != key(b) ? key(a) < key(b) : a < b;
  });
  for (std::size_t i = 1; i < order.size(); ++i)
    if (key(order[i]) == key(order[i - 1]))
      refuse("vertices " + number(order[i - 1]) + " and " + number(order[i]) + " of the " +
             surface + " lie on the same point (the surface is torn or folded there)");
}

void check_areas(const TriangleMesh& mesh, const std::vector<Vec3>& x, const std::string& surface) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    const Vec3 a = x[std::size_t(t[1])] - x[std::size_t(t[0])],
               b = x[std::size_t(t[2])] - x[std::size_t(t[0])];
    const double longest = std::max({norm_squared(a), norm_squared(b), norm_squared(b - a)});
    if (!(norm(cross(a, b)) > kLeastHeight * longest))
      refuse("triangle " + number(i) + " of the " + surface +
             " has no area (its strain is undefined)");
  }
}

void check_one_piece(const TriangleMesh& mesh, const std::string& surface) {
  std::vector<int> root(mesh.vertices.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int v) {
    while (root[std::size_t(v)] != v)
      v = root[std::size_t(v)] = root[std::size_t(root[std::size_t(v)])];
    return v;
  };
  for (const Triangle& t : mesh.triangles)
    for (const int v : t) root[std::size_t(find(v))] = find(t[0]);
  for (std::size_t v = 1; v < root.size(); ++v)
    if (find(int(v)) != find(0))
      refuse("the " + surface + " is in pieces: vertex " + number(v) +
             " is not joined to vertex 0 (only one connected piece can be simulated)");
}

// Every edge is run through once in each direction.
void check_closed(const TriangleMesh& mesh, const std::string& surface) {
  struct Side {
    int from, to;
    std::size_t triangle;
  };
  const auto before = [](const Side& a, const Side& b) {
    return std::pair{a.from, a.to} < std::pair{b.from, b.to};
  };
  std::vector<Side> sides;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      sides.push_back({mesh.triangles[i][k], mesh.triangles[i][(k + 1) % 3], i});
  std::stable_sort(sides.begin(), sides.end(), before);
  const auto edge = [](const Side& s) {
    return "the edge between vertices " + std::to_string(s.from) + " and " + std::to_string(s.to);
  };
  for (std::size_t i = 1; i < sides.size(); ++i)
    if (!before(sides[i - 1], sides[i]))
      refuse("triangles " + number(sides[i - 1].triangle) + " and " + number(sides[i].triangle) +
             " of the " + surface + " do not agree at " + edge(sides[i]) +
             " (one is turned over, or more than two meet)");
  for (const Side& s : sides)
    if (!std::binary_search(sides.begin(), sides.end(), Side{s.to, s.from, 0}, before))
      refuse("the " + surface + " is open at " + edge(s) + " of triangle " + number(s.triangle) +
             " (it could not hold gas)");
}

void check_outward(TriangleMesh mesh, const std::vector<Vec3>& x, const std::string& surface) {
  mesh.vertices = x;
  const double volume = enclosed_volume(mesh);
  if (volume > 0.0) return;
  char text[300];
  std::snprintf(text, sizeof text,
                "the %s is inside out: it encloses %.4g mm3 (its triangles must turn "
                "counter-clockwise seen from outside; triangle 0 is %d, %d, %d). Turn every "
                "triangle over, or run the stage meshing again",
                surface.c_str(), volume, mesh.triangles[0][0], mesh.triangles[0][1],
                mesh.triangles[0][2]);
  throw InputError(text);
}

// How often the surface goes around a point: 1 inside, 0 outside (van Oosterom, Strackee 1983).
double winding_number(const TriangleMesh& mesh, const Vec3& point) {
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[std::size_t(t[0])] - point,
               b = mesh.vertices[std::size_t(t[1])] - point,
               c = mesh.vertices[std::size_t(t[2])] - point;
    const double la = norm(a), lb = norm(b), lc = norm(c);
    sum += std::atan2(dot(a, cross(b, c)),
                      la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (2.0 * units::kPi);
}

// A wire comes in through one end of the balloon and leaves through the other: between the first
// and the last of its points inside, all are.
void check_guidewire(const SimulationModel& model) {
  const std::vector<Vec3>& wire = model.guidewire;
  if (wire.empty()) return;
  std::vector<char> inside;  // nodes and the middles between them
  for (std::size_t i = 0; i < 2 * wire.size() - 1; ++i) {
    const Vec3 p = 0.5 * (wire[i / 2] + wire[(i + 1) / 2]);
    inside.push_back(char(winding_number(model.balloon, p) > 0.5));
  }
  const auto first = std::find(inside.begin(), inside.end(), char(1));
  if (first == inside.end())
    refuse("the guidewire lies outside the balloon from node 0 to node " + number(wire.size() - 1) +
           " (it must run through the balloon)");
  const auto last = std::find(inside.rbegin(), inside.rend(), char(1)).base();
  const auto out = std::find(first, last, char(0));
  if (out != last)
    refuse("the guidewire leaves the balloon through its side at node " +
           number(std::size_t(out - inside.begin() + 1) / 2) +
           " (it must run from one end of the balloon to the other)");
}

void check_sliding(const SimulationModel& model) {
  bool is_sound = model.balloon_sliding.size() == model.balloon_fixed.size();
  for (std::size_t v = 0; v < model.balloon_sliding.size() && is_sound; ++v)
    is_sound = model.balloon_sliding[v] == 0 || model.balloon_fixed[v] != 0;
  if (is_sound) return;
  throw InputError(
      "the balloon's sliding flags do not match its fixed ones (only what is tied to the shaft can "
      "slide along it). Run the stage meshing again");
}

void check_balloon(const SimulationModel& model) {
  const TriangleMesh& mesh = model.balloon;
  if (mesh.vertices.empty() || mesh.triangles.empty())
    throw InputError("the model has no balloon (nothing to inflate). Run the stage meshing again");
  if (model.balloon_rest.size() != mesh.vertices.size() ||
      model.balloon_fixed.size() != mesh.vertices.size())
    throw InputError(
        "the balloon's rest shape or fixed flags do not match its vertices (the files belong to "
        "different runs). Run the stage meshing again");
  if (!model.balloon_sliding.empty()) check_sliding(model);
  check_numbers(mesh.vertices, "balloon");
  check_numbers(model.balloon_rest, "balloon's rest shape");
  check_numbers(model.guidewire, "guidewire");
  check_corners(mesh, "balloon");
  check_places(mesh, "balloon");
  check_closed(mesh, "balloon");
  check_one_piece(mesh, "balloon");
  check_areas(mesh, mesh.vertices, "balloon");
  check_areas(mesh, model.balloon_rest, "balloon's rest shape");
  check_outward(mesh, mesh.vertices, "balloon");
  check_outward(mesh, model.balloon_rest, "balloon's rest shape");
  check_guidewire(model);
}

void check_wall(const SimulationModel& model, const WallMaterial& material) {
  const std::size_t count = model.wall.vertices.size();
  if (model.wall_fixed.size() != count || model.wall_abscissa.size() != count ||
      model.wall_group.size() != count)
    throw InputError(
        "the wall's arrays do not match its vertices (the files belong to different runs). Run the "
        "stage meshing again");
  if (count == 0) return;
  check_numbers(model.wall.vertices, "wall");
  for (std::size_t v = 0; v < count; ++v)
    if (!std::isfinite(model.wall_abscissa[v]))
      refuse(vertex_of("wall", v) + " has an abscissa that is not a number (it is in no slab)");
  check_corners(model.wall, "wall");
  check_places(model.wall, "wall");
  check_areas(model.wall, model.wall.vertices, "wall");
  check_one_piece(model.wall, "wall");
  if (material.foundation_kpa_per_mm > 0.0) return;
  if (std::none_of(model.wall_fixed.begin(), model.wall_fixed.end(),
                   [](char fixed) { return fixed != 0; }))
    throw InputError(
        "nothing holds the wall: no vertex is fixed and the foundation is zero (it would be pushed "
        "away). Fix its rims, or set wall.foundation_kpa_per_mm");
}

void check_rest(const SimulationModel& model) {
  const int count = int(model.balloon.vertices.size() + model.wall.vertices.size());
  for (std::size_t i = 0; i < model.air.size(); ++i)
    for (const int v : model.air[i])
      if (v < 0 || v >= count)
        refuse("tetrahedron " + number(i) + " of the air mesh has a corner " + std::to_string(v) +
               " that does not exist (the files belong to different runs)");
  check_numbers({model.measure_point, model.measure_tangent}, "place of measurement");
  for (const WatchedPlace& end : model.balloon_ends)
    check_numbers({end.point, end.tangent}, "place of measurement");
  if (!(model.reference_radius_mm > 0.0) || !std::isfinite(model.reference_radius_mm))
    throw InputError("the reference radius is " + std::to_string(model.reference_radius_mm) +
                     " mm (the vessel's size is unknown). Give the radius of the healthy vessel");
}

}  // namespace

void check_model(const SimulationModel& model, const WallMaterial& wall) {
  check_balloon(model);
  check_wall(model, wall);
  check_rest(model);
}

}  // namespace angio::simulation::detail
