#include "viewer/case_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "viewer/detail/course.hpp"
#include "viewer/detail/scene.hpp"
#include "viewer/detail/view_frame.hpp"

namespace angio::viewer {
using namespace detail;
using formats::GltfBody;
namespace {

constexpr std::size_t kMostFrames = 40;

/// Evenly from the first to the last; the nearest to the peak gives way to it.
std::vector<std::size_t> chosen_frames(std::size_t count, std::size_t peak) {
  const std::size_t steps = std::min(count, kMostFrames) - 1;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i <= steps; ++i)
    places.push_back(steps == 0 ? 0 : i * (count - 1) / steps);
  const auto away = [&](std::size_t place) { return place > peak ? place - peak : peak - place; };
  *std::min_element(places.begin(), places.end(),
                    [&](auto a, auto b) { return away(a) < away(b); }) = peak;
  return places;
}

/// glTF's colours are linear, pictures' are sRGB: about the power 2.2.
std::array<double, 3> linear(const Rgb& color) {
  std::array<double, 3> result{};
  for (std::size_t c = 0; c < 3; ++c) result[c] = std::pow(color[c] / 255.0, 2.2);
  return result;
}

void add_shape(std::vector<Vec3> points, std::vector<Triangle> triangles, GltfBody& body) {
  if (body.mesh.vertices.empty())
    body.mesh = {std::move(points), std::move(triangles)};
  else
    body.later.push_back(std::move(points));
}

}  // namespace

formats::GltfScene read_case_scene(const std::filesystem::path& case_folder,
                                   const Progress& progress) {
  const Course course = read_course(case_folder);
  const auto& frames = course.data.frames;
  GltfBody wall{"wall", {}, linear(colors::kLumen), 0.35, {}};
  GltfBody balloon{"balloon", {}, linear(colors::kBalloon), 0.6, {}};
  GltfBody wire{"guidewire", {}, linear(colors::kGuidewire), 1.0, {}};
  formats::GltfScene scene;
  for (const std::size_t place : chosen_frames(frames.size(), course.peak)) {
    progress.report(double(place) / double(frames.size()), "reading frames");
    Moment moment = read_moment(frames[place]);
    scene.times_s.push_back(frames[place].time_s);
    add_shape(std::move(moment.wall.vertices), std::move(moment.wall.triangles), wall);
    add_shape(std::move(moment.balloon.vertices), std::move(moment.balloon.triangles), balloon);
    if (!moment.guidewire.empty()) add_shape(std::move(moment.guidewire), {}, wire);
  }
  // The part that the simulation moves is left out of the lumen.
  const TriangleMesh rest = surroundings(course.content.lumen, wall.mesh, bounds(wall.mesh).center,
                                         std::numeric_limits<double>::max());
  if (!rest.triangles.empty())
    scene.bodies.push_back({"lumen", rest, linear(colors::kSurroundings), 0.35, {}});
  scene.bodies.push_back(std::move(wire));
  scene.bodies.push_back(std::move(balloon));
  scene.bodies.push_back(std::move(wall));
  std::erase_if(scene.bodies, [](const GltfBody& body) { return body.mesh.vertices.empty(); });
  progress.report(1.0);
  return scene;
}

}  // namespace angio::viewer
