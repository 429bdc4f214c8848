#include "pipeline/stages/report_views.hpp"

#include <algorithm>

#include "angiogram/xray.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "pipeline/case/case_files.hpp"

namespace angio::pipeline {
namespace file = formats::case_file;
namespace {

constexpr int kPixels = 480;
constexpr double kLeastHalfSize = 12.0;  // [mm]
constexpr double kRoom = 1.3;            // around what was measured

angiogram::XrayFrame frame_of(const viewer::ReportContent& content) {
  const CenterlinePath& line = path_of(content.tree, content.lesion_path);
  double reach = kLeastHalfSize / kRoom;
  const Vec3 lesion = sample(line, content.lesion_abscissa_mm).point;
  for (const double abscissa : content.before.abscissa_mm)
    reach = std::max(reach, distance(sample(line, abscissa).point, lesion));
  return {{}, lesion, kRoom * reach, kPixels};
}

viewer::Angiogram take(const TriangleMesh& closed, const angiogram::XrayFrame& frame,
                       const std::string& when) {
  return {when + ", " + angiogram::c_arm_label(frame.angles), frame.pixel_mm(), frame.pixels,
          angiogram::transmissions(angiogram::chord_lengths(closed, frame),
                                   angiogram::kContrastMedium)};
}

}  // namespace

viewer::CArmViews carm_views(const StageFiles& files, const CaseWorkingView& view,
                             const viewer::ReportContent& content) {
  viewer::CArmViews views{view.view, {}};
  if (!view.view) return views;
  const TriangleMesh before = angiogram::with_caps(content.lumen);
  std::optional<TriangleMesh> after;
  if (!content.moments.empty())
    after = angiogram::with_caps(formats::read_surface(files.path(file::kLumenAfter)).mesh);
  angiogram::XrayFrame frame = frame_of(content);
  const auto add = [&](const angiogram::SeenSegment& seen) {
    frame.angles = seen.angles;
    views.angiograms.push_back(take(before, frame, "Before"));
    if (after) views.angiograms.push_back(take(*after, frame, "After"));
  };
  add(view.view->best);
  if (view.view->has_second) add(view.view->second);
  return views;
}

}  // namespace angio::pipeline
