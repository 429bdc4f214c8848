#include "meshing/wall_layers.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numeric>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "meshing/detail/healthy_vessel.hpp"
#include "meshing/detail/untangle_wedges.hpp"
#include "meshing/detail/wall_columns.hpp"

namespace angio::meshing {
namespace {

using detail::WallColumn;

constexpr double kGoodShape = 0.05;   // of a wedge, see untangle
constexpr double kLeastShape = 0.02;  // a worse one is drawn out where the wall is widened
constexpr double kLeastShare = 0.25;  // of the wanted way outward; untangling shortens none further
constexpr double kLeastHold = 1.0 / 3.0;  // of a vertex's angle, that must have layers
constexpr double kLimitedShare = 0.9;     // of the wanted thickness; less is told

/// The layers of elements, from the lumen outward. Where there is no plaque, its elements are the
/// innermost of the intima, so that every column has as many.
struct ElementLayers {
  int plaque = 0;                 ///< elements
  int per_layer = 1;              ///< elements
  std::array<double, 3> share{};  ///< of the wall's thickness, to the outside of each layer

  [[nodiscard]] int count() const { return plaque + 3 * per_layer; }
  /// The thickness that the plaque's elements have as intima.
  [[nodiscard]] double least_plaque(const WallColumn& column) const {
    return share[0] * column.thickness * plaque / (plaque + per_layer);
  }
  [[nodiscard]] double depth(const WallColumn& column, int level) const {
    const double inner = std::max(column.plaque, least_plaque(column));
    if (level <= plaque) return plaque > 0 ? inner * level / plaque : 0.0;
    const auto layer = std::size_t((level - plaque - 1) / per_layer);
    const double t = double(level - plaque - int(layer) * per_layer) / per_layer;
    const auto outside = [&](std::size_t of) {
      return column.plaque + share[of] * column.thickness;
    };
    const double from = layer == 0 ? inner : outside(layer - 1);
    return (1.0 - t) * from + t * outside(layer);
  }
};

ElementLayers element_layers(const WallLayerOptions& options, bool has_plaque) {
  ElementLayers layers;
  layers.plaque = has_plaque ? options.plaque_elements : 0;
  layers.per_layer = options.elements_per_layer;
  const auto& f = options.layer_fractions;
  const double sum = f[0] + f[1] + f[2];
  layers.share = {f[0] / sum, (f[0] + f[1]) / sum, 1.0};
  return layers;
}

/// Plaque that is no thicker than the part of the intima that would stand for it is none.
bool has_plaque(const std::vector<WallColumn>& columns, const WallLayerOptions& options) {
  const ElementLayers layers = element_layers(options, true);
  return std::any_of(columns.begin(), columns.end(), [&](const WallColumn& column) {
    return column.plaque > layers.least_plaque(column);
  });
}

WallTissue tissue_at(const ElementLayers& layers, const std::vector<WallColumn>& columns,
                     const Triangle& triangle, int layer) {
  if (layer >= layers.plaque) return WallTissue((layer - layers.plaque) / layers.per_layer);
  double excess = 0.0;
  for (const int v : triangle) {
    const WallColumn& column = columns[std::size_t(v)];
    excess += column.plaque - layers.least_plaque(column);
  }
  return excess > 0.0 ? WallTissue::plaque : WallTissue::intima;
}

/// The vessel's direction, or an edge's where the surface faces along the vessel: fibres lie in it.
Vec3 within_layer(const Vec3& tangent, const Vec3& normal, const Vec3& edge) {
  constexpr double kLeastSine = 0.05;
  return norm(cross(tangent, normal)) > kLeastSine ? tangent : normalized(edge);
}

WallLayers stack_wedges(const ContactRegion& region, const std::vector<WallColumn>& columns,
                        const ElementLayers& layers, const detail::HealthyVessel& healthy) {
  const TriangleMesh& lumen = region.mesh;
  const int count = int(lumen.vertices.size());
  WallLayers wall;
  wall.lumen_vertex_count = count;
  wall.element_layer_count = layers.count();
  for (int level = 0; level <= layers.count(); ++level)
    for (int v = 0; v < count; ++v) {
      const WallColumn& column = columns[std::size_t(v)];
      const Vec3& inside = lumen.vertices[std::size_t(v)];
      wall.vertices.push_back(
          level == 0
              ? inside
              : inside + column.room * (place_at(column, layers.depth(column, level)) - inside));
      wall.fixed.push_back(region.fixed[std::size_t(v)]);
    }
  std::vector<Vec3> axial(lumen.triangles.size());
  parallel_for(std::ptrdiff_t(axial.size()), [&](std::ptrdiff_t t) {
    const Triangle& corner = lumen.triangles[std::size_t(t)];
    Vec3 centre;
    for (const int v : corner) centre += (1.0 / 3.0) * lumen.vertices[std::size_t(v)];
    axial[std::size_t(t)] = within_layer(
        healthy.evaluate(centre).tangent, normalized(area_vector_doubled(lumen, corner)),
        lumen.vertices[std::size_t(corner[1])] - lumen.vertices[std::size_t(corner[0])]);
  });
  for (int layer = 0; layer < layers.count(); ++layer)
    for (std::size_t t = 0; t < lumen.triangles.size(); ++t) {
      const Triangle& corner = lumen.triangles[t];
      const int a = layer * count, b = a + count;
      wall.wedges.push_back({corner[0] + a, corner[1] + a, corner[2] + a, corner[0] + b,
                             corner[1] + b, corner[2] + b});
      wall.layer.push_back(layer);
      wall.tissue.push_back(tissue_at(layers, columns, corner, layer));
      wall.axial.push_back(axial[t]);
    }
  for (const Triangle& t : lumen.triangles) {
    const int top = layers.count() * count;
    wall.outer_triangles.push_back({t[0] + top, t[1] + top, t[2] + top});
  }
  return wall;
}

detail::Box box_of(const std::vector<Vec3>& points) {
  detail::Box box{points.front(), points.front()};
  for (const Vec3& p : points)
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::min(box.low[axis], p[axis]);
      box.high[axis] = std::max(box.high[axis], p[axis]);
    }
  return box;
}

std::string share_of(std::size_t part, std::size_t whole) {
  const std::string text = std::to_string(100.0 * double(part) / double(whole) + 0.05);
  return text.substr(0, text.find('.') + 2) + " %";
}

void check_input(const ContactRegion& region, const CenterlineTree& tree,
                 const std::vector<NarrowStretch>& stretches) {
  if (region.mesh.triangles.empty() || region.fixed.size() != region.mesh.vertices.size())
    throw InputError(
        "the wall has no surface, or its fixed flags do not match its vertices (the contact region "
        "is empty or of another run). Run the stage meshing again");
  for (const CenterlinePath& path : tree.paths)
    for (const double radius : path.inscribed_radius)
      if (!(radius > 0.0) || !std::isfinite(radius))
        throw InputError("line " + std::to_string(path.id) +
                         " of the centreline has a point without a radius (the wall's thickness "
                         "goes by it). Run the stage centerline again");
  for (const NarrowStretch& stretch : stretches) {
    const bool on_a_line = std::any_of(tree.paths.begin(), tree.paths.end(), [&](const auto& path) {
      return path.id == stretch.path_id;
    });
    if (!on_a_line || !(stretch.distal_mm >= stretch.proximal_mm) ||
        !(stretch.reference_diameter_mm > 0.0) || !std::isfinite(stretch.reference_diameter_mm))
      throw InputError(
          "a narrow stretch of the vessel is on no line of the centreline, ends before "
          "it begins or has no reference diameter (line " +
          std::to_string(stretch.path_id) + "). Run the stage centerline again");
  }
}

double wanted_length(const WallColumn& column) {
  return column.plaque + column.thickness + column.missing;
}

double length_of(const WallLayers& wall, std::size_t v) {
  const auto count = std::size_t(wall.lumen_vertex_count);
  return distance(wall.vertices[v],
                  wall.vertices[std::size_t(wall.element_layer_count) * count + v]);
}

/// Pieces of a surface's marked triangles, joined by edges: of each triangle the piece, -1
/// unmarked.
std::vector<int> pieces_of(const TriangleMesh& mesh, const std::vector<char>& marked) {
  std::map<std::array<int, 2>, std::vector<int>> around;
  for (std::size_t t = 0; t < marked.size(); ++t)
    for (std::size_t k = 0; k < 3 && marked[t]; ++k) {
      const auto [a, b] = std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
      around[std::array{a, b}].push_back(int(t));
    }
  std::vector<int> piece(marked.size(), -1);
  int count = 0;
  for (std::size_t seed = 0; seed < marked.size(); ++seed) {
    if (!marked[seed] || piece[seed] >= 0) continue;
    std::vector<int> open{int(seed)};
    piece[seed] = count;
    while (!open.empty()) {
      const Triangle& t = mesh.triangles[std::size_t(open.back())];
      open.pop_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
        for (const int next : around.at(std::array{a, b})) {
          if (piece[std::size_t(next)] >= 0) continue;
          piece[std::size_t(next)] = count;
          open.push_back(next);
        }
      }
    }
    ++count;
  }
  return piece;
}

