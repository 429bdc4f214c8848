#include "simulation/balloon_measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/units.hpp"

namespace angio::simulation {

SharpestFold sharpest_fold(const TriangleMesh& balloon, const std::vector<char>& fixed) {
  std::map<std::pair<int, int>, Vec3> normal_at;  // of the first triangle at an edge
  SharpestFold sharpest;
  for (const Triangle& t : balloon.triangles) {
    const Vec3 &a = balloon.vertices[std::size_t(t[0])], &b = balloon.vertices[std::size_t(t[1])],
               &c = balloon.vertices[std::size_t(t[2])];
    const Vec3 normal = cross(b - a, c - a);
    for (std::size_t k = 0; k < 3; ++k) {
      const int v = t[k], w = t[(k + 1) % 3];
      if (fixed[std::size_t(v)] != 0 || fixed[std::size_t(w)] != 0) continue;
      const auto [other, is_new] = normal_at.try_emplace(std::minmax({v, w}), normal);
      if (is_new) continue;
      const double angle =
          std::atan2(norm(cross(normal, other->second)), dot(normal, other->second)) * 180.0 /
          units::kPi;
      if (angle > sharpest.angle_degrees)
        sharpest = {angle,
                    0.5 * (balloon.vertices[std::size_t(v)] + balloon.vertices[std::size_t(w)])};
    }
  }
  return sharpest;
}

double elongation_mm(const SimulationModel& model, const std::vector<Vec3>& balloon) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (model.guidewire.size() < 2) return kNone;
  const Vec3 along = normalized(model.guidewire.back() - model.guidewire.end()[-2]);
  double sum = 0.0;
  int count = 0;
  for (std::size_t v = 0; v < model.balloon_sliding.size(); ++v) {
    if (model.balloon_sliding[v] == 0) continue;
    sum += dot(along, balloon[v] - model.balloon.vertices[v]);
    ++count;
  }
  return count > 0 ? sum / count : kNone;
}

double dogboning_percent(const SimulationFrame& frame) {
  if (frame.end_diameters_mm.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double end =
      *std::max_element(frame.end_diameters_mm.begin(), frame.end_diameters_mm.end());
  return 100.0 * (end - frame.balloon_diameter_mm) / end;
}

WholeWire whole_wire(const SimulationModel& model, const std::vector<Vec3>& inside) {
  const std::vector<Vec3>&before = model.guidewire_before, &behind = model.guidewire_behind;
  WholeWire wire;
  const auto add = [&](const Vec3& p, bool is_inside) {
    wire.nodes.push_back(p);
    wire.in_balloon.push_back(is_inside ? 1 : 0);
  };
  const auto fade = [](double u) { return 1.0 - u * u * (3.0 - 2.0 * u); };
  const auto moved = [&](std::size_t end) {
    return inside.empty() || model.guidewire.empty()
               ? Vec3()
               : inside[end * (inside.size() - 1)] -
                     model.guidewire[end * (model.guidewire.size() - 1)];
  };
  const Vec3 first = moved(0), last = moved(1);
  for (std::size_t i = 0; i < before.size(); ++i)
    add(before[i] + fade(1.0 - double(i) / double(before.size())) * first, false);
  for (const Vec3& p : inside) add(p, true);
  for (std::size_t i = 0; i < behind.size(); ++i)
    add(behind[i] + fade(double(i + 1) / double(behind.size())) * last, false);
  return wire;
}

}  // namespace angio::simulation
