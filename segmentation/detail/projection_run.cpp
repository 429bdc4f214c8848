#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "segmentation/detail/dicom_parse.hpp"
#include "segmentation/detail/format_number.hpp"
#include "segmentation/detail/open_shapes.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kSameViewSpacing = 1e-3;    ///< relative
constexpr double kSameMagnification = 0.01;  ///< relative

/// A value anywhere in an object, also in its functional groups.
std::optional<double> deep_number(DcmItem& item, const DcmTagKey& tag, unsigned long place = 0) {
  return number(item, tag, place, true);
}

/// A text anywhere in an object.
std::string deep_text(DcmItem& item, const DcmTagKey& tag) {
  OFString value;
  return item.findAndGetOFString(tag, value, 0, OFTrue).good() ? value.c_str() : "";
}

/// base + increment per frame; one angle if the object has no increments.
std::vector<double> angles_by_increments(DcmDataset& dataset, const DcmTagKey& base_tag,
                                         const DcmTagKey& increment_tag, ProjectionRun& run,
                                         std::size_t which) {
  const auto stated = number(dataset, base_tag);
  std::vector<double> angles = decimal_numbers(dataset, increment_tag);
  if (!stated && angles.empty()) return {};
  double& base = run.base_angles_degrees[which];
  base = stated.value_or(0.0);
  if (which == 0) run.has_base_angle = stated.has_value();
  if (!stated)
    run.notes.push_back(
        std::string(which == 0 ? "primary" : "secondary") +
        " angles: the one that the increments count from is not stated; it is taken to be 0");
  if (angles.empty()) return {base};
  for (double& angle : angles) angle += base;
  return angles;
}

/// Of an enhanced object, frame by frame; the angle against the table where the one against the
/// patient is not said.
std::vector<double> angles_by_frames(DcmDataset& dataset, const DcmTagKey& tag,
                                     const DcmTagKey& isocentre_tag) {
  std::vector<double> angles;
  DcmItem* shared = first_item(dataset, DCM_SharedFunctionalGroupsSequence);
  DcmSequenceOfItems* per_frame = nullptr;
  dataset.findAndGetSequence(DCM_PerFrameFunctionalGroupsSequence, per_frame);
  DcmObject* object = nullptr;
  while (per_frame && (object = per_frame->nextInContainer(object)) != nullptr) {
    auto* groups = dynamic_cast<DcmItem*>(object);
    std::optional<double> angle;
    for (DcmItem* item : {groups, shared})
      for (const DcmTagKey& which : {tag, isocentre_tag})
        if (!angle && item) angle = deep_number(*item, which);
    if (!angle) return {};
    angles.push_back(*angle);
  }
  if (!angles.empty() && std::all_of(angles.begin(), angles.end(),
                                     [&](double angle) { return angle == angles.front(); }))
    angles.erase(angles.begin() + 1, angles.end());
  return angles;
}

void parse_angles(DcmDataset& dataset, ProjectionRun& run) {
  run.primary_angles_degrees =
      angles_by_frames(dataset, DCM_PositionerPrimaryAngle, DCM_PositionerIsocenterPrimaryAngle);
  run.secondary_angles_degrees = angles_by_frames(dataset, DCM_PositionerSecondaryAngle,
                                                  DCM_PositionerIsocenterSecondaryAngle);
  if (run.primary_angles_degrees.empty())
    run.primary_angles_degrees = angles_by_increments(dataset, DCM_PositionerPrimaryAngle,
                                                      DCM_PositionerPrimaryAngleIncrement, run, 0);
  if (run.secondary_angles_degrees.empty())
    run.secondary_angles_degrees = angles_by_increments(
        dataset, DCM_PositionerSecondaryAngle, DCM_PositionerSecondaryAngleIncrement, run, 1);
}

/// Siemens counts DistanceSourceToPatient to the table's patient position; its own element has the
/// isocentre's distance.
std::optional<double> siemens_isocentre_distance(DcmDataset& dataset) {
  constexpr double kNearest = 300.0, kFarthest = 2000.0;  // [mm]
  constexpr Uint16 kGroup = 0x0021, kElement = 0x17;
  for (Uint16 block = 0x10; block <= 0xFF; ++block) {
    if (!text(dataset, DcmTagKey(kGroup, block)).starts_with("SIEMENS")) continue;
    const auto found = number(dataset, DcmTagKey(kGroup, Uint16(block << 8U | kElement)));
    if (found && *found >= kNearest && *found <= kFarthest) return found;
  }
  return {};
}

