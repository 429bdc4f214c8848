#include "meshing/detail/pieces.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "air_mesh/build/surface_crossings.hpp"
#include "core/error.hpp"
#include "core/surface_rims.hpp"
#include "meshing/detail/crossings.hpp"
#include "meshing/detail/fill_hole.hpp"
#include "meshing/detail/hollow.hpp"
#include "meshing/detail/open_ends.hpp"
#include "meshing/detail/sheets.hpp"
#include "meshing/detail/soup.hpp"
#include "meshing/detail/unite_parts.hpp"
#include "meshing/detail/winding.hpp"

namespace angio::meshing::detail {

std::vector<TriangleMesh> connected_pieces(const TriangleMesh& mesh) {
  const std::vector<int> component = vertex_components(mesh);
  if (mesh.triangles.empty()) return {};
  const auto first = component[std::size_t(mesh.triangles.front()[0])];
  if (std::all_of(mesh.triangles.begin(), mesh.triangles.end(),
                  [&](const Triangle& t) { return component[std::size_t(t[0])] == first; }))
    return {mesh};
  std::vector<int> piece_of(mesh.vertices.size(), -1);  // of a component, by its first vertex
  std::vector<int> index(mesh.vertices.size(), -1);
  std::vector<TriangleMesh> pieces;
  for (const Triangle& t : mesh.triangles) {
    int& own = piece_of[std::size_t(component[std::size_t(t[0])])];
    if (own < 0) {
      own = int(pieces.size());
      pieces.emplace_back();
    }
    TriangleMesh& piece = pieces[std::size_t(own)];
    Triangle renamed{};
    for (std::size_t c = 0; c < 3; ++c) {
      int& at = index[std::size_t(t[c])];
      if (at < 0) {
        at = int(piece.vertices.size());
        piece.vertices.push_back(mesh.vertices[std::size_t(t[c])]);
      }
      renamed[c] = at;
    }
    piece.triangles.push_back(renamed);
  }
  return pieces;
}

TriangleMesh joined(const std::vector<TriangleMesh>& parts) {
  TriangleMesh all;
  for (const TriangleMesh& part : parts) {
    const int offset = int(all.vertices.size());
    all.vertices.insert(all.vertices.end(), part.vertices.begin(), part.vertices.end());
    for (const Triangle& t : part.triangles)
      all.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  return all;
}

TriangleMesh closed_copy(const TriangleMesh& mesh) {
  TriangleMesh closed = mesh;
  for (const auto& loop : boundary_loops(mesh)) fill_hole(closed, loop);
  return closed;
}

void note(std::vector<SurfaceRepair>& repairs, const char* one, const char* many,
          const Count& count) {
  if (count.count > 0)
    repairs.push_back(
        {count.count == 1 ? one : many, count.count, count.where, false, count.size_mm});
}

namespace {

struct Bounds {
  Vec3 low, high;
  Bounds() = default;
  explicit Bounds(const TriangleMesh& mesh) : low(mesh.vertices.front()), high(low) {
    for (const Vec3& p : mesh.vertices)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
  }
  [[nodiscard]] double extent() const {
    return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  }
  [[nodiscard]] bool meets(const Bounds& other) const {
    bool apart = false;
    for (int axis = 0; axis < 3; ++axis)
      apart = apart || low[axis] > other.high[axis] || other.low[axis] > high[axis];
    return !apart;
  }
};

/// A piece, turned outward, with its closed copy.
struct Piece {
  TriangleMesh mesh;
  TriangleMesh closed = {};
  Bounds box = {};
  double area = 0.0;
  double volume = 0.0;
  bool is_gone = false;
};

/// Gives a piece its closed copy and sizes. @return whether it was inside out
bool settle(Piece& piece) {
  piece.closed = closed_copy(piece.mesh);
  piece.volume = enclosed_volume(piece.closed);
  const bool is_inside_out = piece.volume < 0.0;
  if (is_inside_out) {
    for (TriangleMesh* turn : {&piece.mesh, &piece.closed})
      for (Triangle& t : turn->triangles) std::swap(t[1], t[2]);
    piece.volume = -piece.volume;
  }
  piece.box = Bounds(piece.mesh);
  piece.area = surface_area(piece.mesh);
  return is_inside_out;
}

/// Whether a surface is open at vessels' ends alone, but for small holes. What was torn out of a
/// folded surface has openings of any shape.
bool is_open_at_ends(const TriangleMesh& mesh) {
  constexpr double kSmall = 0.25;  // of the widest opening
  constexpr std::size_t kMostCorners = 1000;
  const std::vector<SurfaceRim> rims = surface_rims(mesh);
  double widest = 0.0;
  for (const SurfaceRim& rim : rims) widest = std::max(widest, rim.diameter_mm);
  return std::all_of(rims.begin(), rims.end(), [&](const SurfaceRim& rim) {
    return rim.loop.size() < kMostCorners &&
           (rim.wall_along >= kVesselEnd || rim.diameter_mm < kSmall * widest);
  });
}

/// The lumen of a piece that is a vessel's wall; nothing of others.
std::optional<Piece> lumen_in(const Piece& wall) {
  constexpr std::size_t kFew = 100;      // triangles show no vessel's wall
  constexpr double kLeastInside = 0.02;  // of the wall's volume
  if (wall.mesh.triangles.size() < kFew || hollow_share_of(wall.mesh, wall.area) <= kWallShare)
    return {};
  Piece lumen{hollow_of(wall.mesh)};
  if (lumen.mesh.triangles.empty()) return {};
  take_sheets_apart(lumen.mesh);
  if (!is_open_at_ends(lumen.mesh)) return {};
  settle(lumen);
  if (lumen.volume < kLeastInside * wall.volume ||
      hollow_share_of(lumen.mesh, lumen.area) > kWallShare)
    return {};
  return lumen;
}

/// Of several vessels, some may be given by the two sides of their wall.
void take_lumens_of_walls(std::vector<Piece>& pieces, std::vector<SurfaceRepair>& repairs) {
  Count walls;
  for (Piece& piece : pieces)
    if (auto lumen = lumen_in(piece)) {
      piece = std::move(*lumen);
      walls.add(piece.mesh.vertices.front(), piece.box.extent());
    }
  note(repairs, "piece that is a vessel's wall left but for its inner side, the lumen",
       "pieces that are vessels' walls left but for their inner sides, the lumens", walls);
}

/// The largest surface first.
std::vector<Piece> pieces_outward(const TriangleMesh& mesh, std::vector<SurfaceRepair>& repairs) {
  std::vector<Piece> pieces;
  Count turned;
  for (TriangleMesh& part : connected_pieces(mesh)) {
    pieces.push_back({std::move(part)});
    if (settle(pieces.back())) turned.add(pieces.back().mesh.vertices.front());
  }
  note(repairs, "inside-out piece turned outward", "inside-out pieces turned outward", turned);
  if (pieces.size() > 1) take_lumens_of_walls(pieces, repairs);
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const auto& a, const auto& b) { return a.area > b.area; });
  return pieces;
}

/// Has a piece an inside that counts? A loose triangle or sheet has none, nor has a crumb.
bool is_solid(const Piece& piece, const Piece& largest) {
  constexpr double kCrumb = 1e-3;  // of the largest piece's area
  if (piece.area < kCrumb * largest.area) return false;
  constexpr double kSheet = 1e-3;  // of the ball with the same surface; a tube a thousand radii
                                   // long has 0.07
  return piece.volume > kSheet * std::pow(piece.area, 1.5) / 10.63;
}

/// Of every piece wholly inside another, one goes.
void settle_nested(std::vector<Piece>& pieces, std::vector<SurfaceRepair>& repairs) {
  constexpr double kLumen = 0.2;  // of the volume; a wall a fifth of the width thick leaves 0.36
  constexpr double kAlong = 0.7;  // of the extent
  Count walls, inner;
  for (std::size_t o = 0; o < pieces.size(); ++o) {
    std::optional<Winding> winding;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      Piece& outside = pieces[o];
      Piece& inside = pieces[i];
      if (o == i || outside.is_gone || inside.is_gone || inside.volume >= outside.volume ||
          !is_solid(outside, pieces.front()) || !is_solid(inside, pieces.front()) ||
          !outside.box.meets(inside.box))
        continue;
      if (!winding) winding.emplace(outside.closed);
      if (winding->at(inside.mesh.vertices.front()) <= 0 ||
          !air_mesh::intersections(outside.closed, inside.closed).empty())
        continue;
      const bool is_lumen = inside.volume > kLumen * outside.volume &&
                            inside.box.extent() > kAlong * outside.box.extent();
      Piece& gone = is_lumen ? outside : inside;
      gone.is_gone = true;
      (is_lumen ? walls : inner).add(gone.mesh.vertices.front(), gone.box.extent());
    }
  }
  std::erase_if(pieces, [](const Piece& piece) { return piece.is_gone; });
  note(repairs, "outside of a wall left out, as the surface within it is the lumen",
       "outsides of walls left out, as the surfaces within them are the lumen", walls);
  note(repairs, "piece inside the lumen left out", "pieces inside the lumen left out", inner);
}

