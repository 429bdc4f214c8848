#pragma once

#include <numbers>
#include <optional>
#include <vector>

namespace angio::meshing::detail {

/// A balloon's section folded around its shaft: `fold_count` flaps, each a double layer, wrapped in
/// one sense. With the angle a = 2 pi / fold_count from flap to flap and the pitch p from layer to
/// layer, every layer is part of an Archimedean spiral that climbs by 2 p over a:
///
///     outer layer  r = core + 2 p t / a,       t in [0, a + wrap], from the root of one flap to
///     the
///                                              tip of the next: first it lies on the core itself
///     inner layer  r = core + p + 2 p t / a,   t in [0, wrap], from that tip back to its own root
///
/// so that neighbouring layers are a pitch apart everywhere.
struct FoldPack {
  int fold_count = 3;
  double core_radius = 0.0;  ///< the innermost layer's least [mm]
  double pitch = 0.0;        ///< from layer to layer [mm]
  double wrap = 0.0;         ///< by which a flap is wound around the core [radians]

  [[nodiscard]] double sector() const { return 2.0 * std::numbers::pi / fold_count; }
  [[nodiscard]] double climb() const { return 2.0 * pitch / sector(); }  ///< [mm/radian]
  [[nodiscard]] double outer_radius() const { return core_radius + climb() * (sector() + wrap); }
  [[nodiscard]] double outer_layer_length() const;  ///< [mm]
  [[nodiscard]] double inner_layer_length() const;
};

/// Packs a perimeter around a core so that the outside has a radius, or as little more as the least
/// pitch allows.
///
/// @param perimeter     of the unfolded section [mm]
/// @param outer_radius  wished [mm]
/// @return nothing if the perimeter is too short for flaps around this core
std::optional<FoldPack> pack_folds(int fold_count, double perimeter, double core_radius,
                                   double least_pitch, double outer_radius);

/// The vertices of a ring, unloaded and folded. Each sector begins at a flap's root: the outer
/// layer is `outer_edge_count` edges to the tip of the next flap, the inner layer the rest of them
/// back to its root. So every crease is a line of vertices, a meridian of the unloaded balloon.
struct FoldedSection {
  FoldPack pack;
  int outer_edge_count = 0;
  int inner_edge_count = 0;
  std::vector<double> rest_angle;  ///< in the unloaded ring, shape [ring_vertex_count]
  std::vector<double> angle;       ///< folded; on the mean the same as at rest
  std::vector<double> radius;      ///< folded [mm]

  /// The section of an end of the balloon, where the folds run out.
  ///
  /// Angles and radii go from the folded section (opening 0) to a circle on the core (1). At a
  /// given radius the layers keep their order in angle all the way, so they do not cross.
  [[nodiscard]] FoldedSection opened(double opening) const;
  /// The opening at which the outer layers have their unloaded length in a ring of smaller radius;
  /// the inner ones are slack there. 1 where the ring is no wider than the core.
  [[nodiscard]] double opening_at(double rest_radius) const;
};

/// Edges that the folded ring needs: a chord stays within a fifth of the pitch of its layer.
int folded_ring_vertex_count(const FoldPack& pack, double perimeter);

/// Puts vertices on a packed section so that every edge has its unloaded length. The wrap of the
/// pack is adjusted to the polygon.
///
/// @param rest_radius         of the vertices of the unloaded ring [mm]
/// @param ring_vertex_count   a multiple of twice the fold count
FoldedSection fold_section(const FoldPack& pack, double rest_radius, int ring_vertex_count);

}  // namespace angio::meshing::detail
