#include "meshing/detail/fold_section.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace angio::meshing::detail {
namespace {

constexpr double kLeastWrap = 0.2;   // of a sector; less is no flap
constexpr double kChordShare = 0.2;  // of the pitch, between a chord and its layer
constexpr int kLeastEdges = 3;       // on a layer
constexpr int kBisections = 60;      // to the last digits of a double

/// The least x in [low, high] from which a condition holds that stays true once it is.
double first_true(double low, double high, const std::function<bool(double)>& condition) {
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (condition(middle) ? high : low) = middle;
  }
  return high;
}

/// An Archimedean spiral from a radius on, by its arc length.
class Spiral {
 public:
  Spiral(double radius, double climb) : radius_(radius), climb_(climb) {}
  [[nodiscard]] double radius(double turn) const { return radius_ + climb_ * turn; }
  [[nodiscard]] double length(double turn) const {
    return integral(radius(turn)) - integral(radius_);
  }
  [[nodiscard]] double turn(double length_wanted) const {
    return first_true(0.0, length_wanted / radius_,
                      [&](double turn) { return length(turn) >= length_wanted; });
  }

 private:
  [[nodiscard]] double integral(double r) const {
    return (r * std::hypot(r, climb_) + climb_ * climb_ * std::asinh(r / climb_)) / (2.0 * climb_);
  }
  double radius_, climb_;
};

Spiral outer_spiral(const FoldPack& pack) { return {pack.core_radius, pack.climb()}; }
Spiral inner_spiral(const FoldPack& pack) { return {pack.core_radius + pack.pitch, pack.climb()}; }

double perimeter_of(const FoldPack& pack) {
  return pack.fold_count * (pack.outer_layer_length() + pack.inner_layer_length());
}

/// @return nothing if not even the shortest flaps are that short
std::optional<FoldPack> wrap_folds(FoldPack pack, double perimeter) {
  pack.wrap = kLeastWrap * pack.sector();
  if (perimeter_of(pack) > perimeter) return std::nullopt;
  pack.wrap = first_true(pack.wrap, perimeter / pack.core_radius, [&](double wrap) {
    FoldPack longer = pack;
    longer.wrap = wrap;
    return perimeter_of(longer) >= perimeter;
  });
  return pack;
}

/// Puts a sector's vertices, from a root to the vertex before the next, in polar coordinates.
void place_sector(FoldedSection& section) {
  const FoldPack& pack = section.pack;
  const Spiral outer = outer_spiral(pack);
  const Spiral inner = inner_spiral(pack);
  section.angle.clear();
  section.radius.clear();
  const auto add = [&](double angle, double radius) {
    section.angle.push_back(angle);
    section.radius.push_back(radius);
  };
  // Creases lie halfway between the two layers that meet there.
  add(0.0, pack.core_radius + 0.5 * pack.pitch);
  for (int k = 1; k < section.outer_edge_count; ++k) {
    const double turn = outer.turn(pack.outer_layer_length() * k / section.outer_edge_count);
    add(turn, outer.radius(turn));
  }
  add(pack.sector() + pack.wrap, pack.outer_radius() - 0.5 * pack.pitch);
  for (int k = section.inner_edge_count - 1; k > 0; --k) {
    const double turn = inner.turn(pack.inner_layer_length() * k / section.inner_edge_count);
    add(pack.sector() + turn, inner.radius(turn));
  }
}

double edge_length(const FoldedSection& section, std::size_t k) {
  const std::size_t count = section.angle.size();
  // The last edge of a lone sector ends at the first vertex of the next.
  const bool last = k + 1 == count;
  const double turn = last ? section.angle[0] + section.pack.sector() - section.angle[k]
                           : section.angle[k + 1] - section.angle[k];
  const double r0 = section.radius[k];
  const double r1 = section.radius[(k + 1) % count];
  return std::sqrt((r1 - r0) * (r1 - r0) +
                   4.0 * r0 * r1 * std::sin(0.5 * turn) * std::sin(0.5 * turn));
}

/// The angle that an edge takes in the unloaded ring.
double rest_turn(const FoldedSection& section, std::size_t k, double rest_radius) {
  return 2.0 * std::asin(std::min(1.0, edge_length(section, k) / (2.0 * rest_radius)));
}

