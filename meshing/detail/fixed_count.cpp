#include "meshing/detail/fixed_count.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/units.hpp"
#include "meshing/detail/surface_editor.hpp"

namespace angio::meshing::detail {
namespace {

using Edge = SurfaceEditor::Edge;

/// Edges off the rims by their length over the wanted one, the least first.
std::vector<std::pair<double, Edge>> inner_edges(const SurfaceEditor& editor) {
  std::vector<std::pair<double, Edge>> edges;
  for (const Edge e : editor.mesh().edges())
    if (editor.rim(editor.mesh().vertex(e, 0)) < 0 && editor.rim(editor.mesh().vertex(e, 1)) < 0)
      edges.emplace_back(editor.length(e) / editor.wanted_length(e), e);
  std::sort(edges.begin(), edges.end());
  return edges;
}

/// Whether no corner of the two triangles at an edge has been worked on in this round; if so, they
/// are from now on.
class Untouched {
 public:
  explicit Untouched(const SurfaceEditor& editor)
      : editor_(editor), touched_(editor.mesh().number_of_vertices(), 0) {}
  bool claim(Edge e) {
    const auto& mesh = editor_.mesh();
    const auto h = mesh.halfedge(e);
    const SurfaceEditor::Vertex corners[] = {mesh.source(h), mesh.target(h),
                                             mesh.target(mesh.next(h)),
                                             mesh.target(mesh.next(mesh.opposite(h)))};
    for (const auto v : corners)
      if (v.idx() >= touched_.size() || touched_[v.idx()]) return false;
    for (const auto v : corners) touched_[v.idx()] = 1;
    return true;
  }