void parse_distances(DcmDataset& dataset, ProjectionRun& run) {
  const auto positive = [&](const DcmTagKey& tag) {
    const auto value = deep_number(dataset, tag);
    return value && *value > 0.0 ? value : std::nullopt;
  };
  run.source_to_detector_mm = positive(DCM_DistanceSourceToDetector);
  run.source_to_isocentre_mm = positive(DCM_DistanceSourceToIsocenter);
  if (!run.source_to_isocentre_mm) run.source_to_isocentre_mm = siemens_isocentre_distance(dataset);
  if (!run.source_to_isocentre_mm)
    run.source_to_isocentre_mm = positive(DCM_DistanceSourceToPatient);
  run.magnification = positive(DCM_EstimatedRadiographicMagnificationFactor);
  if (!run.source_to_detector_mm || !run.source_to_isocentre_mm) return;
  const double by_distances = *run.source_to_detector_mm / *run.source_to_isocentre_mm;
  if (run.magnification &&
      std::abs(*run.magnification - by_distances) > kSameMagnification * by_distances)
    run.notes.push_back("the stated magnification of " + format_number(*run.magnification) +
                        " is not that of the distances, " + format_number(by_distances) +
                        "; the distances were taken");
  run.magnification = by_distances;
}

/// Between columns and rows, which DICOM gives the other way round.
std::array<double, 2> spacing_by(DcmDataset& dataset, const DcmTagKey& tag) {
  const double rows = deep_number(dataset, tag, 0).value_or(0.0);
  const double columns = deep_number(dataset, tag, 1).value_or(rows);
  return rows > 0.0 && columns > 0.0 ? std::array{columns, rows} : std::array{0.0, 0.0};
}

/// Of the detector's pixels: as it is stated, or else the field of view over the picture (DICOM
/// PS3.3 C.8.7.5: of a rectangle its rows, then its columns; of a round one its diameter).
std::array<double, 2> detector_spacing(DcmDataset& dataset) {
  const auto stated = spacing_by(dataset, DCM_ImagerPixelSpacing);
  if (stated[0] > 0.0) return stated;
  const int columns = integer(dataset, DCM_Columns), rows = integer(dataset, DCM_Rows);
  const auto field = spacing_by(dataset, DCM_FieldOfViewDimensions);  // [mm], columns first here
  if (!(field[0] > 0.0) || columns < 1 || rows < 1) return {0.0, 0.0};
  return {field[0] / columns, field[1] / rows};
}

/// DICOM PS3.3 C.8.7.5 and 10.7.1.3: a calibrated spacing is finer than the detector's; one that is
/// not was copied from it.
void parse_spacing(DcmDataset& dataset, ProjectionRun& run) {
  const auto in_beam = spacing_by(dataset, DCM_ObjectPixelSpacingInCenterOfBeam);
  const auto detector = spacing_by(dataset, DCM_ImagerPixelSpacing);
  const auto stated = spacing_by(dataset, DCM_PixelSpacing);
  const auto set = [&](const std::array<double, 2>& spacing, SpacingPlane plane,
                       const std::string& note) {
    run.spacing_mm = spacing;
    run.spacing_plane = plane;
    run.notes.push_back(note);
  };
  if (in_beam[0] > 0.0)
    return set(in_beam, SpacingPlane::calibrated,
               "spacing: of the object in the centre of the beam, as the file says");
  if (detector[0] <= 0.0 && stated[0] <= 0.0)
    return set({0.0, 0.0}, SpacingPlane::unknown, "spacing: none is stated");
  if (detector[0] <= 0.0)
    return set(stated, SpacingPlane::unknown,
               "spacing: stated without the detector's, so that its plane is not known");
  if (stated[0] > 0.0 && stated[0] < detector[0] * (1.0 - kSameViewSpacing))
    return set(stated, SpacingPlane::calibrated,
               "spacing: calibrated on an object in the picture (PixelSpacing is finer than the "
               "detector's " +
                   format_number(detector[0]) + " mm)");
  if (!run.magnification)
    return set(detector, SpacingPlane::detector,
               "spacing: of the detector; the patient is smaller by a magnification that the file "
               "does not state");
  set({detector[0] / *run.magnification, detector[1] / *run.magnification}, SpacingPlane::isocentre,
      "spacing: the detector's " + format_number(detector[0]) +
          " mm divided by the magnification " + format_number(*run.magnification) +
          " at the isocentre");
}