/// Indices of the pieces that cross each other, directly or through others; one group after
/// another, in the order of their first.
std::vector<std::vector<std::size_t>> crossing_groups(const std::vector<Piece>& pieces) {
  std::vector<std::size_t> group(pieces.size());
  std::iota(group.begin(), group.end(), std::size_t(0));
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (std::size_t j = i + 1; j < pieces.size(); ++j) {
      if (group[i] == group[j] || !is_solid(pieces[i], pieces.front()) ||
          !is_solid(pieces[j], pieces.front()) || !pieces[i].box.meets(pieces[j].box) ||
          air_mesh::intersections(pieces[i].closed, pieces[j].closed).empty())
        continue;
      const auto [low, high] = std::minmax(group[i], group[j]);
      std::replace(group.begin(), group.end(), std::size_t(high), std::size_t(low));
    }
  std::vector<std::vector<std::size_t>> groups(pieces.size());
  for (std::size_t i = 0; i < pieces.size(); ++i) groups[group[i]].push_back(i);
  std::erase_if(groups, [](const auto& members) { return members.empty(); });
  return groups;
}

/// Opens a closed surface again where its parts were open. @return how many openings stay closed
Count reopen(TriangleMesh& mesh, const std::vector<SurfaceRim>& rims) {
  Count closed;
  std::vector<Vec3> tips;
  for (const SurfaceRim& rim : rims) tips.push_back(rim.centre);
  const TriangleMesh whole = mesh;
  EndOpener opener(whole, tips);
  for (std::size_t r = 0; r < rims.size(); ++r) {
    const SurfaceRim& rim = rims[r];
    const double radius = 0.5 * rim.diameter_mm;
    std::vector<Plane> planes;
    for (const double inset : {0.02, 0.1, 0.3, 0.6})
      planes.push_back(
          {rim.centre - (rim.unevenness_mm + inset * radius) * rim.normal, rim.normal});
    EndOpener::Cut cut = opener.best_cut(planes, radius, int(r));
    if (cut.verdict == EndOpener::Verdict::sound)
      opener.plan(std::move(cut));
    else
      closed.add(rim.centre, rim.diameter_mm);
  }
  std::vector<int> unused(whole.vertices.size(), -1);
  opener.apply(mesh, unused);
  return closed;
}

