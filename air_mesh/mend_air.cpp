#include <algorithm>
#include <cstdio>
#include <set>

#include "air_mesh/adaptive_air.hpp"
#include "air_mesh/air_points.hpp"
#include "air_mesh/folds.hpp"
#include "air_mesh/tet_flips.hpp"
#include "air_mesh/tet_refill.hpp"

// What AdaptiveAir does to tets that have become bad.
namespace angio::air_mesh {
namespace {

constexpr double kGood = 0.3;     // quality that needs no work
constexpr double kFallen = 0.7;   // share of the quality at the last work: to be worked on again
constexpr int kMostRounds = 4;    // of mending
constexpr int kMostSteps = 300;   // of the search for a filling without a point
constexpr int kMostAround = 80;   // tets taken out around a new point
constexpr int kMostHollows = 12;  // meshed a motion
constexpr int kMostLayers = 3;    // of tets taken out: a fold, and what is around it
constexpr std::size_t kMostInHollow = 400;  // tets
constexpr int kEnough = 8;                  // places for a point, of which the best is taken
constexpr int kMostMends = 16;              // places a round
constexpr int kLongestRest = 16;            // motions for which folds are let be
constexpr int kLeastPatience = 8;           // motions between two attempts to do without a point,
constexpr int kMostPatience = 64;           // twice as many after each that fails

// With the tets that share a vertex with some.
std::vector<int> widened(const TetTopology& air, const std::vector<int>& tets) {
  std::set<int> vertices;
  for (const int t : tets)
    for (const int v : air.tet(t)) vertices.insert(v);
  std::vector<int> result;
  for (int t = 0; t < air.slot_count(); ++t) {
    if (!air.alive(t)) continue;
    const Tet& corners = air.tet(t);
    if (std::any_of(corners.begin(), corners.end(), [&](int v) { return vertices.count(v) > 0; }))
      result.push_back(t);
  }
  return result;
}

}  // namespace

void AdaptiveAir::queue_fallen() {
  queue_.clear();
  for (int t = 0; t < air_.slot_count(); ++t) {
    const double q = quality_[std::size_t(t)];
    if (air_.alive(t) && (q <= 0.0 || (q < kGood && q < kFallen * tried_[std::size_t(t)])))
      queue_.push_back({q, t});
  }
  std::sort(queue_.begin(), queue_.end(), [](const Work& a, const Work& b) {
    return a.quality != b.quality ? a.quality < b.quality : a.slot < b.slot;
  });
}

void AdaptiveAir::improve() {
  // New tets queue up behind; each flip raises a least quality, so that it ends.
  for (std::size_t i = 0; i < queue_.size(); ++i) {
    const int t = queue_[i].slot;
    if (!air_.alive(t) || quality_[std::size_t(t)] != queue_[i].quality) continue;  // replaced
    tried_[std::size_t(t)] = quality_[std::size_t(t)];
    flip(t);
  }
  queue_.clear();
}

bool AdaptiveAir::flip(int t) {
  const TetFlip best = best_flip(air_, x_, t);
  if (best.old_count == 0 || (best.after <= 0.0 && best.fresh_count > best.old_count) ||
      !put_in_place(best.old.data(), best.old_count, best.fresh.data(), best.fresh_count))
    return false;
  ++report_.flip_count;
  return true;
}

bool AdaptiveAir::put_in_place(const int* old, int old_count, const Tet* fresh, int fresh_count) {
  std::vector<int> gone;  // points of the air
  for (int i = 0; i < old_count; ++i)
    for (const int v : air_.tet(old[i]))
      if (std::size_t(v) >= surface_count_) gone.push_back(v);
  std::vector<int> slots(std::size_t(fresh_count), 0);
  if (!air_.replace(old, old_count, fresh, fresh_count, slots.data())) return false;
  for (const int v : gone) points_[std::size_t(v) - surface_count_].tet = -1;
  quality_.resize(std::size_t(air_.slot_count()));
  tried_.resize(quality_.size());
  for (const int slot : slots) {
    const double q = quality_of(air_.tet(slot));
    quality_[std::size_t(slot)] = tried_[std::size_t(slot)] = q;
    if (q < kGood) queue_.push_back({q, slot});
    for (const int v : air_.tet(slot))
      if (std::size_t(v) >= surface_count_) points_[std::size_t(v) - surface_count_].tet = slot;
  }
  for (const int v : gone) find_again(v);
  return true;
}

// A point between folds may have tets that do not hang together with those that were replaced.
void AdaptiveAir::find_again(int vertex) {
  int& tet = points_[std::size_t(vertex) - surface_count_].tet;
  for (int t = 0; tet < 0 && t < air_.slot_count(); ++t) {
    const Tet& v = air_.tet(t);
    if (air_.alive(t) && std::find(v.begin(), v.end(), vertex) != v.end()) tet = t;
  }
}

// A place that cannot be mended ends it, unless as much is to be mended as can be. A fold that had
// no room for a point has none from another of its tets either.
void AdaptiveAir::mend_inverted(bool all) {
  for (int round = 0; round < kMostRounds; ++round) {
    int places = 0;
    bool changed = false;
    std::set<int> without_room;
    for (int t = 0; t < air_.slot_count() && places < kMostMends; ++t) {
      if (!air_.alive(t) || quality_[std::size_t(t)] > 0.0) continue;
      ++places;
      bool mended = refill_around(t);
      if (!mended && without_room.count(t) == 0) {
        const std::vector<int> fold = inverted_around(t);
        mended = add_point(fold);
        if (!mended) without_room.insert(fold.begin(), fold.end());
      }
      if (!mended && !all) return;
      changed |= mended;
    }
    if (!changed) return;
    improve();
  }
}

bool AdaptiveAir::refill_around(int t) {
  const Refilling anew = air_mesh::refill_around(air_, x_, t);
  return !anew.fresh.empty() && put_in_place(anew.old.data(), int(anew.old.size()),
                                             anew.fresh.data(), int(anew.fresh.size()));
}

std::vector<int> AdaptiveAir::inverted_around(int t) const {
  std::vector<int> found{t};
  for (std::size_t i = 0; i < found.size(); ++i)
    for (int c = 0; c < 4; ++c) {
      const int next = air_.across(found[i], c).tet;
      if (next >= 0 && quality_[std::size_t(next)] <= 0.0 &&
          std::find(found.begin(), found.end(), next) == found.end())
        found.push_back(next);
    }
  return found;
}

bool AdaptiveAir::add_point(const std::vector<int>& fold) {
  InnerPoint best;
  std::vector<int> best_hollow;
  int successes = 0;
  HollowSearch search(air_, x_, fold);
  for (const Vec3& place : places_around(air_, x_, fold)) {
    SeenHollow hollow = search.find(place, kMostAround);
    if (hollow.tets.empty()) continue;
    const std::vector<Triangle> outside = outside_of(air_, hollow.tets);
    if (outside.empty())  // tets that cancel each other
      return put_in_place(hollow.tets.data(), int(hollow.tets.size()), nullptr, 0);
    const InnerPoint inner = find_inner_point(outside, x_, hollow.point);
    if (inner.height <= best.height) continue;
    best = inner;
    best_hollow = std::move(hollow.tets);
    if (++successes == kEnough) break;
  }
  if (best_hollow.empty()) return false;
  const int vertex = take_point(best.point, 0);
  points_[std::size_t(vertex) - surface_count_].height = best.height;
  std::vector<Tet> fresh;
  for (const Triangle& f : outside_of(air_, best_hollow))
    fresh.push_back({f[0], f[1], f[2], vertex});
  return put_in_place(best_hollow.data(), int(best_hollow.size()), fresh.data(), int(fresh.size()));
}

int AdaptiveAir::take_point(const Vec3& at, std::size_t index) {
  while (index < points_.size() && points_[index].tet >= 0) ++index;
  if (index == points_.size()) {
    points_.emplace_back();
    x_.emplace_back();
  }
  points_[index] = {};
  x_[surface_count_ + index] = at;
  return int(surface_count_ + index);
}

// Folds are taken out and their hollows meshed anew; as long as too much is left out, with more and
// more tets around them. Folds that stay, in a mesh that is whole without them, are let be for a
// while, and twice as long each time: each hollow is a call of the mesher.
void AdaptiveAir::mend_folds() {
  fill_folds();
  folds_pause_ = left_out_.empty() ? 1 : std::min(2 * folds_pause_, kLongestRest);
  folds_resume_ = turn_ + folds_pause_;
}

void AdaptiveAir::fill_folds() {
  int meshes = 0;
  for (int layers = 0; layers < kMostLayers && !is_tangled(); ++layers) {
    const Folds folds = find_folds(air_, x_, quality_);
    std::set<int> done;
    for (const int t : folds.inverted) {
      if (done.count(t) > 0) continue;
      std::vector<int> hollow = with_whole_folds(air_, folds, {t});
      done.insert(hollow.begin(), hollow.end());
      if (end_before_cap(hollow, Bare::at_rims)) break;  // slots have changed
      for (int layer = 0; layer < layers; ++layer)
        hollow = with_whole_folds(air_, folds, widened(air_, hollow));
      if (!mesher_.hollow || hollow.size() > kMostInHollow || ++meshes > kMostHollows) continue;
      if (fill_hollow(hollow)) {
        if (layers > 0) break;  // others may have had tets of this hollow
      } else if (end_before_cap(with_whole_folds(air_, folds, {t}), Bare::anywhere)) {
        break;
      }
    }
    improve();
    count_volumes();
    if (is_whole()) return;
  }
}

// Takes out tets at a cap that something has moved through, so that the mesh ends before it; with
// them all around their points in the air, which are to stay inside. A wall may leave by its rim; a
// balloon, by the middle of the cap.
bool AdaptiveAir::end_before_cap(const std::vector<int>& tets, Bare bare) {
  if (tets_at_caps({tets.begin(), tets.end()}).empty()) return false;
  std::set<int> points, gone(tets.begin(), tets.end());
  for (const int t : tets)
    for (const int v : air_.tet(t))
      if (std::size_t(v) >= surface_count_) points.insert(v);
  for (const int v : points) {
    const std::vector<int> star = star_of(air_, points_[std::size_t(v) - surface_count_].tet, v);
    gone.insert(star.begin(), star.end());
  }
  if (bare == Bare::anywhere && !hang_on_caps(gone)) return false;
  TetTopology rest = air_;
  rest.remove({gone.begin(), gone.end()});
  if (bare == Bare::at_rims ? !covers_surfaces(rest) : !ends_where_surfaces_do(rest)) return false;
  air_ = std::move(rest);
  for (const int v : points) {
    points_[std::size_t(v) - surface_count_].tet = -1;
    find_again(v);
  }
  return true;
}

std::vector<int> AdaptiveAir::tets_at_caps(const std::set<int>& tets) const {
  std::vector<int> found;
  for (const int t : tets)
    for (int c = 0; c < 4; ++c)
      if (air_.across(t, c).tet < 0 && !is_surface(air_.face(t, c))) {
        found.push_back(t);
        break;
      }
  return found;
}

// Is each of these tets, from face to face, connected with one at a cap?
bool AdaptiveAir::hang_on_caps(std::set<int> tets) const {
  std::vector<int> reached = tets_at_caps(tets);
  for (const int t : reached) tets.erase(t);
  for (std::size_t i = 0; i < reached.size(); ++i)
    for (int c = 0; c < 4; ++c)
      if (const int next = air_.across(reached[i], c).tet; tets.erase(next) > 0)
        reached.push_back(next);
  return tets.empty();
}

bool AdaptiveAir::fill_hollow(const std::vector<int>& hollow) {
  std::vector<Triangle> faces = outside_of(air_, hollow);
  std::vector<int> vertices;
  for (const Triangle& f : faces) vertices.insert(vertices.end(), f.begin(), f.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::vector<Vec3> x;
  for (const int v : vertices) x.push_back(x_[std::size_t(v)]);
  for (Triangle& f : faces)
    for (int& v : f)
      v = int(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin());
  TetMesh mesh = mesher_.hollow(x, faces);
  if (mesh.tets.empty()) return false;
  for (std::size_t v = x.size(), index = 0; v < mesh.vertices.size(); ++v) {
    vertices.push_back(take_point(mesh.vertices[v], index));
    index = std::size_t(vertices.back()) - surface_count_ + 1;
  }
  for (Tet& t : mesh.tets)
    for (int& v : t) v = vertices[std::size_t(v)];
  return put_in_place(hollow.data(), int(hollow.size()), mesh.tets.data(), int(mesh.tets.size()));
}

void AdaptiveAir::remove_points() {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    Point& point = points_[i];
    if (point.tet < 0) continue;
    if (point.pause == 0) {  // new, or from a mesh built anew: not all of them at a time
      point.pause = kLeastPatience;
      point.resume = turn_ + int(i) % kLeastPatience;
    }
    if (turn_ < point.resume) continue;
    point.resume = turn_ + point.pause;
    point.pause = std::min(2 * point.pause, kMostPatience);
    const std::vector<int> star = star_of(air_, point.tet, int(surface_count_ + i));
    std::vector<Tet> filling = refill(air_, x_, star, kMostSteps, int(surface_count_ + i));
    if (filling.empty()) continue;
    put_in_place(star.data(), int(star.size()), filling.data(), int(filling.size()));
  }
  improve();
}

}  // namespace angio::air_mesh