 private:
  const SurfaceEditor& editor_;
  std::vector<char> touched_;
};

/// One round of steps far from each other. @return how many were made
int split_longest(SurfaceEditor& editor, int most) {
  auto edges = inner_edges(editor);
  Untouched untouched(editor);
  int made = 0;
  for (auto edge = edges.rbegin(); edge != edges.rend() && made < most; ++edge) {
    if (!untouched.claim(edge->second)) continue;
    editor.split(edge->second);
    ++made;
  }
  return made;
}

int collapse_shortest(SurfaceEditor& editor, int most) {
  constexpr double kLongest = 2.0;
  const double least_sine_squared = sine_squared_of_degrees(15.0);
  const auto edges = inner_edges(editor);
  int made = 0;
  Untouched untouched(editor);
  for (std::size_t i = 0; i < edges.size() && made < most; ++i) {
    const Edge e = edges[i].second;
    if (editor.mesh().is_removed(e) || !untouched.claim(e)) continue;
    if (editor.collapse(e, kLongest, least_sine_squared)) ++made;
  }
  return made;
}

}  // namespace

void aim_at_count(SurfaceDraft& draft, int triangle_count) {
  double expected = 0.0;  // of equilateral triangles
  for (const Triangle& t : draft.mesh.triangles) {
    double length = 0.0;
    for (const int v : t) length += draft.edge_length[std::size_t(v)] / 3.0;
    expected +=
        0.5 * norm(area_vector_doubled(draft.mesh, t)) / (0.25 * std::sqrt(3.0) * length * length);
  }
  const double scale = std::sqrt(expected / triangle_count);
  for (double& length : draft.edge_length) length *= scale;
}

void fit_count(SurfaceDraft& draft, const SurfaceTarget& target, int triangle_count) {
  constexpr int kRounds = 60;
  SurfaceEditor editor(draft, &target, {});
  int missing = (triangle_count - int(draft.mesh.triangles.size())) / 2;
  // Few at a time, so that each step meets the longest or shortest edge there is.
  for (int round = 0; round < kRounds && missing != 0; ++round) {
    const int most = std::max(1, std::abs(missing) / 4);
    missing += missing > 0 ? -split_longest(editor, most) : collapse_shortest(editor, most);
  }
  editor.store();
  if (int(draft.mesh.triangles.size()) != triangle_count)
    throw InputError("the lumen could not be meshed with exactly the triangles asked for (" +
                     std::to_string(draft.mesh.triangles.size()) + " instead of " +
                     std::to_string(triangle_count) +
                     "; each step changes two). Choose another mesh.triangle_count");
}

int closing_triangle_count(const TriangleMesh& open) {
  int count = kInletSides;  // a ring of triangles has one at each of its edges
  for (const std::vector<int>& loop : boundary_loops(open)) count += int(loop.size());
  return count;
}

namespace {

/// The rim's vertices in order, seen from outside as a cap's border.
std::vector<int> inlet_rim(const LumenMesh& lumen) {
  for (std::vector<int>& loop : boundary_loops(lumen.open))
    if (lumen.inlet_outlet_id[std::size_t(loop.front())] == 1) return std::move(loop);
  throw InputError(
      "the lumen's inlet stays closed, because the lumen there is too fine to be shown, and "
      "mesh.triangle_count needs it open. Name another inlet with --inlet, or leave "
      "mesh.triangle_count out");
}

/// Triangles between the rim and a polygon of fewer sides inside it, both running the same way.
std::vector<Triangle> join_rings(const std::vector<int>& outer, const std::vector<int>& inner) {
  std::vector<Triangle> ring;
  std::size_t o = 0, i = 0;
  const double step_o = 1.0 / double(outer.size()), step_i = 1.0 / double(inner.size());
  while (o < outer.size() || i < inner.size()) {
    const int a = outer[o % outer.size()], b = inner[i % inner.size()];
    if (i == inner.size() || (o < outer.size() && double(o + 1) * step_o <= double(i + 1) * step_i))
      ring.push_back({a, outer[++o % outer.size()], b});
    else
      ring.push_back({a, inner[++i % inner.size()], b});
  }
  return ring;
}

}  // namespace

void close_but_inlet(LumenMesh& lumen) {
  const std::vector<int> rim = inlet_rim(lumen);
  const TriangleMesh& open = lumen.open;
  // The vertices of the inlet's cap go last.
  TriangleMesh closed = lumen.capped;
  std::vector<int> id = lumen.inlet_outlet_id;
  std::size_t inlet_hub = open.vertices.size();
  while (id[inlet_hub] != 1) ++inlet_hub;
  const Vec3 middle = closed.vertices[inlet_hub];
  const auto is_inlets = [&](const Triangle& t) {
    return std::any_of(t.begin(), t.end(), [&](int v) { return std::size_t(v) == inlet_hub; });
  };
  std::erase_if(closed.triangles, is_inlets);
  closed.vertices.erase(closed.vertices.begin() + std::ptrdiff_t(inlet_hub));
  id.erase(id.begin() + std::ptrdiff_t(inlet_hub));
  for (Triangle& t : closed.triangles)
    for (int& v : t)
      if (std::size_t(v) > inlet_hub) --v;

  std::vector<int> inner;
  for (int side = 0; side < kInletSides; ++side) {
    // At equal shares of the rim, halfway to the middle.
    const double place = double(side) / kInletSides * double(rim.size());
    const auto before = std::size_t(place);
    const Vec3& a = open.vertices[std::size_t(rim[before % rim.size()])];
    const Vec3& b = open.vertices[std::size_t(rim[(before + 1) % rim.size()])];
    inner.push_back(int(closed.vertices.size()));
    closed.vertices.push_back(middle + 0.5 * (a + (place - double(before)) * (b - a) - middle));
    id.push_back(1);
  }
  const std::vector<Triangle> ring = join_rings(rim, inner);
  closed.triangles.insert(closed.triangles.end(), ring.begin(), ring.end());
  lumen.open = closed;
  for (std::size_t side = 0; side < inner.size(); ++side)
    closed.triangles.push_back(
        {inner[side], inner[(side + 1) % inner.size()], int(closed.vertices.size())});
  closed.vertices.push_back(middle);
  id.push_back(1);
  lumen.capped = std::move(closed);
  lumen.inlet_outlet_id = std::move(id);
}

}  // namespace angio::meshing::detail
