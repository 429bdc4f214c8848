#include "pipeline/case/resolution.hpp"

#include <memory>
#include <utility>

#include "core/atomic_file.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "pipeline/case/metrics.hpp"
#include "segmentation/read_volume.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::pipeline {
using formats::case_file::kGivenLumen;
using formats::case_file::kNarrowPlaces;
using formats::case_file::kScan;

std::vector<std::string> resolution_files() { return {kScan, kNarrowPlaces, kGivenLumen}; }

centerline::Resolution resolution_of(const Volume<float>& volume) {
  const Vec3& spacing = volume.geometry.spacing;
  return segmentation::is_label_map(volume) ? centerline::resolution_of_labels(spacing)
                                            : centerline::resolution_of_voxels(spacing);
}

void write_narrow_places(const std::filesystem::path& file, const std::vector<Vec3>& places) {
  nlohmann::json list = nlohmann::json::array();
  for (const Vec3& place : places) list.push_back({place.x, place.y, place.z});
  write_text_atomically(file, list.dump(2) + "\n");
}

centerline::Resolution case_resolution(const StageFiles& files) {
  if (files.exists(kScan)) {
    auto scan =
        std::make_shared<const Volume<float>>(segmentation::read_volume_file(files.path(kScan)));
    centerline::Resolution resolution = resolution_of(*scan);
    if (!segmentation::is_label_map(*scan)) resolution.scan = std::move(scan);
    if (!files.exists(kNarrowPlaces)) return resolution;
    for (const nlohmann::json& place : read_json(files.path(kNarrowPlaces)))
      resolution.narrow_lps_mm.push_back(
          {place.at(0).get<double>(), place.at(1).get<double>(), place.at(2).get<double>()});
    return resolution;
  }
  if (!files.exists(kGivenLumen)) return {};
  return centerline::resolution_of_surface(formats::read_surface(files.path(kGivenLumen)).mesh);
}

}  // namespace angio::pipeline