/// A word of DICOM's own (PS3.5 6.2, CS); what is none could be anybody's text.
std::string keyword(const std::string& text) {
  constexpr const char* kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_ ";
  const bool is_one = text.size() <= 16 && text.find_first_not_of(kLetters) == std::string::npos;
  return is_one ? text : "(not readable)";
}

void parse_mask(DcmDataset& dataset, int frame_count, ProjectionRun& run) {
  DcmItem* mask = first_item(dataset, DCM_MaskSubtractionSequence);
  if (!mask) return;
  run.mask_operation = keyword(text(*mask, DCM_MaskOperation));
  Uint16 frame = 0;
  for (unsigned long place = 0; mask->findAndGetUint16(DCM_MaskFrameNumbers, frame, place).good();
       ++place)
    if (frame >= 1 && int(frame) <= frame_count) run.mask_frames.push_back(int(frame));
}

/// What round and polygonal shutters and collimators leave open (DICOM PS3.3 C.7.6.11, C.8.7.3,
/// which give rows before columns).
void parse_shapes(DcmDataset& dataset, ProjectionRun& run) {
  constexpr unsigned long kMostNumbers = 2000;
  constexpr double kFarthest = 65536.0;
  const auto numbers = [&](const DcmTagKey& tag) {
    std::vector<double> found;
    while (const auto value = deep_number(dataset, tag, found.size())) {
      if (found.size() == kMostNumbers || !(std::abs(*value) < kFarthest))
        return std::vector<double>();  // a part of it would be another shape
      found.push_back(*value);
    }
    return found;
  };
  for (const auto& [middle_tag, radius_tag] :
       {std::pair{DCM_CenterOfCircularShutter, DCM_RadiusOfCircularShutter},
        std::pair{DCM_CenterOfCircularCollimator, DCM_RadiusOfCircularCollimator}}) {
    const std::vector<double> middle = numbers(middle_tag), radius = numbers(radius_tag);
    if (middle.size() == 2 && radius.size() == 1 && radius[0] > 0.0)
      run.open_shapes.push_back(circle_corners(middle[1], middle[0], radius[0]));
  }
  for (const DcmTagKey& tag :
       {DCM_VerticesOfThePolygonalShutter, DCM_VerticesOfThePolygonalCollimator}) {
    std::vector<double> corners = numbers(tag);
    if (corners.size() < 6 || corners.size() % 2 != 0) continue;
    for (std::size_t n = 0; n < corners.size(); n += 2) std::swap(corners[n], corners[n + 1]);
    run.open_shapes.push_back(std::move(corners));
  }
}

/// The part of the picture inside both the shutter and the collimator, of round and polygonal ones
/// the rectangle around.
void parse_field(DcmDataset& dataset, ProjectionRun& run) {
  std::array<int, 4> open = {1, integer(dataset, DCM_Columns), 1, integer(dataset, DCM_Rows)};
  bool any = false;
  const auto close_in = [&](const DcmTagKey& tag, std::size_t side, bool is_least) {
    const auto edge = deep_number(dataset, tag);
    if (!edge || !(std::abs(*edge) < 65536.0)) return;
    any = true;
    open[side] = is_least ? std::max(open[side], int(*edge)) : std::min(open[side], int(*edge));
  };
  for (const DcmTagKey& tag : {DCM_ShutterLeftVerticalEdge, DCM_CollimatorLeftVerticalEdge})
    close_in(tag, 0, true);
  for (const DcmTagKey& tag : {DCM_ShutterRightVerticalEdge, DCM_CollimatorRightVerticalEdge})
    close_in(tag, 1, false);
  for (const DcmTagKey& tag : {DCM_ShutterUpperHorizontalEdge, DCM_CollimatorUpperHorizontalEdge})
    close_in(tag, 2, true);
  for (const DcmTagKey& tag : {DCM_ShutterLowerHorizontalEdge, DCM_CollimatorLowerHorizontalEdge})
    close_in(tag, 3, false);
  const auto is_open = [](const std::array<int, 4>& sides) {
    return sides[0] <= sides[1] && sides[2] <= sides[3];
  };
  for (const std::vector<double>& corners : run.open_shapes) {
    std::array<double, 4> around{corners[0], corners[0], corners[1], corners[1]};
    for (std::size_t n = 0; n < corners.size(); ++n) {
      const std::size_t side = n % 2 == 0 ? 0 : 2;
      around[side] = std::min(around[side], corners[n]);
      around[side + 1] = std::max(around[side + 1], corners[n]);
    }
    std::array<int, 4> inside = open;
    for (const std::size_t side : {0, 2}) {
      inside[side] = std::max(open[side], int(std::ceil(around[side])));
      inside[side + 1] = std::min(open[side + 1], int(std::floor(around[side + 1])));
    }
    if (!is_open(inside)) continue;  // as open_pixels leaves a shape out that covers everything
    any = true;
    open = inside;
  }
  if (any && is_open(open)) run.open_field = open;
}

