#include <algorithm>
#include <cstdint>

#include "segmentation/detail/dicom_parse.hpp"

namespace angio::segmentation::detail {
namespace {

/// A text as a number that differs where the text does; 0 if there is none. FNV-1a, cut to what a
/// double holds exactly.
double as_number(const std::string& written) {
  if (written.empty()) return 0.0;
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : written) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return double((hash >> 12) | 1u);
}

double& phase(DicomFrame& frame, Phase which) { return frame.phase[std::size_t(which)]; }

void parse_position(DcmItem& item, DicomFrame& frame) {
  if (const auto position = vector(item, DCM_ImagePositionPatient)) {
    frame.position = *position;
    frame.has_position = true;
  }
}

void parse_orientation(DcmItem& item, DicomFrame& frame) {
  const auto i = vector(item, DCM_ImageOrientationPatient, 0);
  const auto j = vector(item, DCM_ImageOrientationPatient, 3);
  if (!i || !j) return;
  frame.axis_i = *i;
  frame.axis_j = *j;
  frame.has_orientation = true;
}

void parse_spacing(DcmItem& item, DicomFrame& frame) {
  // DICOM gives the distance between rows first.
  const auto j = number(item, DCM_PixelSpacing, 0);
  const auto i = number(item, DCM_PixelSpacing, 1);
  if (!i || !j) return;
  frame.spacing_i = *i;
  frame.spacing_j = *j;
  frame.has_spacing = true;
}

void parse_rescale(DcmItem& item, DicomFrame& frame) {
  const auto slope = number(item, DCM_RescaleSlope);
  const auto intercept = number(item, DCM_RescaleIntercept);
  if (!slope || !intercept || *slope == 0.0) return;
  frame.slope = *slope;
  frame.intercept = *intercept;
}

void parse_content(DcmItem& item, DicomFrame& frame) {
  phase(frame, Phase::stack) = as_number(text(item, DCM_StackID));
  phase(frame, Phase::temporal) = number(item, DCM_TemporalPositionIndex).value_or(0.0);
  phase(frame, Phase::acquisition) = number(item, DCM_FrameAcquisitionNumber).value_or(0.0);
}

void parse_timing(DcmItem& item, DicomFrame& frame) {
  phase(frame, Phase::trigger_time) =
      number(item, DCM_NominalCardiacTriggerDelayTime).value_or(0.0);
}

void parse_echo(DcmItem& item, DicomFrame& frame) {
  phase(frame, Phase::echo) = number(item, DCM_EffectiveEchoTime).value_or(0.0);
}

/// The phases of a classic object stand in the object itself.
void parse_classic_phases(DcmItem& item, DicomFrame& frame) {
  phase(frame, Phase::temporal) = number(item, DCM_TemporalPositionIdentifier).value_or(0.0);
  phase(frame, Phase::trigger_time) = number(item, DCM_TriggerTime).value_or(0.0);
  phase(frame, Phase::echo) = number(item, DCM_EchoNumbers).value_or(0.0);
  phase(frame, Phase::acquisition) = number(item, DCM_AcquisitionNumber).value_or(0.0);
  phase(frame, Phase::time) = number(item, DCM_AcquisitionTime).value_or(0.0);
  phase(frame, Phase::content_time) = number(item, DCM_ContentTime).value_or(0.0);
  OFString type;
  if (item.findAndGetOFStringArray(DCM_ImageType, type).good())
    phase(frame, Phase::image_type) = as_number(type.c_str());
}

/// Calls parse(item, frame) on the first item of a functional group, if it is there.
template <class Parse>
void parse_group(DcmItem& groups, const DcmTagKey& sequence, DicomFrame& frame,
                 const Parse& parse) {
  if (DcmItem* item = first_item(groups, sequence)) parse(*item, frame);
}

void parse_functional_groups(DcmItem& groups, DicomFrame& frame) {
  parse_group(groups, DCM_PlanePositionSequence, frame, parse_position);
  parse_group(groups, DCM_PlaneOrientationSequence, frame, parse_orientation);
  parse_group(groups, DCM_PixelMeasuresSequence, frame, parse_spacing);
  parse_group(groups, DCM_PixelValueTransformationSequence, frame, parse_rescale);
  parse_group(groups, DCM_FrameContentSequence, frame, parse_content);
  parse_group(groups, DCM_CardiacSynchronizationSequence, frame, parse_timing);
  parse_group(groups, DCM_MREchoSequence, frame, parse_echo);
}

}  // namespace

void parse_frames(DcmDataset& dataset, int frame_count, DicomHeader& header) {
  DicomFrame common;
  // Some 3D angiography systems keep the rescale with the reconstruction only.
  parse_group(dataset, DCM_XRay3DReconstructionSequence, common,
              [](DcmItem& item, DicomFrame& frame) {
                parse_rescale(item, frame);
                parse_group(item, DCM_PixelValueTransformationSequence, frame, parse_rescale);
              });
  parse_position(dataset, common);
  parse_orientation(dataset, common);
  parse_spacing(dataset, common);
  parse_rescale(dataset, common);
  parse_classic_phases(dataset, common);
  if (DcmItem* shared = first_item(dataset, DCM_SharedFunctionalGroupsSequence))
    parse_functional_groups(*shared, common);
  header.frames.assign(std::size_t(frame_count), common);

  DcmSequenceOfItems* per_frame = nullptr;
  if (dataset.findAndGetSequence(DCM_PerFrameFunctionalGroupsSequence, per_frame).bad() ||
      !per_frame)
    return;
  if (per_frame->card() != unsigned(frame_count)) {
    header.problem = "the object lists " + std::to_string(per_frame->card()) +
                     " frame descriptions for " + std::to_string(frame_count) +
                     " frames (it is damaged). Export the series again";
    return;
  }
  DcmObject* item = nullptr;
  for (auto& frame : header.frames) {
    item = per_frame->nextInContainer(item);
    if (auto* groups = dynamic_cast<DcmItem*>(item)) parse_functional_groups(*groups, frame);
  }
}

}  // namespace angio::segmentation::detail
