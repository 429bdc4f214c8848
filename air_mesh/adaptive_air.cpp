#include "air_mesh/adaptive_air.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <set>

#include "air_mesh/air_points.hpp"
#include "air_mesh/folds.hpp"

namespace angio::air_mesh {
namespace {

constexpr double kLeastStep = 0.03;     // of a motion
constexpr int kLasting = 4;             // motions that a mesh should do, to be worth building
constexpr int kLongestPause = 32;       // motions after one that has not, or could not be built
constexpr double kMostLeftOut = 0.005;  // of the volume of a mesh that is whole
constexpr double kTangled = 0.1;        // share of inverted tets
constexpr int kMostTries = 48;          // steps of a motion

Triangle ascending(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

using Edge = std::array<int, 2>;

std::array<Edge, 3> edges_of(const Triangle& t) {
  return {Edge{t[0], t[1]}, Edge{t[1], t[2]}, Edge{t[0], t[2]}};
}

// A mesh's outer faces, corners ascending, in ascending order.
std::vector<Triangle> outer_faces(const TetTopology& air) {
  std::vector<Triangle> faces;
  for (const TetFace& f : air.boundary()) faces.push_back(ascending(air.face(f.tet, f.corner)));
  std::sort(faces.begin(), faces.end());
  return faces;
}

// Edges with one triangle, ascending; the triangles' corners ascend.
std::vector<Edge> rims_of(const std::vector<Triangle>& triangles) {
  std::map<Edge, int> count;
  for (const Triangle& t : triangles)
    for (const Edge& e : edges_of(t)) ++count[e];
  std::vector<Edge> rims;
  for (const auto& [edge, n] : count)
    if (n == 1) rims.push_back(edge);
  return rims;
}

// The tets that were left out of a mesh for being flat: over two bare triangles of the surfaces
// that share an edge, where the mesh has its faces over the other diagonal.
//
// @param bare  corners ascending
std::vector<Tet> flat_tets(const TetTopology& air, const std::vector<Triangle>& bare) {
  std::map<Triangle, Triangle> open;  // the mesh's outer faces, by their corners ascending
  for (const TetFace& f : air.boundary()) {
    const Triangle face = air.face(f.tet, f.corner);
    open[ascending(face)] = face;
  }
  std::map<Edge, int> third;  // of the bare triangle seen first at an edge
  std::vector<Tet> result;
  for (const Triangle& t : bare)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], c = t[(k + 1) % 3], d = t[(k + 2) % 3];
      const auto [seen, is_first] = third.try_emplace(Edge{std::min(a, c), std::max(a, c)}, d);
      if (is_first) continue;
      const int b = seen->second;
      const auto face = open.find(ascending({a, b, d}));
      if (face == open.end() || open.count(ascending({b, c, d})) == 0) continue;
      const Triangle& f = face->second;  // right-handed with what lies beyond it
      result.push_back({f[0], f[2], f[1], c});
    }
  return result;
}

// Does each of these triangles hang together with an edge where some surfaces end?
bool hang_on_rims(std::vector<Triangle> open, const std::vector<Triangle>& surfaces) {
  if (open.empty()) return true;
  const std::vector<Edge> rims = rims_of(surfaces);
  std::set<Edge> reached(rims.begin(), rims.end());
  for (std::size_t before = open.size() + 1; open.size() < before;) {
    before = open.size();
    std::erase_if(open, [&](const Triangle& t) {
      const auto edges = edges_of(t);
      const bool hangs = std::any_of(edges.begin(), edges.end(),
                                     [&](const Edge& e) { return reached.count(e) > 0; });
      if (hangs) reached.insert(edges.begin(), edges.end());
      return hangs;
    });
  }
  return open.empty();
}

}  // namespace

AdaptiveAir::AdaptiveAir(std::vector<Tet> tets, const std::vector<Vec3>& x,
                         std::vector<Triangle> surfaces, AirMesher mesher)
    : air_(tets),
      surfaces_(std::move(surfaces)),
      mesher_(std::move(mesher)),
      x_(x),
      surface_count_(x.size()) {
  for (Triangle& t : surfaces_) t = ascending(t);
  std::sort(surfaces_.begin(), surfaces_.end());
  const std::vector<Tet> flat = flat_tets(air_, bare_surfaces(air_));
  if (!flat.empty()) {
    tets.insert(tets.end(), flat.begin(), flat.end());
    air_ = TetTopology(tets);
  }
  closed_ = !tets.empty() && covers_surfaces(air_);
  measure();
  tried_ = quality_;
  count_volumes();
}

double AdaptiveAir::quality_of(const Tet& t) const {
  return tet_quality(x_[std::size_t(t[0])], x_[std::size_t(t[1])], x_[std::size_t(t[2])],
                     x_[std::size_t(t[3])]);
}

