#include "pipeline/case/resolution.hpp"

#include <memory>

#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "segmentation/read_volume.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::pipeline {
using formats::case_file::kGivenLumen;
using formats::case_file::kScan;

std::vector<std::string> resolution_files() { return {kScan, kGivenLumen}; }

centerline::Resolution resolution_of(const Volume<float>& volume) {
  // Between inside and outside a scan has shades of grey, a label map nothing: it shows half as
  // much.
  constexpr double kLabelVoxels = 2.0;
  const double voxels = segmentation::is_label_map(volume) ? kLabelVoxels : 1.0;
  return centerline::resolution_of_voxels(voxels * volume.geometry.spacing);
}

centerline::Resolution case_resolution(const StageFiles& files) {
  if (files.exists(kScan)) return resolution_of(segmentation::read_volume_file(files.path(kScan)));
  centerline::Resolution resolution;
  if (files.exists(kGivenLumen))
    resolution.surface =
        std::make_shared<const TriangleMesh>(formats::read_surface(files.path(kGivenLumen)).mesh);
  return resolution;
}

}  // namespace angio::pipeline
