#include "pipeline/case/mask_on_grid.hpp"

#include <cmath>

namespace angio::pipeline {

Volume<std::uint8_t> mask_on_grid(const Volume<float>& mask, const VolumeGeometry& grid) {
  Volume<std::uint8_t> result(grid);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 at =
            mask.geometry.index_from_lps(grid.lps_from_index({double(i), double(j), double(k)}));
        const auto nearest = [](double index) { return int(std::floor(index + 0.5)); };
        const int x = nearest(at.x), y = nearest(at.y), z = nearest(at.z);
        if (mask.geometry.contains(x, y, z) && mask.at(x, y, z) > 0.5F) result.at(i, j, k) = 1;
      }
  return result;
}

}  // namespace angio::pipeline