/// Repeats a sector all around and turns the folded ring until it is not twisted on the mean.
void complete_ring(FoldedSection& section) {
  const std::size_t count = section.angle.size();
  double twist = 0.0;
  for (std::size_t k = 0; k < count; ++k)
    twist += (section.angle[k] - section.rest_angle[k]) / double(count);
  for (double& angle : section.angle) angle -= twist;
  for (int fold = 1; fold < section.pack.fold_count; ++fold)
    for (std::size_t k = 0; k < count; ++k) {
      section.rest_angle.push_back(section.rest_angle[k] + fold * section.pack.sector());
      section.angle.push_back(section.angle[k] + fold * section.pack.sector());
      section.radius.push_back(section.radius[k]);
    }
}

}  // namespace

double FoldPack::outer_layer_length() const { return outer_spiral(*this).length(sector() + wrap); }
double FoldPack::inner_layer_length() const { return inner_spiral(*this).length(wrap); }

std::optional<FoldPack> pack_folds(int fold_count, double perimeter, double core_radius,
                                   double least_pitch, double outer_radius) {
  FoldPack pack;
  pack.fold_count = fold_count;
  pack.core_radius = core_radius;
  pack.pitch = least_pitch;
  const auto tightest = wrap_folds(pack, perimeter);
  if (!tightest || tightest->outer_radius() >= outer_radius) return tightest;
  const auto packed_at = [&](double pitch) {
    FoldPack looser = pack;
    looser.pitch = pitch;
    return wrap_folds(looser, perimeter);
  };
  const double too_loose = first_true(least_pitch, outer_radius, [&](double pitch) {
    const auto packed = packed_at(pitch);
    return !packed || packed->outer_radius() > outer_radius;
  });
  return packed_at(std::max(least_pitch, too_loose * (1.0 - 1e-9)));
}

int folded_ring_vertex_count(const FoldPack& pack, double perimeter) {
  // The sagitta of a chord c is c^2 / (8 r).
  const double chord = std::sqrt(8.0 * pack.core_radius * kChordShare * pack.pitch);
  const int step = 2 * pack.fold_count;
  return step * std::max(kLeastEdges, int(std::ceil(perimeter / (chord * step))));
}

FoldedSection fold_section(const FoldPack& pack, double rest_radius, int ring_vertex_count) {
  FoldedSection section;
  section.pack = pack;
  const int edge_count = ring_vertex_count / pack.fold_count;
  const double outer = pack.outer_layer_length();
  const double share = outer / (outer + pack.inner_layer_length());
  section.outer_edge_count =
      std::clamp(int(std::lround(share * edge_count)), kLeastEdges, edge_count - kLeastEdges);
  section.inner_edge_count = edge_count - section.outer_edge_count;
  const auto turn_of_sector = [&](double wrap) {
    section.pack.wrap = wrap;
    place_sector(section);
    double sum = 0.0;
    for (std::size_t k = 0; k < section.angle.size(); ++k)
      sum += rest_turn(section, k, rest_radius);
    return sum;
  };
  section.pack.wrap = first_true(0.5 * pack.wrap, 2.0 * pack.wrap, [&](double wrap) {
    return turn_of_sector(wrap) >= pack.sector();
  });
  place_sector(section);
  section.rest_angle.assign(1, 0.0);
  for (std::size_t k = 0; k + 1 < section.angle.size(); ++k)
    section.rest_angle.push_back(section.rest_angle.back() + rest_turn(section, k, rest_radius));
  complete_ring(section);
  return section;
}

FoldedSection FoldedSection::opened(double opening) const {
  // From the opening on at which the inner layers point to the axis, the flaps lose their height.
  const std::size_t tip = std::size_t(outer_edge_count);
  const double inner_at_rest = pack.sector() - rest_angle[tip];
  const double upright = pack.wrap / (pack.wrap + inner_at_rest);
  const double height = std::min(1.0, (1.0 - opening) / (1.0 - upright));
  FoldedSection result = *this;
  for (std::size_t k = 0; k < angle.size(); ++k) {
    result.angle[k] = (1.0 - opening) * angle[k] + opening * rest_angle[k];
    result.radius[k] = pack.core_radius + height * (radius[k] - pack.core_radius);
  }
  return result;
}

double FoldedSection::opening_at(double rest_radius) const {
  const auto outer_edges = std::size_t(outer_edge_count);
  double wanted = 0.0;
  for (std::size_t k = 0; k < outer_edges; ++k)
    wanted += 2.0 * rest_radius * std::sin(0.5 * (rest_angle[k + 1] - rest_angle[k]));
  const auto short_enough = [&](double opening) {
    const FoldedSection at = opened(opening);
    double length = 0.0;
    for (std::size_t k = 0; k < outer_edges; ++k) length += edge_length(at, k);
    return length <= wanted;
  };
  return first_true(0.0, 1.0, short_enough);
}

}  // namespace angio::meshing::detail
