#include "dicom/measurement_report.hpp"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmsr/cmr/tid1500.h>
#include <dcmtk/dcmsr/dsrdoc.h>
#include <fmt/format.h>

#include "dicom/detail/objects.hpp"

namespace angio::dicom {
namespace {

using detail::check;

DSRCodedEntryValue coded(const Code& code) {
  return {code.value.c_str(), code.scheme.c_str(), code.meaning.c_str()};
}

void add_measurement(CMR_TID1501_in_TID1500& group, const Measurement& measurement) {
  const CMR_SRNumericMeasurementValue value(fmt::format("{:.6g}", measurement.value).c_str(),
                                            coded(measurement.unit));
  check(group.addMeasurement(coded(measurement.name), value), "measurement");
  if (measurement.derivation)
    check(group.getMeasurement().setDerivation(coded(*measurement.derivation)), "derivation");
}

void add_group(TID1500_MeasurementReport& report, const MeasurementGroup& group,
               const std::string& seed) {
  check(report.addIndividualMeasurements(), "group");
  CMR_TID1501_in_TID1500& item = report.getIndividualMeasurements();
  check(item.setTrackingIdentifier(group.label.c_str()), "group");
  check(item.setTrackingUniqueIdentifier(hashed_uid(seed + group.label).c_str()), "group");
  check(item.setFinding(coded(group.finding)), "finding");
  for (const Measurement& measurement : group.measurements) add_measurement(item, measurement);
}

/// The images by reference, with what the template wants said of each.
void add_image_library(TID1500_MeasurementReport& report, const SourceLink& source,
                       const StudyIdentity& identity) {
  TID1600_ImageLibrary& library = report.getImageLibrary();
  check(library.createNewImageLibrary(), "image library");
  check(library.addImageGroup(), "image library");
  for (const SourceObject& object : source.objects) {
    DcmDataset image;
    image.putAndInsertString(DCM_SOPClassUID, object.sop_class_uid.c_str());
    image.putAndInsertString(DCM_SOPInstanceUID, object.instance_uid.c_str());
    image.putAndInsertString(DCM_Modality, source.modality.c_str());
    image.putAndInsertString(DCM_StudyDate, identity.study_date.c_str());
    const OFCondition added =
        library.addImageEntry(image, TID1600_ImageLibrary::withAllDescriptors);
    if (added != CMR_EC_NoImageLibraryEntryDescriptorsToBeAdded) check(added, "image library");
  }
}

TID1500_MeasurementReport content_of(const MeasurementReport& report) {
  TID1500_MeasurementReport content(CMR_CID7021::ImagingMeasurementReport);
  check(content.setLanguage(CID5000_Languages::English), "language");
  check(content.getObservationContext().addDeviceObserver(
            hashed_uid("angio " + report.version).c_str(), "angio", "angio", "angio",
            report.version.c_str()),
        "observer");
  check(content.addProcedureReported(CMR_CID100::ImagingProcedure), "procedure");
  if (report.source) add_image_library(content, *report.source, report.identity);
  for (const MeasurementGroup& group : report.groups) add_group(content, group, report.seed);
  for (const std::string& remark : report.remarks)
    check(content.addQualitativeEvaluation(DSRCodedEntryValue("121106", "DCM", "Comment"),
                                           remark.c_str()),
          "remark");
  return content;
}

void add_evidence(DSRDocument& document, const SourceLink& source, const StudyIdentity& identity) {
  for (const SourceObject& object : source.objects)
    check(document.getCurrentRequestedProcedureEvidence().addItem(
              identity.study_uid.c_str(), source.series_uid.c_str(), object.sop_class_uid.c_str(),
              object.instance_uid.c_str()),
          "evidence");
}

}  // namespace

void write_measurement_report(const std::filesystem::path& path, const MeasurementReport& report) {
  detail::silence_log();
  TID1500_MeasurementReport content = content_of(report);
  DSRDocument document;
  check(document.createNewDocument(DSRTypes::DT_EnhancedSR), "report");
  check(document.setTreeFromRootTemplate(content), "report");
  check(document.setSpecificCharacterSetType(DSRTypes::CS_UTF8), "report");
  check(document.getCodingSchemeIdentification().addItem(kPrivateScheme), "scheme");
  check(document.getCodingSchemeIdentification().setCodingSchemeName(
            "Measurements of the program angio"),
        "scheme");
  check(document.getCodingSchemeIdentification().setCodingSchemeResponsibleOrganization("angio"),
        "scheme");
  if (report.source) add_evidence(document, *report.source, report.identity);
  check(document.completeDocument(), "report");
  DcmDataset dataset;
  check(document.write(dataset), "report");
  detail::put_identity(dataset, report.identity,
                       {"SR", "Balloon angioplasty measurements", report.seed, 9002},
                       report.version);
  detail::write_object(path, dataset);
}

}  // namespace angio::dicom
