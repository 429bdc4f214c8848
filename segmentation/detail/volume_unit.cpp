#include "segmentation/detail/volume_unit.hpp"

#include <algorithm>
#include <string>

#include "segmentation/detail/format_number.hpp"

namespace angio::segmentation::detail {
namespace {

double longest_side(const VolumeGeometry& grid) {
  double longest = 0.0;
  for (int a = 0; a < 3; ++a)
    longest = std::max(longest, grid.size[std::size_t(a)] * grid.spacing[a]);
  return longest;
}

std::string in_words(const VolumeGeometry& grid, double factor) {
  std::string voxel;
  for (int a = 0; a < 3; ++a)
    voxel += (a == 0 ? "" : " x ") + format_number(factor * grid.spacing[a]);
  return "voxels of " + voxel + " mm, " + format_number(factor * longest_side(grid)) + " mm long";
}

}  // namespace

LengthUnit guess_unit(const VolumeGeometry& grid) {
  constexpr double kFinestVoxel = 0.08, kShortest = 30.0, kLongest = 2000.0;  // [mm]
  const double finest = std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
  const double longest = longest_side(grid);
  if (finest >= kFinestVoxel || longest >= kShortest) return LengthUnit::mm;
  for (const LengthUnit unit : {LengthUnit::cm, LengthUnit::m})
    if (const double side = longest * kMillimetresOf[int(unit)];
        side >= kShortest && side <= kLongest)
      return unit;
  return LengthUnit::mm;
}

void bring_to_mm(VolumeFile& file, const std::filesystem::path& path,
                 const std::optional<LengthUnit>& unit) {
  VolumeGeometry& grid = file.volume.geometry;
  const LengthUnit own = unit                                  ? *unit
                         : volume_file_format(path) == "NIfTI" ? LengthUnit::mm
                                                               : guess_unit(grid);
  const double factor = unit ? kMillimetresOf[int(own)] / file.unit_mm : kMillimetresOf[int(own)];
  if (factor == 1.0) return;
  const std::string name = kLengthUnitNames[int(own)];
  file.warnings.push_back(unit
                              ? "read in " + name + ": " + in_words(grid, factor)
                              : std::string(kUnitGuessed) + "; it is read in " + name + ": " +
                                    in_words(grid, factor) + ". In mm no angiography is like it (" +
                                    in_words(grid, 1.0) + "). --unit says otherwise");
  grid.spacing *= factor;
  grid.origin *= factor;
}

}  // namespace angio::segmentation::detail