/// How far the table goes, by its increments from the first frame.
void parse_table(DcmDataset& dataset, ProjectionRun& run) {
  for (const DcmTagKey& tag :
       {DCM_TableVerticalIncrement, DCM_TableLateralIncrement, DCM_TableLongitudinalIncrement})
    for (const double travel : decimal_numbers(dataset, tag))
      run.table_travel_mm = std::max(run.table_travel_mm, std::abs(travel));
}

/// Where the picture lies on the detector (DICOM PS3.3, C.8.7.5, C.8.19.6.3).
void parse_detector(DcmDataset& dataset, ProjectionRun& run) {
  run.detector_spacing_mm = detector_spacing(dataset);
  if (run.detector_spacing_mm[0] > 0.0 && !(spacing_by(dataset, DCM_ImagerPixelSpacing)[0] > 0.0))
    run.notes.push_back(
        "the detector's pixel spacing is not stated; the field of view over the "
        "picture makes it " +
        format_number(run.detector_spacing_mm[0]) + " mm");
  run.picture_turn_degrees = deep_number(dataset, DCM_FieldOfViewRotation).value_or(0.0);
  run.picture_is_mirrored = deep_text(dataset, DCM_FieldOfViewHorizontalFlip) == "YES";
  const auto element = spacing_by(dataset, DCM_DetectorElementSpacing);
  const auto active = spacing_by(dataset, DCM_DetectorActiveDimensions);  // rows first, in mm
  const auto row = deep_number(dataset, DCM_FieldOfViewOrigin, 0);
  const auto column = deep_number(dataset, DCM_FieldOfViewOrigin, 1);
  if (!row || !column || !(element[0] > 0.0) || !(active[0] > 0.0)) return;
  const bool lies = std::abs(std::fmod(run.picture_turn_degrees, 180.0)) > 45.0;
  const double width = integer(dataset, DCM_Columns) * run.detector_spacing_mm[0];
  const double height = integer(dataset, DCM_Rows) * run.detector_spacing_mm[1];
  run.middle_offset_mm = {*column * element[0] + 0.5 * (lies ? height : width) - 0.5 * active[0],
                          *row * element[1] + 0.5 * (lies ? width : height) - 0.5 * active[1]};
}

}  // namespace

ProjectionRun parse_projection_run(DcmDataset& dataset, int frame_count) {
  ProjectionRun run;
  parse_angles(dataset, run);
  parse_distances(dataset, run);
  parse_spacing(dataset, run);
  parse_run_times(dataset, frame_count, run);
  parse_mask(dataset, frame_count, run);
  parse_shapes(dataset, run);
  parse_field(dataset, run);
  parse_table(dataset, run);
  parse_detector(dataset, run);
  run.positioner_motion = text(dataset, DCM_PositionerMotion);
  run.pixel_relation = deep_text(dataset, DCM_PixelIntensityRelationship);
  run.is_inverted = deep_number(dataset, DCM_PixelIntensityRelationshipSign).value_or(1.0) < 0.0;
  run.has_contrast_medium = !text(dataset, DCM_ContrastBolusAgent).empty();
  run.burned_in_text = text(dataset, DCM_BurnedInAnnotation) == "YES";
  return run;
}

}  // namespace angio::segmentation::detail