/// The openings of pieces that are not inside another piece.
std::vector<SurfaceRim> free_rims(const std::vector<const Piece*>& pieces,
                                  const TriangleMesh& closed) {
  const Winding winding(closed);
  std::vector<SurfaceRim> rims;
  for (const Piece* piece : pieces)
    for (const SurfaceRim& rim : surface_rims(piece->mesh))
      if (winding.at(rim.centre + 0.1 * rim.diameter_mm * rim.normal) <= 0) rims.push_back(rim);
  return rims;
}

/// Why parts could not be united. @param otherwise  what is likely
std::string reason_of(const Union& failed, const char* otherwise) {
  if (failed.too_many == 0.0) return otherwise;
  char text[160];
  std::snprintf(text, sizeof text,
                "a contour that is fine enough where it is thin would have %.0f million triangles",
                1e-6 * failed.too_many);
  return text;
}

/// Unites pieces that cross. @return empty if they only touch
TriangleMesh unite_group(const std::vector<const Piece*>& pieces,
                         std::vector<SurfaceRepair>& repairs) {
  std::vector<TriangleMesh> closed;
  Count united;
  for (const Piece* piece : pieces) {
    closed.push_back(piece->closed);
    if (piece != pieces.front()) united.add(piece->mesh.vertices.front(), piece->box.extent());
  }
  Union result = unite_parts(closed);
  if (result.only_touch) return {};
  if (result.mesh.triangles.empty())
    throw InputError("the surface has " + std::to_string(pieces.size()) +
                     " parts that overlap and cannot be united without losing some of them (" +
                     reason_of(result, "they are too thin, or cross too often") +
                     "). Unite them in a mesh editor");
  note(repairs, "piece that crosses the largest united with it",
       "pieces that cross united with the largest", united);
  note(repairs, "opening of a piece closed, as no section there is that of one vessel",
       "openings of pieces closed, as no sections there are those of one vessel",
       reopen(result.mesh, free_rims(pieces, joined(closed))));
  return std::move(result.mesh);
}