std::vector<Triangle> AdaptiveAir::bare_surfaces(const TetTopology& air) const {
  std::vector<Triangle> outer = outer_faces(air), bare;
  std::set_difference(surfaces_.begin(), surfaces_.end(), outer.begin(), outer.end(),
                      std::back_inserter(bare));
  return bare;
}

bool AdaptiveAir::is_surface(Triangle face) const {
  return std::binary_search(surfaces_.begin(), surfaces_.end(), ascending(face));
}

// All but what hangs on a rim, and nothing is open in the middle.
bool AdaptiveAir::covers_surfaces(const TetTopology& air) const {
  return hang_on_rims(bare_surfaces(air), surfaces_) && ends_where_surfaces_do(air);
}

// What of its outside is no surface are caps where the covered surfaces end: none around a hole in
// the middle.
bool AdaptiveAir::ends_where_surfaces_do(const TetTopology& air) const {
  std::vector<Triangle> covered, caps;
  for (const Triangle& face : outer_faces(air)) (is_surface(face) ? covered : caps).push_back(face);
  return hang_on_rims(std::move(caps), covered);
}

void AdaptiveAir::measure() {
  quality_.resize(std::size_t(air_.slot_count()), 1.0);
  tried_.resize(quality_.size(), 1.0);
  for (int t = 0; t < air_.slot_count(); ++t)
    if (air_.alive(t)) quality_[std::size_t(t)] = quality_of(air_.tet(t));
}

void AdaptiveAir::follow(const std::vector<Vec3>& x) {
  if (x_.empty()) return;
  ++turn_;
  if (each_time_) drop();
  if (closed_)
    adapt(x);
  else
    x_ = x;
  if (is_whole()) return;
  const bool has_lasted = turn_ - built_ >= kLasting;
  if (has_lasted) pause_ = 1;
  if (mesher_.whole && (turn_ >= resume_ || has_lasted || each_time_)) {
    resume_ = turn_ + pause_;
    pause_ = std::min(2 * pause_, kLongestPause);
    rebuild_whole();
    built_ = turn_;
  }
  // The surfaces may cross, or be about to. Flips in a tangled mesh would not end.
  if (is_tangled()) drop();
}

// First tries the whole motion at once. If a tet inverts, splits the motion into shorter steps;
// after some of them makes the rest at once and accepts the result.
void AdaptiveAir::adapt(const std::vector<Vec3>& x) {
  const std::vector<Vec3> from(x_.begin(), x_.begin() + std::ptrdiff_t(surface_count_));
  double done = 0.0, step = 1.0;
  for (int tries = 1; done < 1.0; ++tries) {
    if (tries >= kMostTries) step = 1.0;
    const double next = std::min(1.0, done + step);
    std::vector<Vec3> target(surface_count_);
    for (std::size_t v = 0; v < surface_count_; ++v)
      target[v] = next == 1.0 ? x[v] : from[v] + next * (x[v] - from[v]);
    if (move_to(target, step > kLeastStep && tries < kMostTries))
      done = next;
    else
      step *= 0.5;
  }
  remove_points();
  count_volumes();
  if (!left_out_.empty() && (!is_whole() || turn_ >= folds_resume_)) mend_folds();
}

bool AdaptiveAir::is_tangled() const { return inverted_count() > kTangled * air_.tet_count(); }

void AdaptiveAir::drop() {
  air_ = TetTopology();
  x_.resize(surface_count_);
  points_.clear();
  quality_.clear();
  tried_.clear();
  closed_ = false;
  count_volumes();
}

// false, with nothing changed, if more tets stay inverted than before and `may_fail`.
bool AdaptiveAir::move_to(const std::vector<Vec3>& x, bool may_fail) {
  const int bearable = inverted_count();
  const std::vector<Vec3> before = x_;
  const std::vector<Point> points = points_;
  std::copy(x.begin(), x.end(), x_.begin());
  move_points(before);
  measure();
  queue_fallen();
  if (queue_.empty() || queue_.front().quality > 0.0) {
    improve();
    return true;
  }
  const TetTopology air = air_;
  const std::vector<double> quality = quality_, tried = tried_;
  const AirReport report = report_;
  improve();
  mend_inverted(!may_fail);
  if (!may_fail || inverted_count() <= bearable) return true;
  air_ = air;
  x_ = before;
  points_ = points;
  quality_ = quality;
  tried_ = tried;
  report_ = report;
  return false;
}

int AdaptiveAir::inverted_count() const {
  int count = 0;
  for (int t = 0; t < air_.slot_count(); ++t)
    count += air_.alive(t) && quality_[std::size_t(t)] <= 0.0 ? 1 : 0;
  return count;
}

