#include "formats/detail/surface_cleanup.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <unordered_map>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/frames.hpp"

namespace angio::formats::detail {
namespace {

struct PointHash {
  std::size_t operator()(const Vec3& p) const noexcept {
    std::uint64_t hash = 0;
    for (int axis = 0; axis < 3; ++axis) {
      // Adding zero turns -0 into +0, which compare equal and so must hash alike.
      hash = (hash ^ std::bit_cast<std::uint64_t>(p[axis] + 0.0)) * 0x9E3779B97F4A7C15ull;
      hash ^= hash >> 29;
    }
    return std::size_t(hash);
  }
};

/// Keeps the tuples whose place is set in `kept`, in order.
void keep_tuples(std::vector<DataArray>& arrays, const std::vector<char>& kept) {
  for (DataArray& array : arrays) {
    const auto width = std::size_t(array.component_count);
    std::size_t end = 0;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (!kept[i]) continue;
      for (std::size_t c = 0; c < width; ++c) array.values[end++] = array.values[i * width + c];
    }
    array.values.resize(end);
  }
}

}  // namespace

SurfaceData merge_equal_points(SurfaceData data) {
  std::unordered_map<Vec3, int, PointHash> index_of;
  index_of.reserve(data.mesh.vertices.size());
  std::vector<Vec3> merged;
  std::vector<int> new_index(data.mesh.vertices.size());
  std::vector<char> point_kept(data.mesh.vertices.size());
  for (std::size_t v = 0; v < data.mesh.vertices.size(); ++v) {
    const Vec3& point = data.mesh.vertices[v];
    const auto [place, is_new] = index_of.try_emplace(point, int(merged.size()));
    if (is_new) merged.push_back(point);
    new_index[v] = place->second;
    point_kept[v] = char(is_new);
  }
  if (merged.size() == data.mesh.vertices.size()) return data;

  std::vector<Triangle> triangles;
  std::vector<char> triangle_kept(data.mesh.triangles.size());
  for (std::size_t t = 0; t < data.mesh.triangles.size(); ++t) {
    Triangle corners = data.mesh.triangles[t];
    for (int& corner : corners) corner = new_index[std::size_t(corner)];
    triangle_kept[t] =
        corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0];
    if (triangle_kept[t]) triangles.push_back(corners);
  }
  data.mesh.vertices = std::move(merged);
  data.mesh.triangles = std::move(triangles);
  keep_tuples(data.point_arrays, point_kept);
  keep_tuples(data.cell_arrays, triangle_kept);
  return data;
}

void require_finite(const std::vector<Vec3>& points, const std::string& name) {
  for (const Vec3& p : points)
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      throw InputError(name +
                       " has a point that is not a number (the file is damaged or its export went "
                       "wrong). Export the surface again");
}

void require_usable(const SurfaceData& data, const std::string& name) {
  if (data.mesh.triangles.empty())
    throw InputError(name + " holds no triangles (it is empty, or not a surface). Give a surface");
  require_finite(data.mesh.vertices, name);
  const auto count = int(data.mesh.vertices.size());
  for (const Triangle& triangle : data.mesh.triangles)
    for (const int corner : triangle)
      if (corner < 0 || corner >= count)
        throw InputError(name +
                         " names a point that it does not have (the file is damaged). "
                         "Export the surface again");
}

void swap_ras_lps(std::vector<Vec3>& points) {
  for (Vec3& point : points) point = lps_from_ras(point);
}

void require_input(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    throw InputError("no such file: " + path.string(), ExitCode::no_input);
  if (!std::filesystem::is_regular_file(path, ignored))
    throw InputError(path.string() + " is not a file. Give a surface file");
  if (std::filesystem::file_size(path, ignored) == 0)
    throw InputError(path.string() + " is empty (its copy or export was cut short). Copy it again");
  if (!std::ifstream(path))
    throw IoError("cannot read " + path.string() + " (permission?). Check it, or copy it again");
}

std::string read_input(const std::filesystem::path& path) {
  require_input(path);
  return read_text(path);
}

}  // namespace angio::formats::detail