/// Unmarks the triangles of every piece that neither is the largest nor reaches a rim.
void drop_islands(const TriangleMesh& mesh, const std::vector<char>& is_rim,
                  std::vector<char>& marked) {
  const std::vector<int> piece = pieces_of(mesh, marked);
  const int count = piece.empty() ? 0 : *std::max_element(piece.begin(), piece.end()) + 1;
  std::vector<int> size(std::size_t(count), 0);
  std::vector<char> keep(std::size_t(count), 0);
  for (std::size_t t = 0; t < piece.size(); ++t) {
    if (piece[t] < 0) continue;
    ++size[std::size_t(piece[t])];
    for (const int v : mesh.triangles[t])
      if (is_rim[std::size_t(v)]) keep[std::size_t(piece[t])] = 1;
  }
  if (count > 0) keep[std::size_t(std::max_element(size.begin(), size.end()) - size.begin())] = 1;
  for (std::size_t t = 0; t < piece.size(); ++t)
    if (piece[t] >= 0 && !keep[std::size_t(piece[t])]) marked[t] = 0;
}

double angle_at(const TriangleMesh& mesh, const Triangle& t, std::size_t corner) {
  const Vec3& at = mesh.vertices[std::size_t(t[corner])];
  const Vec3 a = mesh.vertices[std::size_t(t[(corner + 1) % 3])] - at,
             b = mesh.vertices[std::size_t(t[(corner + 2) % 3])] - at;
  return std::atan2(norm(cross(a, b)), dot(a, b));
}

