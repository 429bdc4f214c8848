#include "reconstruction/views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/available_memory.hpp"
#include "core/error.hpp"
#include "core/statistics.hpp"
#include "core/units.hpp"
#include "reconstruction/detail/fit_to_ends.hpp"
#include "reconstruction/detail/gating.hpp"
#include "reconstruction/detail/line_integrals.hpp"
#include "reconstruction/detail/read_view.hpp"
#include "reconstruction/detail/tube_volume.hpp"
#include "reconstruction/detail/view_by_view.hpp"
#include "reconstruction/detail/view_picture.hpp"
#include "reconstruction/detail/view_shifts.hpp"
#include "reconstruction/detail/view_tree.hpp"
#include "reconstruction/detail/view_vessel.hpp"

namespace angio::reconstruction {
namespace {

using namespace detail;
using angiogram::kLeastViewAngle;

/// The largest angle between two views' beams, from whichever end [degrees].
double widest_angle(const std::vector<angiogram::ConeBeamFrame>& frames) {
  double widest = 0.0;
  for (const angiogram::ConeBeamFrame& a : frames)
    for (const angiogram::ConeBeamFrame& b : frames)
      widest = std::max(widest, angiogram::angle_between_beams(a.source, b.source));
  return widest;
}

/// Of some views' pixels those of one.
std::vector<char> of_view(const std::vector<std::vector<char>>& pixels, std::size_t view) {
  return view < pixels.size() ? pixels[view] : std::vector<char>();
}

void leave_out_thin_vessels(ViewPicture& view, double thinnest_mm) {
  leave_out_thin(view.lines, 0.5 * thinnest_mm / pixel_at_isocentre(view.frame));
  find_nearest(view);
}

void require_lines(const std::vector<ViewPicture>& views) {
  for (std::size_t v = 0; v < views.size(); ++v)
    if (views[v].lines.empty())
      throw InputError(
          fmt::format("view {} of {} shows no vessel (no frame is filled, or its pixels are "
                      "inverted). Give a view with contrast medium in the vessels",
                      v + 1, views.size()));
}

/// Of catheters, bones and vessels that overlap two views make trees that are not there.
void require_belief(const ViewTree& found, const ViewShifts& shifts) {
  constexpr double kLeastPart = 0.3, kLeastAgreement = 0.6;
  const double part = *std::min_element(found.explained_parts.begin(), found.explained_parts.end());
  if (part >= kLeastPart && shifts.agreement >= kLeastAgreement) return;
  throw InputError(fmt::format(
      "the views do not tell which of their lines belong together: the best tree explains {:.0f} % "
      "of one view's, and the medium across their planes agrees to {:.2f} (catheter, bones, other "
      "vessels, or another phase of the heart). Name the ends of the one vessel that is wanted in "
      "each view, --ends COLUMN,ROW,COLUMN,ROW for each, or the frames with views.frames",
      100.0 * part, shifts.agreement));
}

/// Where a view's lines are explained by less than this, bones and catheter are as likely in the
/// tree as vessels.
constexpr double kPoorPart = 0.6;

std::string doubt_of(const std::vector<double>& explained_parts) {
  const auto least = std::min_element(explained_parts.begin(), explained_parts.end());
  const bool is_checked = explained_parts.size() > 2;  // a third view shows what two have made up
  if (is_checked || *least >= kPoorPart) return {};
  return fmt::format(
      "the vessels of the views are not determined: they explain {:.0f} % of the lines of view {} "
      "(bones, catheter, or vessels that no second view shows), so that lines may be joined that "
      "belong to different things. Name the ends of the one vessel that is wanted in each view "
      "(--ends COLUMN,ROW,COLUMN,ROW for each)",
      100.0 * *least, 1 + (least - explained_parts.begin()));
}

/// Views between whose pictures of one named vessel the medium agrees worse show different things.
constexpr double kPoorAgreement = 0.7;

std::string doubt_of(const ViewShifts& shifts) {
  if (shifts.agreement >= kPoorAgreement) return {};
  return fmt::format(
      "the vessel between the named ends is not determined: across the views' common planes its "
      "medium agrees to {:.2f} only (ends of another vessel, another phase of the heart, or other "
      "fillings). Look at the ends on the frames (the report's sheet)",
      shifts.agreement);
}

double thinnest_radius(const CenterlineTree& tree) {
  double least = 1e9;
  for (const CenterlinePath& path : tree.paths)
    for (const double radius : path.equivalent_radius) least = std::min(least, radius);
  return least;
}

/// Voxels that the thinnest place is two radii wide of, but no finer than 0.1 mm.
double voxel_size(const ViewsOptions& options, const RotationalRun& run,
                  const CenterlineTree& tree) {
  if (options.voxel_mm > 0.0) return options.voxel_mm;
  constexpr double kFinest = 0.1;
  const double pixel = finest_pixel(run.frames);
  return std::clamp(0.5 * thinnest_radius(tree), std::min(kFinest, pixel), pixel);
}

/// Lines and radii: view by view, and where all views see the same places to two pixels from all of
/// them at once.
/// @param has_ends  they were named, and stay
void measure(const RotationalRun& run, const std::vector<ViewPicture>& views,
             const CenterlineTree& found, bool has_ends, const TreeFitOptions& options,
             const Progress& progress, TreeOfViews& result) {
  constexpr double kSkewPixels = 2.0;
  const double air = result.unattenuated;
  result.skew_mm = view_skew(views, found);
  const double pixel = finest_pixel(run.frames);
  result.by_view = result.skew_mm > kSkewPixels * pixel;
  if (!result.by_view) {
    result.fit = has_ends ? fit_tree(run, air, found, options, progress)
                          : fit_to_ends(run, air, found, options, progress);
    return;
  }
  result.fit = measure_view_by_view(run, air, views, found, options, progress);
  if (!has_ends) cut_ends(result.fit);
}

double medium(const TreeFit& fit) {
  std::vector<double> found;
  for (const double contrast : fit.contrast_per_mm)
    if (contrast > 0.0) found.push_back(contrast);
  return median(std::move(found));
}

/// What may be taken [GiB].
struct Room {
  double gib = 0.0;
  bool is_own_limit = false;
};

Room room(double max_memory_gib) {
  const double free = double(available_memory_bytes()) / kBytesPerGibibyte;
  const bool is_own_limit = max_memory_gib > 0.0 && max_memory_gib < free;
  return {is_own_limit ? max_memory_gib : free, is_own_limit};
}

void require_room(const VolumeGeometry& grid, double max_memory_gib) {
  const double needed = double(grid.voxel_count() * sizeof(float)) / kBytesPerGibibyte;
  const auto [most, is_own_limit] = room(max_memory_gib);
  if (needed > most)
    throw InputError(fmt::format(
        "the vessels' volume of {} x {} x {} voxels needs {:.2f} GiB of memory, but {:.2f} GiB are "
        "{}. Take a larger reconstruction.voxel_mm or a smaller reconstruction.largest_side",
        grid.size[0], grid.size[1], grid.size[2], needed, most, is_own_limit ? "allowed" : "free"));
}

std::vector<std::string> warnings_of(const TreeOfViews& result, const ViewShifts& shifts,
                                     bool has_ends) {
  constexpr double kToldShift = 1.0, kToldTurn = 0.3;
  std::vector<std::string> warnings;
  warnings.push_back(fmt::format(
      "the vessels were found from {} views up to {:.0f} degrees apart: sections are taken as "
      "round, and what overlaps in a view may be joined wrongly. Compare the tree with the views "
      "(reconstruction/frames.nrrd, the report's sheet)",
      result.shifts_mm.size(), result.widest_angle_degrees));
  if (has_ends) {
    const Vec3& inlet = result.fit.tree.paths.front().points.front();
    warnings.push_back(fmt::format(
        "the vessel's proximal end lies at {:.1f}, {:.1f}, {:.1f} mm; if another end is taken for "
        "the inlet, run again with --inlet {:.1f},{:.1f},{:.1f}",
        inlet.x, inlet.y, inlet.z, inlet.x, inlet.y, inlet.z));
  }
  double farthest = 0.0;
  for (const Vec3& shift : result.shifts_mm) farthest = std::max(farthest, norm(shift));
  if (farthest > kToldShift)
    warnings.push_back(fmt::format(
        "table or patient moved between the views, by {:.1f} mm as far as they tell it; that was "
        "corrected. How far they moved along the plane of two beams cannot be seen: depths may be "
        "off together",
        farthest));
  double most_turned = 0.0;
  for (const Vec3& turn : result.turns_degrees) most_turned = std::max(most_turned, norm(turn));
  if (most_turned > kToldTurn)
    warnings.push_back(fmt::format(
        "the views' C-arms stood up to {:.1f} degrees from their headers, as far as the tree tells "
        "it; that was corrected",
        most_turned));
  if (shifts.agreement < kPoorAgreement)
    warnings.push_back(fmt::format(
        "the views agree poorly on how the contrast medium lies across their common planes "
        "(correlation {:.2f}): they may show different vessels, phases of the heart, or fillings",
        shifts.agreement));
  constexpr double kToldApart = 3.0;
  if (shifts.ends_apart_mm > kToldApart)
    warnings.push_back(fmt::format(
        "the views disagree about where the vessel's ends lie by {:.1f} mm after the table's shift "
        "(other phases of the heart or of the breath, or the isocentre is not where the header has "
        "it): lengths are off by as much",
        shifts.ends_apart_mm));
  if (result.by_view)
    warnings.push_back(fmt::format(
        "the views see the same places of the vessel {:.1f} mm beside each other (median: "
        "the heart or the patient moved between them, or the isocentre is elsewhere): each view "
        "was "
        "measured by itself, and a narrowing is less sure. Frames of one phase agree better "
        "(views.frames)",
        result.skew_mm));
  for (std::size_t v = 0; v < result.explained_parts.size(); ++v)
    if (result.explained_parts[v] < kPoorPart)
      warnings.push_back(fmt::format(
          "view {}: {:.0f} % of the lines in it are explained by the tree; the others (vessels "
          "that no second view shows, catheter, bone) were left out",
          v + 1, 100.0 * result.explained_parts[v]));
  for (std::size_t v = 0; v < result.hidden_parts.size(); ++v)
    if (result.hidden_parts[v] > kMostHidden)
      warnings.push_back(
          fmt::format("view {}: other vessels lie over {:.0f} % of the one that is wanted; it was "
                      "fitted there as if they were not, and its width is less sure. A view from "
                      "another side would tell more",
                      v + 1, 100.0 * result.hidden_parts[v]));
  if (const std::size_t unknown = radii_without_sd(result.fit); unknown > 0)
    warnings.push_back(fmt::format(
        "the fit gave no standard deviation of the radius at {} places of the lines", unknown));
  if (!result.fit.converged)
    warnings.push_back(
        fmt::format("the fit of the tree has not converged in {} steps", result.fit.steps));
  return warnings;
}

}  // namespace

void ViewsOptions::validate() const {
  if (!(widest_mm >= 1.0 && widest_mm <= 40.0))
    throw OptionError("views.widest_mm: must be in [1, 40]");
  if (!(thinnest_mm >= 0.0 && thinnest_mm <= 5.0 && thinnest_mm < widest_mm))
    throw OptionError("views.thinnest_mm: must be in [0, 5], below views.widest_mm");
  if (!(shift_sd_mm >= 0.0 && shift_sd_mm <= 20.0))
    throw OptionError("views.shift_sd_mm: must be in [0, 20]");
  if (!(turn_sd_degrees >= 0.0 && turn_sd_degrees <= 20.0))
    throw OptionError("views.turn_sd_degrees: must be in [0, 20]");
  if (!(max_memory_gib >= 0.0 && max_memory_gib <= 65536.0))
    throw OptionError("views.max_memory_gib: must be in [0, 65536]; 0 is what the computer has");
}

TreeOfViews reconstruct_views(const RotationalRun& run, const ViewsOptions& options,
                              const Progress& progress) {
  options.validate();
  ANGIO_EXPECT(run.pictures != nullptr);
  TreeOfViews result;
  result.widest_angle_degrees = widest_angle(run.frames);
  if (!options.ends.empty() && options.ends.size() != run.frames.size())
    throw OptionError(
        fmt::format("views.ends: {} vessel ends for {} views. Give column, row of the proximal and "
                    "of the distal "
                    "end for each view",
                    options.ends.size(), run.frames.size()));
  if (run.frames.size() < 2 || result.widest_angle_degrees < kLeastViewAngle)
    throw InputError(
        fmt::format("{} views, {:.0f} degrees apart, tell no depth. Give two or more of the same "
                    "vessel, {:.0f} degrees apart",
                    run.frames.size(), result.widest_angle_degrees, kLeastViewAngle));
  result.unattenuated = run.masks ? 1.0 : unattenuated(run);
  std::vector<ViewPicture> views;
  for (std::size_t v = 0; v < run.frames.size(); ++v) {
    progress.report(0.1 * double(v) / double(run.frames.size()), "finding each view's vessels");
    views.push_back(read_view(run, int(v), result.unattenuated, options.widest_mm,
                              of_view(options.covered, v)));
  }
  require_lines(views);
  TreeFitOptions fitting;
  fitting.left_out.resize(views.size());
  for (std::size_t v = 0; v < options.ends.size(); ++v) {
    const VesselLines all = views[v].lines;
    keep_vessel(views[v], options.ends[v]);
    OtherPixels others = pixels_of_others(all, views[v]);
    result.hidden_parts.push_back(others.hidden_part);
    fitting.left_out[v] = std::move(others.covered);
  }
  for (std::size_t v = 0; v < options.covered.size(); ++v) {
    fitting.left_out[v].resize(std::max(fitting.left_out[v].size(), options.covered[v].size()), 0);
    for (std::size_t i = 0; i < options.covered[v].size(); ++i)
      if (options.covered[v][i] != 0) fitting.left_out[v][i] = 1;
  }
  const ViewShifts shifts = find_view_shifts(views, options.ends);
  RotationalRun moved = run;
  for (std::size_t v = 0; v < views.size(); ++v)
    moved.frames[v] = views[v].frame = shifted(views[v].frame, shifts.shift[v]);
  result.shifts_mm = shifts.shift;
  result.agreement = shifts.agreement;
  for (ViewPicture& view : views)
    if (options.ends.empty() && options.thinnest_mm > 0.0)
      leave_out_thin_vessels(view, options.thinnest_mm);
  constexpr double kMost = 0x1p62;  // free memory that is not known has no limit
  const auto most_bytes =
      std::uint64_t(std::min(kBytesPerGibibyte * room(options.max_memory_gib).gib, kMost));
  ViewTree found;
  if (options.ends.empty()) {
    PosedTree posed_tree = find_posed_tree(views, most_bytes, part(progress, 0.1, 0.5));
    found = std::move(posed_tree.found);
    for (std::size_t v = 0; v < views.size(); ++v) {
      const ViewPose& pose = posed_tree.poses[v];
      moved.frames[v] = views[v].frame = posed(views[v].frame, pose);
      result.shifts_mm[v] = posed(result.shifts_mm[v], pose);
      if (views.size() > 2) result.turns_degrees.push_back(180.0 / units::kPi * pose.turn);
    }
  } else {
    found = find_view_vessel(views, options.ends, most_bytes);
  }
  if (found.tree.paths.empty())
    throw InputError(
        "no vessel is seen in all views (they show different vessels, or are not from where their "
        "headers say). Give views of the same vessel");
  if (options.ends.empty()) require_belief(found, shifts);
  result.explained_parts = found.explained_parts;
  result.doubt = options.ends.empty() ? doubt_of(found.explained_parts) : doubt_of(shifts);
  fitting.frame_shift_sd_mm = options.shift_sd_mm;
  fitting.frame_turn_sd_degrees = options.turn_sd_degrees;
  measure(moved, views, found.tree, !options.ends.empty(), fitting, part(progress, 0.5, 0.9),
          result);
  const double voxel = voxel_size(options, run, result.fit.tree);
  require_room(tube_grid(result.fit.tree, voxel, options.largest_side), options.max_memory_gib);
  result.volume = tube_volume(result.fit.tree, medium(result.fit), voxel, options.largest_side);
  result.warnings = warnings_of(result, shifts, !options.ends.empty());
  return result;
}

FilledFrames find_filled_frame(const RotationalRun& run, const ViewsOptions& options,
                               double phase) {
  constexpr double kFull = 0.9;
  ANGIO_EXPECT(run.pictures != nullptr && !run.frames.empty());
  const double air = run.masks ? 1.0 : unattenuated(run);
  constexpr int kAtFirst = 8;
  FilledFrames filled;
  const int count = int(run.frames.size()), every = std::max(1, count / kAtFirst);
  filled.share.assign(run.frames.size(), 0.0);
  const auto look_at = [&](int f) {
    const ViewPicture view = read_view(run, f, air, options.widest_mm, of_view(options.covered, 0));
    double& sum = filled.share[std::size_t(f)];
    for (std::size_t i = 0; i < view.vessels.size(); ++i)
      if (view.nearest[i] >= 0 &&
          view.distance[i] <= view.lines.radius[std::size_t(view.nearest[i])])
        sum += std::max(0.0, double(view.vessels[i]));
  };
  for (int f = every / 2; f < count; f += every) look_at(f);
  const int near =
      int(std::max_element(filled.share.begin(), filled.share.end()) - filled.share.begin());
  for (int f = std::max(0, near - every + 1); f < std::min(count, near + every); ++f)
    if (f != near) look_at(f);
  const auto most = std::max_element(filled.share.begin(), filled.share.end());
  filled.best = int(most - filled.share.begin());
  const double full = *most;
  for (double& share : filled.share) share = full > 0.0 ? share / full : 0.0;
  if (run.times_s.size() != run.frames.size() || run.r_waves_s.size() < 2) return filled;
  const std::vector<double> phases = cardiac_phases(run.times_s, run.r_waves_s);
  double nearest = 1.0;
  for (std::size_t f = 0; f < phases.size(); ++f) {
    const double off = std::abs(phases[f] - phase), away = std::min(off, 1.0 - off);
    if (filled.share[f] >= kFull && away < nearest) {
      nearest = away;
      filled.best = int(f);
    }
  }
  return filled;
}

}  // namespace angio::reconstruction