/// Whether closing the holes of what was cut out has parted a vessel, or left a neck: looked at
/// coarsely and finely, the lumen falls into more parts than it did.
bool shuts_vessel(const TriangleMesh& cut, const TriangleMesh& before) {
  constexpr double kLeastPart = 0.01;  // of the lumen
  const double volume = volume_of_union(before);
  const double width = 4.0 * volume / surface_area(before);  // of a tube
  const auto count_parts = [&](const TriangleMesh& closed, double distance) {
    const std::vector<double> parts = wound_parts(closed, distance);
    return std::count_if(parts.begin(), parts.end(),
                         [&](double part) { return part > kLeastPart * volume; });
  };
  constexpr double kCoarse = 0.5, kFine = 0.05, kStep = 0.75;  // of the width
  for (double share = kCoarse; share > kFine; share *= kStep)
    if (count_parts(cut, share * width) > count_parts(before, share * width)) return true;
  return false;
}

}  // namespace

TriangleMesh settle_pieces(const TriangleMesh& mesh, const SurfaceRepairOptions& options,
                           std::vector<SurfaceRepair>& repairs) {
  std::vector<Piece> pieces = pieces_outward(mesh, repairs);
  if (pieces.size() == 1) return std::move(pieces.front().mesh);
  settle_nested(pieces, repairs);
  std::vector<TriangleMesh> apart, touching;
  for (const auto& members : crossing_groups(pieces)) {
    std::vector<const Piece*> group;
    for (const std::size_t i : members) group.push_back(&pieces[i]);
    TriangleMesh united = group.size() > 1 ? unite_group(group, repairs) : TriangleMesh();
    if (!united.triangles.empty()) {
      apart.push_back(std::move(united));
      continue;
    }
    const auto largest =
        std::max_element(group.begin(), group.end(), [](const Piece* one, const Piece* other) {
          return surface_area(one->mesh) < surface_area(other->mesh);
        });
    for (const Piece* piece : group)  // what only touches another is no vessel of its own
      (piece == *largest || options.keep_all_pieces ? apart : touching).push_back(piece->mesh);
  }
  if (options.keep_all_pieces) return joined(apart);
  std::stable_sort(apart.begin(), apart.end(),
                   [](const auto& a, const auto& b) { return surface_area(a) > surface_area(b); });
  constexpr double kLeastTree = 0.05;  // of the largest piece's area: a vessel of its own
  const double least = kLeastTree * surface_area(apart.front());
  const auto small = std::find_if(apart.begin(), apart.end(), [&](const TriangleMesh& piece) {
    return surface_area(piece) < least;
  });
  Count left_out;
  for (auto piece = small; piece != apart.end(); ++piece)
    left_out.add(piece->vertices.front(), Bounds(*piece).extent());
  for (const TriangleMesh& piece : touching)
    left_out.add(piece.vertices.front(), Bounds(piece).extent());
  note(repairs, "smaller piece left out", "smaller pieces left out", left_out);
  apart.erase(small, apart.end());
  return joined(apart);
}