/// Unmarks the triangles at vertices, off the rims, that hang by less than kLeastHold of their
/// angle. Blood presses on all the triangles around a vertex; a column in the tip of a flap beside
/// a place without layers carries that by one or two wedges, which yield without end.
void trim_flaps(const TriangleMesh& mesh, const std::vector<char>& is_rim,
                std::vector<char>& marked) {
  std::vector<double> whole(mesh.vertices.size(), 0.0);
  for (const Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) whole[std::size_t(t[k])] += angle_at(mesh, t, k);
  for (bool is_trimmed = true; is_trimmed;) {
    is_trimmed = false;
    std::vector<double> held(mesh.vertices.size(), 0.0);
    for (std::size_t t = 0; t < marked.size(); ++t)
      if (marked[t])
        for (std::size_t k = 0; k < 3; ++k)
          held[std::size_t(mesh.triangles[t][k])] += angle_at(mesh, mesh.triangles[t], k);
    for (std::size_t t = 0; t < marked.size(); ++t) {
      if (!marked[t]) continue;
      for (const int v : mesh.triangles[t])
        if (!is_rim[std::size_t(v)] && held[std::size_t(v)] < kLeastHold * whole[std::size_t(v)])
          marked[t] = 0;
      is_trimmed = is_trimmed || !marked[t];
    }
  }
}

/// Leaves out the wedges over wrong triangles and over those that share a vertex with them, and
/// what is a flap or an island then: columns that no wedge is left of are led.
void leave_out(WallLayers& wall, const TriangleMesh& lumen, const std::vector<char>& wrong) {
  const auto count = std::size_t(wall.lumen_vertex_count);
  std::vector<char> is_beside(count, 0), layered(wrong.size(), 1);
  for (std::size_t t = 0; t < wrong.size(); ++t)
    for (const int v : lumen.triangles[t])
      is_beside[std::size_t(v)] = char(is_beside[std::size_t(v)] | wrong[t]);
  for (std::size_t t = 0; t < wrong.size(); ++t)
    for (const int v : lumen.triangles[t])
      if (is_beside[std::size_t(v)]) layered[t] = 0;
  const std::vector<char> is_rim(wall.fixed.begin(), wall.fixed.begin() + std::ptrdiff_t(count));
  trim_flaps(lumen, is_rim, layered);
  drop_islands(lumen, is_rim, layered);
  wall.led.assign(count, 1);
  for (std::size_t t = 0; t < layered.size(); ++t)
    if (layered[t])
      for (const int v : lumen.triangles[t]) wall.led[std::size_t(v)] = 0;
  for (std::size_t v = 0; v < wall.vertices.size(); ++v)
    wall.fixed[v] = char(wall.fixed[v] | wall.led[v % count]);
  const auto keep = [&](auto& values) {
    std::size_t i = 0;
    std::erase_if(values, [&](const auto&) { return layered[i++ % layered.size()] == 0; });
  };
  keep(wall.wedges);
  keep(wall.layer);
  keep(wall.tissue);
  keep(wall.axial);
  keep(wall.tissue_ratio);
  keep(wall.outer_triangles);
}

