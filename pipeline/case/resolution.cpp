#include "pipeline/case/resolution.hpp"

#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "segmentation/read_volume.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::pipeline {
using formats::case_file::kGivenLumen;
using formats::case_file::kScan;

std::vector<std::string> resolution_files() { return {kScan, kGivenLumen}; }

centerline::Resolution resolution_of(const Volume<float>& volume) {
  const Vec3& spacing = volume.geometry.spacing;
  return segmentation::is_label_map(volume) ? centerline::resolution_of_labels(spacing)
                                            : centerline::resolution_of_voxels(spacing);
}

centerline::Resolution case_resolution(const StageFiles& files) {
  if (files.exists(kScan)) return resolution_of(segmentation::read_volume_file(files.path(kScan)));
  if (!files.exists(kGivenLumen)) return {};
  return centerline::resolution_of_surface(formats::read_surface(files.path(kGivenLumen)).mesh);
}

}  // namespace angio::pipeline
