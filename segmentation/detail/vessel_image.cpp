#include "segmentation/detail/vessel_image.hpp"

#include <iterator>
#include <utility>

#include "segmentation/detail/bones.hpp"
#include "segmentation/detail/bright_objects.hpp"
#include "segmentation/detail/tube_axes.hpp"
#include "segmentation/detail/vessel_tree.hpp"

namespace angio::segmentation::detail {

VesselImage find_vessel_image(const Volume<float>& scanned, std::vector<TubeAxis> axes,
                              const SegmentationOptions& options, const Progress& progress) {
  VesselImage image;
  const auto present = [&]() -> const Volume<float>& {
    return image.without.values.empty() ? scanned : image.without;
  };
  const bool exclude = options.exclude_bone && !options.intensity_max;
  if (exclude) {
    progress.report(0.3, "telling blood from bone");
    Bones bones = find_bones(scanned, axes, options);
    axes = std::move(bones.tubes);
    if (bones.are_there) {
      axes = parts_of(axes, [&](const TubeAxis& axis, std::size_t n) {
        return bones.mask.values[axis.voxels[n]] == 0;
      });
      image.level = bones.level;
      image.trunks = std::move(bones.trunks);
      image.without = std::move(bones.image_without);
      image.warnings.push_back(std::move(bones.warning));
    }
    progress.report(0.9, "telling blood from bone");
    BrightObjects bright = find_bright_objects(present(), axes, image.level, options);
    if (!bright.image_without.values.empty()) image.without = std::move(bright.image_without);
    std::move(bright.warnings.begin(), bright.warnings.end(), std::back_inserter(image.warnings));
  }
  if (!image.level.is_told)
    image.level = find_blood_level(axes, present(), noise_deviation(present()));
  return image;
}

}  // namespace angio::segmentation::detail
