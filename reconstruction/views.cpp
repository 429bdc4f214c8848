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
#include "reconstruction/detail/gating.hpp"
#include "reconstruction/detail/line_integrals.hpp"
#include "reconstruction/detail/tube_volume.hpp"
#include "reconstruction/detail/vessel_pictures.hpp"
#include "reconstruction/detail/view_by_view.hpp"
#include "reconstruction/detail/view_picture.hpp"
#include "reconstruction/detail/view_shifts.hpp"
#include "reconstruction/detail/view_tree.hpp"
#include "reconstruction/detail/view_vessel.hpp"

namespace angio::reconstruction {
namespace {

using namespace detail;
using angiogram::kLeastViewAngle;

double pixel_at_isocentre(const angiogram::ConeBeamFrame& frame) {
  return norm(frame.column_step) * angiogram::ConeBeamView(frame).see(Vec3{0.0, 0.0, 0.0}).depth;
}

/// The largest angle between two views' beams, from whichever end [degrees].
double widest_angle(const std::vector<angiogram::ConeBeamFrame>& frames) {
  double widest = 0.0;
  for (const angiogram::ConeBeamFrame& a : frames)
    for (const angiogram::ConeBeamFrame& b : frames)
      widest = std::max(widest, angiogram::angle_between_beams(a.source, b.source));
  return widest;
}

/// How many of the first (or last) rows or columns a collimator covers: their median is far from
/// the picture's.
int covered(const std::vector<double>& medians, double middle, bool from_end) {
  constexpr double kFar = 0.8;  // of a line integral: less than half of the beam, or twice as much
  const int count = int(medians.size());
  int border = 0;
  for (int n = 0; n < count / 3; ++n)
    if (std::abs(medians[std::size_t(from_end ? count - 1 - n : n)] - middle) > kFar)
      border = n + 1;
  return border;
}

/// The part of a picture that no collimator covers, less its blurred edge.
OpenField open_field(const std::vector<float>& picture, int columns, int rows) {
  std::vector<double> all(picture.begin(), picture.end()), of_columns, of_rows;
  const double middle = median(std::move(all));
  const auto at = [&](int c, int r) {
    return double(picture[std::size_t(r) * std::size_t(columns) + std::size_t(c)]);
  };
  for (int c = 0; c < columns; ++c) {
    std::vector<double> values;
    for (int r = rows / 5; r < rows - rows / 5; ++r) values.push_back(at(c, r));
    of_columns.push_back(median(std::move(values)));
  }
  for (int r = 0; r < rows; ++r) {
    std::vector<double> values;
    for (int c = columns / 5; c < columns - columns / 5; ++c) values.push_back(at(c, r));
    of_rows.push_back(median(std::move(values)));
  }
  constexpr double kEdge = 0.03;
  const auto inside = [&](const std::vector<double>& medians, bool from_end) {
    const int border = covered(medians, middle, from_end);
    return border + int(kEdge * double(medians.size()));
  };
  return {inside(of_columns, false), columns - 1 - inside(of_columns, true), inside(of_rows, false),
          rows - 1 - inside(of_rows, true)};
}

ViewPicture read_view(const RotationalRun& run, int index, double air, double widest_mm,
                      std::vector<char> covered) {
  const angiogram::ConeBeamFrame& frame = run.frames[std::size_t(index)];
  std::vector<float> integrals = read_line_integrals(run, index, 1, air);
  OpenField open = open_field(integrals, frame.columns, frame.rows);
  const OpenField given = around_open(covered, frame.columns, frame.rows);
  open = {std::max(open.first_column, given.first_column),
          std::min(open.last_column, given.last_column), std::max(open.first_row, given.first_row),
          std::min(open.last_row, given.last_row)};
  if (open.first_column > open.last_column || open.first_row > open.last_row)
    throw InputError(fmt::format("view {}: its shutter covers all of it. Give another", index + 1));
  cover_shutter(integrals.data(), frame.columns, frame.rows, open);
  VesselPicture picture = vessels_of(std::move(integrals), frame.columns, frame.rows,
                                     widest_mm / pixel_at_isocentre(frame), run.masks != nullptr);
  covered.resize(picture.line_integrals.size(), 0);
  for (int row = 0; row < frame.rows; ++row)
    for (int c = 0; c < frame.columns; ++c)
      if (c < open.first_column || c > open.last_column || row < open.first_row ||
          row > open.last_row)
        covered[std::size_t(row) * std::size_t(frame.columns) + std::size_t(c)] = 1;
  return make_view_picture(frame, std::move(picture.line_integrals), covered, widest_mm);
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
  double pixel = 1e9;
  for (const angiogram::ConeBeamFrame& frame : run.frames)
    pixel = std::min(pixel, pixel_at_isocentre(frame));
  return std::clamp(0.5 * thinnest_radius(tree), std::min(kFinest, pixel), pixel);
}

/// How many points at a line's end lie beyond the vessel's: lines reach out of a vessel's end by
/// their blur, and the tube fitted there has no radius to speak of.
std::size_t beyond_end(const CenterlinePath& path, bool at_inlet) {
  constexpr double kNear = 10.0;                // [mm]
  constexpr double kPart = 0.75, kReach = 4.0;  // of the vessel's radius there
  const std::size_t count = path.points.size();
  const auto point = [&](std::size_t n) { return at_inlet ? n : count - 1 - n; };
  const auto along = [&](std::size_t n) {
    return std::abs(path.abscissa[point(n)] - path.abscissa[point(0)]);
  };
  std::vector<double> radii;
  for (std::size_t n = 0; n < count && along(n) < kNear; ++n)
    radii.push_back(path.equivalent_radius[point(n)]);
  const double vessel = quantile(radii, 0.75);
  std::size_t beyond = 0;
  while (beyond < radii.size() && along(beyond) < std::min(kReach * vessel, 0.5 * kNear) &&
         radii[beyond] < kPart * vessel)
    ++beyond;
  // A path that would be gone keeps its ends.
  constexpr std::size_t kFewest = 8;
  return 2 * beyond + kFewest > count ? 0 : beyond;
}

/// A tree without what lies beyond its vessels' ends, and whether that was anything.
struct CutTree {
  CenterlineTree tree;
  bool is_shorter = false;
};

CutTree without_ends(const CenterlineTree& tree) {
  CutTree result;
  CenterlineTree& cut = result.tree;
  for (const CenterlinePath& path : tree.paths) {
    const std::size_t first = beyond_end(path, true),
                      last = path.points.size() - beyond_end(path, false);
    result.is_shorter = result.is_shorter || last - first < path.points.size();
    CenterlinePath& kept = cut.paths.emplace_back();
    kept.id = path.id;
    kept.points.assign(path.points.begin() + std::ptrdiff_t(first),
                       path.points.begin() + std::ptrdiff_t(last));
    kept.inscribed_radius.assign(path.inscribed_radius.begin() + std::ptrdiff_t(first),
                                 path.inscribed_radius.begin() + std::ptrdiff_t(last));
    kept.abscissa = arc_length(kept.points);
    kept.tracts = {{0, int(kept.points.size()) - 1, path.id, 0, false}};
  }
  return result;
}

double usual_radius(const CenterlineTree& tree) {
  std::vector<double> radii;
  for (const CenterlinePath& path : tree.paths)
    radii.insert(radii.end(), path.inscribed_radius.begin(), path.inscribed_radius.end());
  return median(std::move(radii));
}

/// The same of a fit, which stays as it is between its ends.
void cut_ends(TreeFit& fit) {
  for (std::size_t p = 0; p < fit.tree.paths.size(); ++p) {
    CenterlinePath& path = fit.tree.paths[p];
    const auto first = std::ptrdiff_t(beyond_end(path, true)),
               last = std::ptrdiff_t(path.points.size() - beyond_end(path, false));
    const auto cut = [&](auto& values) {
      values = std::decay_t<decltype(values)>(values.begin() + first, values.begin() + last);
    };
    cut(path.points);
    cut(path.inscribed_radius);
    cut(path.tube_radius);
    cut(path.equivalent_radius);
    cut(path.section_area);
    cut(fit.radius_sd[p]);
    path.abscissa = arc_length(path.points);
    path.tracts = {{0, int(path.points.size()) - 1, path.id, 0, false}};
  }
}

constexpr double kCoarseNodes = 1.25;  ///< median radii between them

/// Fits a tree, cut where its vessels end: with coarse nodes until nothing more is cut, then as
/// fine as is due.
TreeFit fit_to_ends(RotationalRun run, double air, CenterlineTree tree,
                    const TreeFitOptions& options, const Progress& progress) {
  constexpr int kMostCuts = 5;
  TreeFitOptions coarse = options;
  coarse.node_spacing_mm = std::clamp(kCoarseNodes * usual_radius(tree), 2.0, 10.0);
  coarse.most_steps = 12;
  for (int cut = 0; cut < kMostCuts; ++cut) {
    const TreeFit fit =
        fit_tree(run, air, tree, coarse, part(progress, 0.1 * cut, 0.1 * (cut + 1)));
    run.frames = fit.frames;  // the tree lies where they see it
    CutTree shorter = without_ends(fit.tree);
    tree = std::move(shorter.tree);
    if (!shorter.is_shorter) break;
  }
  TreeFit fit = fit_tree(run, air, tree, options, part(progress, 0.5, 0.75));
  run.frames = fit.frames;
  if (CutTree shorter = without_ends(fit.tree); shorter.is_shorter)
    fit = fit_tree(run, air, shorter.tree, options, part(progress, 0.75, 1.0));
  cut_ends(fit);
  return fit;
}

/// Lines and radii: view by view, and where all views see the same places to a pixel from all of
/// them at once.
/// @param has_ends  they were named, and stay
void measure(const RotationalRun& run, const std::vector<ViewPicture>& views,
             const CenterlineTree& found, bool has_ends, const TreeFitOptions& options,
             const Progress& progress, TreeOfViews& result) {
  constexpr double kSkewPixels = 2.0;
  const double air = result.unattenuated;
  result.skew_mm = view_skew(views, found);
  double pixel = 1e9;
  for (const angiogram::ConeBeamFrame& frame : run.frames)
    pixel = std::min(pixel, pixel_at_isocentre(frame));
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

constexpr double kGibibyte = 1024.0 * 1024.0 * 1024.0;

/// What may be taken [GiB].
struct Room {
  double gib = 0.0;
  bool is_own_limit = false;
};

Room room(double max_memory_gib) {
  const double free = double(available_memory_bytes()) / kGibibyte;
  const bool is_own_limit = max_memory_gib > 0.0 && max_memory_gib < free;
  return {is_own_limit ? max_memory_gib : free, is_own_limit};
}

void require_room(const VolumeGeometry& grid, double max_memory_gib) {
  const double needed = double(grid.voxel_count() * sizeof(float)) / kGibibyte;
  const auto [most, is_own_limit] = room(max_memory_gib);
  if (needed > most)
    throw InputError(fmt::format(
        "the vessels' volume of {} x {} x {} voxels needs {:.2f} GiB of memory, but {:.2f} GiB are "
        "{}. Take a larger reconstruction.voxel_mm or a smaller reconstruction.largest_side",
        grid.size[0], grid.size[1], grid.size[2], needed, most, is_own_limit ? "allowed" : "free"));
}

std::vector<std::string> warnings_of(const TreeOfViews& result, const ViewShifts& shifts,
                                     bool has_ends) {
  constexpr double kToldShift = 1.0, kPoorAgreement = 0.7, kPoorPart = 0.6;
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

OpenField around_open(const std::vector<char>& covered, int columns, int rows) {
  if (covered.empty()) return {0, columns - 1, 0, rows - 1};
  OpenField open{columns, -1, rows, -1};
  for (int row = 0; row < rows; ++row)
    for (int c = 0; c < columns; ++c) {
      if (covered[std::size_t(row) * std::size_t(columns) + std::size_t(c)] != 0) continue;
      open = {std::min(open.first_column, c), std::max(open.last_column, c),
              std::min(open.first_row, row), std::max(open.last_row, row)};
    }
  return open;
}

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
      std::uint64_t(std::min(kGibibyte * room(options.max_memory_gib).gib, kMost));
  const ViewTree found = options.ends.empty()
                             ? find_view_tree(views, most_bytes, part(progress, 0.1, 0.5))
                             : find_view_vessel(views, options.ends, most_bytes);
  if (found.tree.paths.empty())
    throw InputError(
        "no vessel is seen in all views (they show different vessels, or are not from where their "
        "headers say). Give views of the same vessel");
  if (options.ends.empty()) require_belief(found, shifts);
  result.explained_parts = found.explained_parts;
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