TriangleMesh without_crossings(const TriangleMesh& mesh, std::vector<SurfaceRepair>& repairs) {
  constexpr double kMost = 0.1;         // of the triangles may be cut out
  constexpr double kSameVolume = 0.02;  // as unite_parts
  const auto pairs = air_mesh::self_intersections(mesh);
  if (pairs.empty()) return mesh;
  std::vector<char> crossing(mesh.triangles.size(), 0);
  for (const auto& pair : pairs)
    for (const int t : pair) crossing[std::size_t(t)] = 1;
  const auto count = double(std::count(crossing.begin(), crossing.end(), char(1)));
  const TriangleMesh closed = closed_copy(mesh);
  const double volume = volume_of_union(closed);
  Count places;
  places.where = mesh.vertices[std::size_t(mesh.triangles[std::size_t(pairs.front()[0])][0])];
  TriangleMesh cut;  // empty: cutting out what crosses does not do
  const std::vector<SurfaceRim> rims = surface_rims(mesh);
  const auto tell_closed = [&](const Count& openings) {
    note(repairs, "opening closed, as no section there is that of one vessel",
         "openings closed, as no sections there are those of one vessel", openings);
  };
  const auto with_cut = [&] {
    note(repairs, "place where the surface crossed itself closed again",
         "places where the surface crossed itself closed again", places);
    if (surface_rims(cut).size() == rims.size()) return std::move(cut);
    // What crosses beside a rim takes the rim with it.
    TriangleMesh opened = closed_copy(cut);
    tell_closed(reopen(opened, rims));
    return opened;
  };
  if (count <= kMost * double(crossing.size())) {
    cut = mesh;
    places.count = close_crossings(cut);
    if (!air_mesh::self_intersections(cut).empty() ||
        std::abs(enclosed_volume(closed_copy(cut)) - volume) > kSameVolume * volume)
      cut = {};
    else if (!shuts_vessel(closed_copy(cut), closed))
      return with_cut();
  }
  Union result = unite_parts({closed});
  if (result.mesh.triangles.empty() && !cut.triangles.empty()) return with_cut();
  if (result.mesh.triangles.empty())
    throw InputError("the surface crosses itself in " + std::to_string(std::lround(count)) +
                     " of its " + std::to_string(crossing.size()) + " triangles (" +
                     reason_of(result, "what is inside is not known where they cross") +
                     "). Segment again, or unite its parts in a mesh editor");
  places.count = int(pairs.size());
  note(repairs, "crossing of the surface with itself resolved by contouring what is inside",
       "crossings of the surface with itself resolved by contouring what is inside", places);
  tell_closed(reopen(result.mesh, rims));
  const std::size_t left = air_mesh::self_intersections(result.mesh).size();
  if (left > 0)
    throw InputError("the surface crosses itself (" + std::to_string(left) +
                     " pairs of triangles are left after repair). Repair it in a mesh editor");
  return std::move(result.mesh);
}

}  // namespace angio::meshing::detail
