#include "pipeline/stages/report_views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <nlohmann/json.hpp>

#include "angiogram/xray.hpp"
#include "core/error.hpp"
#include "core/statistics.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "formats/nrrd.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/case/metrics.hpp"

namespace angio::pipeline {
namespace file = formats::case_file;
using nlohmann::json;
namespace {

constexpr int kPixels = 480;
constexpr double kLeastHalfSize = 12.0;  // [mm]
constexpr double kRoom = 1.3;            // around what was measured
constexpr double kRadii = 3.0;           // of the widest vessel there, at least

angiogram::XrayFrame frame_of(const viewer::ReportContent& content) {
  const CenterlinePath& line = path_of(content.tree, content.lesion_path);
  double reach = kLeastHalfSize / kRoom;
  const Vec3 lesion = sample(line, content.lesion_abscissa_mm).point;
  for (const double abscissa : content.before.abscissa_mm)
    reach = std::max(reach, distance(sample(line, abscissa).point, lesion));
  const double near = reach;
  for (std::size_t i = 0; i < line.points.size(); ++i)
    if (distance(line.points[i], lesion) <= near)
      reach = std::max(reach, kRadii * line.equivalent_radius[i]);
  return {{}, lesion, kRoom * reach, kPixels};
}

/// The attenuation of contrast medium. Blood dilutes it where a vessel is wide: no more of the beam
/// is taken away than shows the vessel's shape.
double attenuation_for(const std::vector<std::vector<double>>& chords_mm) {
  constexpr double kMostTaken = 2.0;  // in powers of e
  constexpr double kPassed = 0.99;    // of the rays through the vessel
  double widest = 0.0;
  for (const std::vector<double>& chords : chords_mm) {
    std::vector<double> inside;
    std::copy_if(chords.begin(), chords.end(), std::back_inserter(inside),
                 [](double chord) { return chord > 0.0; });
    widest = std::max(widest, quantile(std::move(inside), kPassed, 0.0));
  }
  return widest > 0.0 ? std::min(angiogram::kContrastMedium, kMostTaken / widest)
                      : angiogram::kContrastMedium;
}

viewer::XrayPicture xray_picture(const Volume<float>& stack, int slice, const json& place) {
  const auto& size = stack.geometry.size;
  const auto matrix = place.at("matrix").get<std::array<std::array<double, 4>, 3>>();
  viewer::XrayPicture picture;
  picture.place = angiogram::frame_from_matrix(matrix, {}, size[0], size[1]);
  const Vec3 middle = picture.place.place(0.5 * (size[0] - 1), 0.5 * (size[1] - 1));
  const angiogram::CArmAngles angles = angiogram::c_arm_angles(middle - picture.place.source);
  picture.title =
      fmt::format("Frame {}, {}", place.at("frame").get<int>(), angiogram::c_arm_label(angles));
  const auto begin = stack.values.begin() + std::ptrdiff_t(stack.geometry.offset(0, 0, slice));
  picture.attenuation = {begin, begin + std::ptrdiff_t(stack.geometry.offset(0, 0, 1))};
  return picture;
}

}  // namespace

std::vector<viewer::XrayPicture> xray_frames(const StageFiles& files) {
  if (!files.exists(file::kShownFrames)) return {};
  const Volume<float> stack = formats::read_nrrd(files.path(file::kShownFrames));
  const json places = read_json(files.path(file::kShownPlaces));
  try {
    const json& frames = places.at("frames");
    if (int(frames.size()) != stack.geometry.size[2])
      throw InputError("frames.json and frames.nrrd differ in their number of frames");
    std::vector<viewer::XrayPicture> pictures;
    for (int n = 0; n < stack.geometry.size[2]; ++n) {
      pictures.push_back(xray_picture(stack, n, frames.at(std::size_t(n))));
      pictures.back().is_subtracted = places.at("subtracted").get<bool>();
    }
    return pictures;
  } catch (const json::exception&) {
    throw InputError(
        "reconstruction/frames.json lacks something (a file was changed or is damaged). Run "
        "`angio run INPUT -o CASE --from reconstruction`");
  }
}

viewer::CArmViews carm_views(const StageFiles& files, const CaseWorkingView& view,
                             const viewer::ReportContent& content) {
  viewer::CArmViews views{view.view, {}};
  if (!view.view) return views;
  const TriangleMesh before = angiogram::with_caps(content.lumen);
  std::optional<TriangleMesh> after;
  if (!content.moments.empty())
    after = angiogram::with_caps(formats::read_surface(files.path(file::kLumenAfter)).mesh);
  angiogram::XrayFrame frame = frame_of(content);
  std::vector<std::vector<double>> chords;
  const auto take = [&](const TriangleMesh& closed, const std::string& when) {
    chords.push_back(angiogram::chord_lengths(closed, frame));
    views.angiograms.push_back(
        {when + ", " + angiogram::c_arm_label(frame.angles), frame.pixel_mm(), frame.pixels, {}});
  };
  const auto add = [&](const angiogram::SeenSegment& seen) {
    frame.angles = seen.angles;
    take(before, "Before");
    if (after) take(*after, "After");
  };
  add(view.view->best);
  if (view.view->has_second) add(view.view->second);
  const double attenuation = attenuation_for(chords);
  for (std::size_t i = 0; i < chords.size(); ++i)
    views.angiograms[i].transmission = angiogram::transmissions(std::move(chords[i]), attenuation);
  return views;
}

}  // namespace angio::pipeline
