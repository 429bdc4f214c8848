#include "pipeline/case/resolution.hpp"

#include <memory>

#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::pipeline {
using formats::case_file::kGivenLumen;
using formats::case_file::kScan;

std::vector<std::string> resolution_files() { return {kScan, kGivenLumen}; }

centerline::Resolution case_resolution(const StageFiles& files) {
  if (files.exists(kScan))
    return centerline::resolution_of_voxels(
        segmentation::read_volume_geometry(files.path(kScan)).spacing);
  centerline::Resolution resolution;
  if (files.exists(kGivenLumen))
    resolution.surface =
        std::make_shared<const TriangleMesh>(formats::read_surface(files.path(kGivenLumen)).mesh);
  return resolution;
}

}  // namespace angio::pipeline