AirReport AdaptiveAir::take_report() {
  const AirReport result = report_;
  report_.flip_count = report_.rebuild_count = 0;
  return result;
}

void AdaptiveAir::leave_out_folds() {
  left_out_.clear();
  if (is_tangled()) return;
  const Folds folds = find_folds(air_, x_, quality_);
  std::merge(folds.inverted.begin(), folds.inverted.end(), folds.overlapping.begin(),
             folds.overlapping.end(), std::back_inserter(left_out_));
}

bool AdaptiveAir::is_whole() const {
  return closed_ && report_.inverted_count == 0 && report_.left_out_share <= kMostLeftOut;
}

std::vector<Tet> AdaptiveAir::tets() const {
  std::vector<Tet> result;
  auto out = left_out_.begin();
  for (int t = 0; t < air_.slot_count(); ++t) {
    const bool is_out = out != left_out_.end() && *out == t;
    if (is_out) ++out;
    if (air_.alive(t) && !is_out) result.push_back(air_.tet(t));
  }
  return result;
}

void AdaptiveAir::count_volumes() {
  leave_out_folds();
  report_.left_out_count = int(left_out_.size());
  report_.tet_count = air_.tet_count() - report_.left_out_count;
  const auto volume_of = [&](const Tet& t) {
    return tet_volume(x_[std::size_t(t[0])], x_[std::size_t(t[1])], x_[std::size_t(t[2])],
                      x_[std::size_t(t[3])]);
  };
  double kept = 0.0, left_out = 0.0, least = std::numeric_limits<double>::infinity();
  report_.inverted_count = 0;
  for (const Tet& t : tets()) {
    const double volume = volume_of(t);
    kept += volume;
    least = std::min(least, volume);
    report_.inverted_count += volume <= 0.0 ? 1 : 0;
  }
  for (const int t : left_out_) left_out += volume_of(air_.tet(t));  // with signs: each point once
  report_.min_volume = report_.tet_count > 0 ? least : 0.0;
  report_.left_out_share = left_out_.empty() ? 0.0 : left_out / (kept + left_out);
  report_.point_count = 0;
  for (const Point& point : points_) report_.point_count += point.tet >= 0 ? 1 : 0;
}

// A point goes with the vertices around it, and back to the middle where that brings it near the
// outside of its star.
void AdaptiveAir::move_points(const std::vector<Vec3>& before) {
  constexpr double kNear = 0.8;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    Point& point = points_[i];
    if (point.tet < 0) continue;
    const std::vector<Triangle> faces =
        outside_of(air_, star_of(air_, point.tet, int(surface_count_ + i)));
    if (faces.empty()) continue;  // two tets that cancel each other: they are mended away
    Vec3 motion;
    for (const Triangle& f : faces)
      for (const int v : f)
        if (std::size_t(v) < surface_count_) motion += x_[std::size_t(v)] - before[std::size_t(v)];
    Vec3& at = x_[surface_count_ + i];
    at += motion / double(3 * faces.size());
    double height = point.height;
    for (const Triangle& f : faces) {
      const Vec3& a = x_[std::size_t(f[0])];
      const Vec3 n = normalized(cross(x_[std::size_t(f[1])] - a, x_[std::size_t(f[2])] - a));
      height = std::min(height, dot(n, at - a));
    }
    if (height >= kNear * point.height) continue;
    const InnerPoint inner = find_inner_point(faces, x_, at);
    at = inner.point;
    point.height = inner.height;
  }
}

void AdaptiveAir::rebuild_whole() {
  const TetMesh mesh = mesher_.whole({x_.begin(), x_.begin() + std::ptrdiff_t(surface_count_)});
  if (mesh.tets.empty() || !covers_surfaces(TetTopology(mesh.tets))) return;
  ++report_.rebuild_count;
  closed_ = true;
  take(mesh);
  mend_folds();
  count_volumes();
}

// Goes on with another mesh of the gap: the surfaces' vertices, then points in the air.
void AdaptiveAir::take(const TetMesh& mesh) {
  air_ = TetTopology(mesh.tets);
  x_.resize(surface_count_);
  x_.insert(x_.end(), mesh.vertices.begin() + std::ptrdiff_t(surface_count_), mesh.vertices.end());
  points_.assign(x_.size() - surface_count_, {});
  for (int t = 0; t < air_.slot_count(); ++t)
    for (const int v : air_.tet(t))
      if (std::size_t(v) >= surface_count_) points_[std::size_t(v) - surface_count_].tet = t;
  quality_.clear();
  tried_.clear();
  measure();
  queue_fallen();
  improve();
}

}  // namespace angio::air_mesh
