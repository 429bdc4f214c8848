#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/units.hpp"
#include "core/vec3.hpp"

/// Random vessel trees whose healthy and narrowed radii are known at every point.
namespace angio::benchmarks {

struct Draw {
  std::mt19937 random;

  double between(double low, double high) {
    return low + (high - low) * double(random()) / double(std::mt19937::max());
  }
  double normal(double sd) { return std::normal_distribution<double>(0.0, sd)(random); }
  bool chance(double probability) { return between(0.0, 1.0) < probability; }
};

/// One vessel between two forks, sampled along its axis.
struct TrueBranch {
  int parent = -1;
  std::vector<int> daughters;
  std::vector<Vec3> points;      ///< the first is the parent's last
  std::vector<double> abscissa;  ///< [mm], 0 at the first
  std::vector<double> healthy;   ///< radius without disease [mm]
  std::vector<double> ectatic;   ///< with its ectasias
  std::vector<double> radius;    ///< with its ectasias and stenoses
};

struct TrueTree {
  std::vector<TrueBranch> branches;  ///< parents first
  double least_radius = 0.0;         ///< of the healthy vessels [mm]
};

/// A bump that is 1 at its middle or along its plateau and 0 beyond its half length.
inline double bump(double s, double middle, double half, double plateau) {
  const double x = std::abs(s - middle) / half;
  if (x >= 1.0) return 0.0;
  if (x <= plateau) return 1.0;
  return 0.5 * (1.0 + std::cos(units::kPi * (x - plateau) / (1.0 - plateau)));
}

/// A branch's axis: steps of 0.1 radii whose direction turns smoothly, never sharper than
/// `least_bend` radii.
inline void draw_axis(Draw& draw, TrueBranch& branch, const Vec3& start, Vec3 direction,
                      double length, double radius) {
  const double step = 0.1 * radius, least_bend = draw.between(5.0, 30.0);
  Vec3 across = normalized(cross(direction, {draw.normal(1), draw.normal(1), draw.normal(1)}));
  double bend = 0.0, wanted = 0.0;
  const int count = std::max(20, int(length / step));
  Vec3 at = start;
  for (int i = 0; i <= count; ++i) {
    branch.points.push_back(at);
    branch.abscissa.push_back(i * step);
    // The first radii run straight: forks part cleanly.
    if (i % 30 == 29) wanted = draw.between(-1.0, 1.0) / (least_bend * radius);
    bend += 0.08 * (wanted - bend);
    across = normalized(across - dot(across, direction) * direction);
    direction = normalized(direction + (bend * step) * across);
    at = at + step * direction;
  }
}

/// Healthy radii: an even taper, and small steps where side branches leave that nobody sees.
inline void draw_healthy(Draw& draw, TrueBranch& branch, double radius) {
  const double taper = draw.chance(0.1) ? draw.between(0.03, 0.05) : draw.between(0.0, 0.03);
  const double length = branch.abscissa.back();
  const double hidden = draw.chance(0.2) ? draw.between(0.06, 0.15) : 0.0;
  const double hidden_at = draw.between(0.2, 0.8) * length;
  for (const double s : branch.abscissa) {
    const double step = hidden / (1.0 + std::exp(-(s - hidden_at) / (0.5 * radius)));
    branch.healthy.push_back(radius * std::exp(-taper * s / (2.0 * radius) - step));
  }
  branch.ectatic = branch.healthy;
  if (!draw.chance(0.12)) return;
  const double middle = draw.between(0.2, 0.8) * length, more = draw.between(0.2, 1.2);
  const double half = draw.between(1.0, 3.0) * 2.0 * radius, plateau = draw.between(0.0, 0.4);
  for (std::size_t i = 0; i < branch.abscissa.size(); ++i)
    branch.ectatic[i] *= 1.0 + more * bump(branch.abscissa[i], middle, half, plateau);
}

struct GrowOptions {
  int most_branches = 25;
  double most_diameters = 16.0;  ///< length of a branch
  bool with_aneurysms = false;   ///< one or two a tree
  bool with_two_inlets = false;  ///< two trees, joined by an end of each
};

/// Adds the two daughters of a branch; their radii follow r0^p = r1^p + r2^p with 5 % scatter.
inline void fork(Draw& draw, TrueTree& tree, std::size_t parent, double exponent,
                 const GrowOptions& grow) {
  const TrueBranch from = tree.branches[parent];
  const double r0 = from.healthy.back(), q = draw.between(0.35, 1.0);
  const double first = r0 * std::pow(1.0 + std::pow(q, exponent), -1.0 / exponent);
  const double radii[2] = {first * std::exp(draw.normal(0.05)),
                           q * first * std::exp(draw.normal(0.05))};
  const Vec3 ahead = normalized(from.points.back() - from.points[from.points.size() - 10]);
  const Vec3 any = normalized(cross(ahead, {draw.normal(1), draw.normal(1), draw.normal(1)}));
  const double angle = draw.between(0.6, 1.3);  // between the daughters
  for (int k = 0; k < 2; ++k) {
    if (radii[k] < 0.7) continue;
    // The wider daughter turns less.
    const double turn = angle * (k == 0 ? q / (1.0 + q) : -1.0 / (1.0 + q));
    TrueBranch branch;
    branch.parent = int(parent);
    const double diameters =
        draw.chance(0.2) ? draw.between(3.0, 6.0) : draw.between(6.0, grow.most_diameters);
    draw_axis(draw, branch, from.points.back(),
              normalized(std::cos(turn) * ahead + std::sin(turn) * any), diameters * 2.0 * radii[k],
              radii[k]);
    draw_healthy(draw, branch, radii[k]);
    tree.branches[parent].daughters.push_back(int(tree.branches.size()));
    tree.branches.push_back(branch);
  }
}

struct LesionPlan {
  double middle = 0.0, half = 0.0;  ///< [mm]
  double plateau = 0.0;             ///< share of the half length, [0, 1)
  double depth = 0.0;               ///< diameter stenosis, [0, 1)
};

inline void narrow(TrueBranch& branch, const LesionPlan& plan) {
  for (std::size_t i = 0; i < branch.radius.size(); ++i) {
    const double depth =
        plan.depth * bump(branch.abscissa[i], plan.middle, plan.half, plan.plateau);
    branch.radius[i] = std::min(branch.radius[i], branch.ectatic[i] * (1.0 - depth));
  }
}

/// Where a branch may begin to be narrowed: behind the lumen of its parent.
inline double ostium_of(const TrueTree& tree, const TrueBranch& branch) {
  return branch.parent < 0 ? 0.0 : 1.3 * tree.branches[std::size_t(branch.parent)].healthy.back();
}

/// A lesion anywhere on a branch: focal, long or diffuse; a third of them at its ends.
inline void draw_lesion(Draw& draw, const TrueTree& tree, TrueBranch& branch, double depth) {
  const double diameter = 2.0 * branch.healthy.front(), length = branch.abscissa.back();
  const double ostium = ostium_of(tree, branch);
  const double kind = draw.between(0.0, 1.0);
  LesionPlan plan;
  plan.depth = depth;
  plan.half = diameter * (kind < 0.6 ? draw.between(0.75, 2.0) : draw.between(2.0, 4.0));
  plan.plateau = kind < 0.6 ? 0.0 : draw.between(0.2, 0.7);
  const double place = draw.between(0.0, 1.0);
  plan.middle = place < 0.2    ? ostium + draw.between(0.0, 1.0) * diameter
                : place < 0.35 ? length - draw.between(0.5, 1.5) * diameter
                               : draw.between(ostium, length);
  narrow(branch, plan);
  if (kind < 0.85) return;  // diffuse: most of the branch is narrowed by half as much
  LesionPlan diffuse = plan;
  diffuse.depth = std::min(0.5, 0.5 * depth);
  diffuse.half = 0.5 * length * draw.between(0.5, 0.8);
  diffuse.middle = draw.between(diffuse.half, length - diffuse.half);
  diffuse.plateau = 0.8;
  narrow(branch, diffuse);
}

/// A fusiform aneurysm (1.5 to 5 times as wide as the healthy vessel, 2 to 8 healthy diameters
/// long) anywhere on a branch; it may run up to a fork, and disease may lie in it or beside it.
inline void draw_aneurysm(Draw& draw, TrueBranch& branch) {
  const double diameter = 2.0 * branch.healthy.front(), length = branch.abscissa.back();
  const double more = draw.between(0.5, 4.0), half = 0.5 * diameter * draw.between(2.0, 8.0);
  const double middle = draw.between(0.0, length), plateau = draw.between(0.0, 0.6);
  for (std::size_t i = 0; i < branch.ectatic.size(); ++i)
    branch.ectatic[i] = std::max(
        branch.ectatic[i],
        branch.healthy[i] * (1.0 + more * bump(branch.abscissa[i], middle, half, plateau)));
}

/// A tree without disease.
inline TrueTree grow_tree(Draw& draw, const GrowOptions& grow) {
  TrueTree tree;
  const double radius = 1.2 * std::pow(10.0, draw.between(0.0, 1.0));  // 1.2 to 12 mm
  const double exponent = draw.between(2.1, 3.0);  // from area-preserving to Murray's
  const int wanted = 1 + int(draw.between(0.0, 1.0) * double(grow.most_branches));
  TrueBranch root;
  draw_axis(draw, root, {}, {0.0, 0.0, 1.0}, draw.between(5.0, grow.most_diameters) * 2.0 * radius,
            radius);
  draw_healthy(draw, root, radius);
  tree.branches.push_back(root);
  for (std::size_t b = 0; b < tree.branches.size() && int(tree.branches.size()) < wanted; ++b)
    fork(draw, tree, b, exponent, grow);
  return tree;
}

/// The branch in which a tree ends whose end is as wide as can be to a given radius.
inline std::size_t find_end(const TrueTree& tree, double radius) {
  std::size_t best = 0;
  double least = 1e300;
  for (std::size_t b = 0; b < tree.branches.size(); ++b) {
    const double off = std::abs(std::log(tree.branches[b].healthy.back() / radius));
    if (!tree.branches[b].daughters.empty() || off >= least) continue;
    least = off;
    best = b;
  }
  return best;
}

/// Adds a branch of another tree, and all that hangs on it, turned round: the vessel through which
/// it is come to (`from`, a daughter or the parent) has become its parent (-1: none).
inline void append_reversed(const TrueTree& other, int b, int from, int parent, TrueTree& tree) {
  const TrueBranch& source = other.branches[std::size_t(b)];
  const bool is_against = from != source.parent;
  TrueBranch branch = source;
  branch.parent = parent;
  branch.daughters.clear();
  if (is_against) {
    for (auto* values : {&branch.healthy, &branch.ectatic, &branch.radius})
      std::reverse(values->begin(), values->end());
    std::reverse(branch.points.begin(), branch.points.end());
    std::reverse(branch.abscissa.begin(), branch.abscissa.end());
    for (double& s : branch.abscissa) s = source.abscissa.back() - s;
  }
  const int at = int(tree.branches.size());
  tree.branches.push_back(branch);
  if (parent >= 0) tree.branches[std::size_t(parent)].daughters.push_back(at);
  if (!is_against) {
    for (const int daughter : source.daughters) append_reversed(other, daughter, b, at, tree);
  } else if (source.parent >= 0) {
    append_reversed(other, source.parent, b, at, tree);
    for (const int sister : other.branches[std::size_t(source.parent)].daughters)
      if (sister != b) append_reversed(other, sister, source.parent, at, tree);
  }
}

/// The same tree, entered by another of its ends.
inline TrueTree entered_at(const TrueTree& tree, std::size_t end) {
  TrueTree turned;
  turned.least_radius = tree.least_radius;
  append_reversed(tree, int(end), -2, -1, turned);
  return turned;
}

/// The same vector after the turn that takes unit vector u to w.
inline Vec3 turned(const Vec3& vector, const Vec3& u, const Vec3& w) {
  const Vec3 axis = cross(u, w);
  const double cosine = dot(u, w);
  return cosine * vector + cross(axis, vector) +
         (dot(axis, vector) / std::max(1.0 + cosine, 1e-9)) * axis;
}

/// Joins another tree to an end of this one, as communicating arteries do: the two ends that are
/// wide as one another become one vessel, and the other tree's trunk is a second inlet.
inline void join(TrueTree& tree, TrueTree other) {
  const auto end = find_end(tree, 1e-9);  // the thinnest
  const double radius = tree.branches[end].healthy.back();
  const auto others = find_end(other, radius);
  const auto direction = [](const TrueBranch& branch) {
    return normalized(branch.points.back() - branch.points[branch.points.size() - 10]);
  };
  const double scale = radius / other.branches[others].healthy.back();
  const Vec3 from = other.branches[others].points.back(), to = tree.branches[end].points.back();
  const Vec3 inwards = -1.0 * direction(other.branches[others]);
  const Vec3 ahead = direction(tree.branches[end]);
  for (TrueBranch& branch : other.branches) {
    for (Vec3& point : branch.points) point = to + scale * turned(point - from, inwards, ahead);
    for (auto* values : {&branch.abscissa, &branch.healthy, &branch.ectatic})
      for (double& value : *values) value *= scale;
  }
  append_reversed(other, int(others), -2, int(end), tree);
  // The two are one vessel.
  TrueBranch& first = tree.branches[end];
  const int second_at = first.daughters.front();
  const TrueBranch second = tree.branches[std::size_t(second_at)];
  const double length = first.abscissa.back();
  for (std::size_t i = 1; i < second.points.size(); ++i) {
    first.points.push_back(second.points[i]);
    first.abscissa.push_back(length + second.abscissa[i]);
    first.healthy.push_back(second.healthy[i]);
    first.ectatic.push_back(second.ectatic[i]);
  }
  first.daughters = second.daughters;
  tree.branches.erase(tree.branches.begin() + second_at);
  for (TrueBranch& branch : tree.branches) {
    if (branch.parent == second_at) branch.parent = int(end);
    if (branch.parent > second_at) --branch.parent;
    for (int& daughter : branch.daughters)
      if (daughter > second_at) --daughter;
  }
}

inline TrueTree draw_tree(unsigned seed, const GrowOptions& grow = {}) {
  Draw draw{std::mt19937(seed)};
  for (int i = 0; i < 10; ++i) draw.random();
  TrueTree tree = grow_tree(draw, grow);
  if (grow.with_two_inlets) join(tree, grow_tree(draw, grow));
  for (int k = grow.with_aneurysms ? 1 + int(draw.random() % 2) : 0; k > 0; --k)
    draw_aneurysm(draw, tree.branches[draw.random() % tree.branches.size()]);
  tree.least_radius = 1e9;
  for (TrueBranch& branch : tree.branches) {
    branch.radius = branch.ectatic;
    for (const double r : branch.healthy) tree.least_radius = std::min(tree.least_radius, r);
  }
  const int lesions = draw.chance(0.25) ? 0 : 1 + int(draw.between(0.0, 4.0));
  for (int k = 0; k < lesions; ++k) {
    auto& branch = tree.branches[draw.random() % tree.branches.size()];
    draw_lesion(draw, tree, branch, draw.between(0.0, 0.95));
    if (draw.chance(0.2)) draw_lesion(draw, tree, branch, draw.between(0.0, 0.95));  // tandem
  }
  return tree;
}

}  // namespace angio::benchmarks
