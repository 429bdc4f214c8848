#include "centerline/centerline.hpp"

#include <cmath>
#include <string>

#include "centerline/detail/lines.hpp"
#include "centerline/detail/lumen_voxels.hpp"
#include "centerline/detail/skeleton.hpp"
#include "centerline/detail/tracts.hpp"
#include "centerline/detail/wall.hpp"
#include "core/error.hpp"

namespace angio::centerline {

void CenterlineOptions::validate() const {
  if (!(step_mm >= 0.0 && step_mm <= 5.0))
    throw OptionError("centerline.step_mm is " + std::to_string(step_mm) +
                      ". Give 0 (a quarter of the radius) or up to 5 mm");
  if (!(min_branch_length_mm >= 0.0 && std::isfinite(min_branch_length_mm)))
    throw OptionError("centerline.min_branch_length_mm is " + std::to_string(min_branch_length_mm) +
                      ". Give 0 (by the radius) or more");
}

CenterlineResult extract_centerline(const Volume<float>& level_set,
                                    const CenterlineOptions& options, const Progress& progress) {
  options.validate();
  progress.report(0.0, "finding the lumen");
  LumenVoxelsResult lumen = find_lumen_voxels(level_set);
  progress.report(0.2, "finding the ends");
  Skeleton skeleton = find_skeleton(lumen.voxels, options);
  progress.report(0.4, "centring lines");
  CenterlineResult result;
  result.tree =
      trace_lines(lumen.voxels, skeleton, LevelSetWall(level_set), options.step_mm, progress);
  assign_tracts(result.tree);
  result.warnings = std::move(skeleton.warnings);
  if (lumen.piece_count > 1)
    result.warnings.push_back("the lumen has " + std::to_string(lumen.piece_count) +
                              " separate pieces; lines were found in the largest (" +
                              std::to_string(int(std::lround(100.0 * lumen.largest_fraction))) +
                              " % of the voxels)");
  progress.report(1.0);
  return result;
}

}  // namespace angio::centerline
