#include "benchmarks/line_registration.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace angio::benchmarks {
namespace {

constexpr double kKept = 0.75;
enum class Scale { fixed, free };

Eigen::Vector3d vector_of(const Vec3& v) { return {v.x, v.y, v.z}; }

struct Pair {
  double away = 0.0;
  std::size_t from = 0, to = 0;
};

std::size_t nearest_to(const Vec3& place, const std::vector<Vec3>& points) {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < points.size(); ++n)
    if (const Vec3 off = points[n] - place; dot(off, off) < least) {
      least = dot(off, off);
      nearest = n;
    }
  return nearest;
}

/// The nearest pairs of each way.
std::vector<Pair> kept_pairs(const std::vector<Vec3>& moved, const std::vector<Vec3>& to) {
  std::vector<Pair> kept;
  const auto keep = [&](std::vector<Pair> all) {
    std::sort(all.begin(), all.end(), [](const Pair& a, const Pair& b) { return a.away < b.away; });
    all.resize(std::max<std::size_t>(3, std::size_t(kKept * double(all.size()))));
    kept.insert(kept.end(), all.begin(), all.end());
  };
  std::vector<Pair> there, back;
  for (std::size_t n = 0; n < moved.size(); ++n) {
    const std::size_t m = nearest_to(moved[n], to);
    there.push_back({distance(moved[n], to[m]), n, m});
  }
  for (std::size_t m = 0; m < to.size(); ++m) {
    const std::size_t n = nearest_to(to[m], moved);
    back.push_back({distance(moved[n], to[m]), n, m});
  }
  keep(std::move(there));
  keep(std::move(back));
  return kept;
}

double mean_of(const std::vector<Pair>& pairs) {
  double sum = 0.0;
  for (const Pair& pair : pairs) sum += pair.away;
  return sum / double(pairs.size());
}

std::vector<Vec3> moved_by(const Similarity& by, const std::vector<Vec3>& points) {
  std::vector<Vec3> moved;
  for (const Vec3& point : points) moved.push_back(by.apply(point));
  return moved;
}

struct Descent {
  Similarity found;
  double mean = 0.0;
};

/// @param start  keeps its handedness
Descent descend(Similarity start, const std::vector<Vec3>& from, const std::vector<Vec3>& to,
                Scale scale, int most_rounds) {
  constexpr double kSettled = 1e-5;
  const bool is_mirrored = start.turn.determinant() < 0.0;
  Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
  if (is_mirrored) mirror(0, 0) = -1.0;
  Descent descent{start, std::numeric_limits<double>::infinity()};
  for (int round = 0; round < most_rounds; ++round) {
    const std::vector<Pair> pairs = kept_pairs(moved_by(descent.found, from), to);
    const double mean = mean_of(pairs);
    if (mean > descent.mean - kSettled) break;
    descent.mean = mean;
    Eigen::Matrix3Xd a(3, Eigen::Index(pairs.size())), b = a;
    for (std::size_t n = 0; n < pairs.size(); ++n) {
      a.col(Eigen::Index(n)) = mirror * vector_of(from[pairs[n].from]);
      b.col(Eigen::Index(n)) = vector_of(to[pairs[n].to]);
    }
    const Eigen::Matrix4d fit = Eigen::umeyama(a, b, scale == Scale::free);
    const Eigen::Matrix3d linear = fit.topLeftCorner<3, 3>();
    descent.found.scale = std::cbrt(linear.determinant());
    descent.found.turn = linear / descent.found.scale * mirror;
    descent.found.shift = fit.topRightCorner<3, 1>();
  }
  return descent;
}

Eigen::Vector3d middle_of(const std::vector<Vec3>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Vec3& point : points) sum += vector_of(point);
  return sum / double(points.size());
}

/// Quaternions whose parts are -1, 0 or 1, each attitude once.
std::vector<Eigen::Matrix3d> attitudes() {
  std::vector<Eigen::Matrix3d> all;
  for (int w = -1; w <= 1; ++w)
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const int first = w != 0 ? w : x != 0 ? x : y != 0 ? y : z;
          if (first > 0)
            all.push_back(Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix());
        }
  return all;
}

std::vector<Vec3> every(const std::vector<Vec3>& points, std::size_t step) {
  std::vector<Vec3> some;
  for (std::size_t n = 0; n < points.size(); n += step) some.push_back(points[n]);
  return some;
}

}  // namespace

Vec3 Similarity::apply(const Vec3& point) const {
  const Eigen::Vector3d moved = scale * turn * vector_of(point) + shift;
  return {moved[0], moved[1], moved[2]};
}

std::vector<double> distances_to(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  std::vector<double> all;
  for (const Vec3& point : from) all.push_back(distance(point, to[nearest_to(point, to)]));
  return all;
}

Similarity register_rigidly(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  constexpr std::size_t kFew = 4;
  constexpr int kRounds = 60, kMoreRounds = 200;
  const std::vector<Vec3> few_from = every(from, kFew), few_to = every(to, kFew);
  Descent best{{}, std::numeric_limits<double>::infinity()};
  for (const double hand : {1.0, -1.0})
    for (const Eigen::Matrix3d& attitude : attitudes()) {
      Similarity start;
      start.turn = attitude * Eigen::Vector3d(hand, 1.0, 1.0).asDiagonal();
      start.shift = middle_of(few_to) - start.turn * middle_of(few_from);
      const Descent found = descend(start, few_from, few_to, Scale::fixed, kRounds);
      if (found.mean < best.mean) best = found;
    }
  return descend(best.found, from, to, Scale::fixed, kMoreRounds).found;
}

Similarity with_scale(const Similarity& start, const std::vector<Vec3>& from,
                      const std::vector<Vec3>& to) {
  constexpr int kRounds = 200;
  return descend(start, from, to, Scale::free, kRounds).found;
}

}  // namespace angio::benchmarks