/// What each wedge stands for: as much as its columns are shorter than wanted.
void rate_tissue(WallLayers& wall, const std::vector<WallColumn>& columns) {
  constexpr double kRounding = 1e-9;
  std::vector<double> ratio;
  for (std::size_t v = 0; v < columns.size(); ++v) {
    // A longer way is one that leaves the lumen askew, not a thicker wall.
    const double missing = wanted_length(columns[v]) / length_of(wall, v);
    ratio.push_back(missing > 1.0 + kRounding ? std::min(missing, kMostTissueRatio) : 1.0);
  }
  for (const std::array<int, 6>& wedge : wall.wedges) {
    double sum = 0.0;
    for (std::size_t c = 0; c < 3; ++c) sum += ratio[std::size_t(wedge[c]) % columns.size()];
    wall.tissue_ratio.push_back(sum / 3.0);
  }
}

/// Tells where the wall is thinner than wanted.
void warn_of_limits(WallLayers& wall, const std::vector<WallColumn>& columns) {
  const auto count = std::size_t(wall.lumen_vertex_count);
  std::size_t limited = 0, worst = 0;
  double least_share = 1.0;
  for (std::size_t v = 0; v < count; ++v) {
    if (wall.led[v] != 0) continue;
    const double share = length_of(wall, v) / wanted_length(columns[v]);
    if (share < kLimitedShare) ++limited;
    if (share >= least_share) continue;
    least_share = share;
    worst = v;
  }
  if (limited == 0) return;
  const Vec3& place = wall.vertices[worst];
  char where[100];
  std::snprintf(where, sizeof where, ", least around %.1f %.1f %.1f mm, where it has %.0f %% of it",
                place.x, place.y, place.z, 100.0 * least_share);
  wall.warnings.push_back("the wall is more than a tenth thinner than wanted around " +
                          share_of(limited, count) +
                          " of the lumen's vertices (there is no room for it in creases between "
                          "branches and sharp bends)" +
                          where);
}

/// Tells where the wall is led.
void warn_of_led(WallLayers& wall) {
  const auto first = std::find(wall.led.begin(), wall.led.end(), 1);
  if (first == wall.led.end()) return;
  const Vec3& place = wall.vertices[std::size_t(first - wall.led.begin())];
  char where[80];
  std::snprintf(where, sizeof where, ", such as %.1f %.1f %.1f mm", place.x, place.y, place.z);
  wall.warnings.push_back(
      "the wall goes with what is around it at " +
      share_of(std::size_t(std::count(wall.led.begin(), wall.led.end(), 1)), wall.led.size()) +
      " of the lumen's vertices around the balloon, where there is no room for its layers (vessels "
      "touch, or the surface folds)" +
      where);
}

}  // namespace

double least_corner_determinant(const std::vector<Vec3>& vertices,
                                const std::array<int, 6>& wedge) {
  const auto at = [&](std::size_t c) { return vertices[std::size_t(wedge[c])]; };
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t side = 0; side < 6; side += 3)
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3 here = at(side + c);
      const Vec3 up = at(3 + c) - at(c);
      least = std::min(
          least, dot(cross(at(side + (c + 1) % 3) - here, at(side + (c + 2) % 3) - here), up));
    }
  return least;
}

WallLayers build_wall_layers(const ContactRegion& region, const CenterlineTree& tree,
                             const std::vector<NarrowStretch>& stretches,
                             const WallLayerOptions& options) {
  options.validate();
  check_input(region, tree, stretches);
  const detail::HealthyVessel healthy(tree, stretches, box_of(region.mesh.vertices));
  const double q = options.thickness_ratio;
  const auto columns = grow_columns(region.mesh, healthy, 2.0 * q / (1.0 - 2.0 * q));
  const ElementLayers layers = element_layers(options, has_plaque(columns, options));
  WallLayers wall = stack_wedges(region, columns, layers, healthy);
  std::vector<double> least_length;
  for (const WallColumn& column : columns)
    least_length.push_back(kLeastShare * wanted_length(column));
  const auto wrong = detail::untangle(wall, region.mesh, kGoodShape, kLeastShape, least_length);
  rate_tissue(wall, columns);
  leave_out(wall, region.mesh, wrong);
  if (wall.wedges.empty())
    throw InputError(
        "the wall around the lumen folds over itself everywhere (the surface is too rough). Choose "
        "a "
        "thinner wall (wall.thickness_ratio), or smooth the lumen more "
        "(mesh.smoothing_iterations)");
  warn_of_led(wall);
  warn_of_limits(wall, columns);
  return wall;
}

}  // namespace angio::meshing
