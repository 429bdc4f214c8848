#include "pipeline/case/slicer_folder.hpp"

#include <cstdint>
#include <utility>

#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "formats/nrrd.hpp"
#include "pipeline/case/mask_on_grid.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

constexpr const char* kMask = "segmentation/lumen_mask.nrrd";

void require_file(const fs::path& file, const char* why) {
  std::error_code ignored;
  if (!fs::exists(file, ignored))
    throw InputError("there is no " + file.string() + " (" + why, ExitCode::no_input);
}

}  // namespace

std::vector<fs::path> write_slicer_folder(const fs::path& case_folder, const fs::path& folder) {
  const fs::path mask_file = case_folder / kMask,
                 lines_file = case_folder / formats::case_file::kCenterlines;
  require_file(mask_file,
               "a case that begins with a surface has no mask, nor one that was not segmented). "
               "Open its .vtp files instead, or run `angio segment CASE`");
  require_file(lines_file, "its lines are not found yet). Run `angio centerline CASE`");
  const Volume<std::uint8_t> mask =
      mask_on_grid(formats::read_nrrd(mask_file),
                   formats::read_nrrd(case_folder / formats::case_file::kScan).geometry);
  formats::PolylineData lines = formats::read_polylines(lines_file);
  DataArray radius = formats::find_array(lines.point_arrays, "MaximumInscribedSphereRadius");
  radius.name = "Radius";
  lines.point_arrays.push_back(std::move(radius));
  std::vector<fs::path> files{folder / "lumen.seg.nrrd", folder / "centerlines.vtp"};
  formats::write_segmentation(files[0], mask, {"lumen", {0.77, 0.31, 0.27}});
  formats::write_polylines(files[1], lines);
  return files;
}

}  // namespace angio::pipeline
