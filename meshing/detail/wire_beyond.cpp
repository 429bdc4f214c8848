#include "meshing/detail/wire_beyond.hpp"

#include <algorithm>
#include <cmath>

#include "meshing/detail/balloon_axis.hpp"

namespace angio::meshing::detail {
namespace {

// From the pole on, outwards. `way` is 1 along the path and -1 against it.
std::vector<Vec3> nodes_beyond(const CenterlinePath& path, double sigma, double way,
                               const Vec3& pole, const Vec3& inner) {
  const double from = project(path, pole);
  const double room = way > 0.0 ? path.abscissa.back() - from : from - path.abscissa.front();
  const double spacing = distance(pole, inner);
  const int count = spacing > 0.0 ? int(std::floor(std::min(kWireBeyond, room) / spacing)) : 0;
  const auto smooth = [&](double s) { return smoothed_point(path, from + way * s, sigma); };
  const double width = std::max(2.0 * sample(path, from).inscribed_radius, spacing);
  const double step = 0.1 * spacing;
  const Vec3 offset = pole - smooth(0.0);
  const Vec3 turn = normalized(pole - inner) - (smooth(step) - smooth(-step)) / (2.0 * step);
  std::vector<Vec3> nodes;
  for (int i = 1; i <= count; ++i) {
    const double s = spacing * i, u = std::min(1.0, s / width);
    nodes.push_back(smooth(s) +
                    (1.0 - u) * (1.0 - u) * ((1.0 + 2.0 * u) * offset + u * width * turn));
  }
  return nodes;
}

}  // namespace

void extend_wire(const CenterlinePath& path, double sigma, Balloon& balloon) {
  const std::vector<Vec3>& wire = balloon.guidewire;
  if (wire.size() < 2) return;
  balloon.guidewire_before = nodes_beyond(path, sigma, -1.0, wire[0], wire[1]);
  std::reverse(balloon.guidewire_before.begin(), balloon.guidewire_before.end());
  balloon.guidewire_behind = nodes_beyond(path, sigma, 1.0, wire.back(), wire.end()[-2]);
}

}  // namespace angio::meshing::detail
