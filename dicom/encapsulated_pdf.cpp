#include "dicom/encapsulated_pdf.hpp"

#include "dicom/detail/objects.hpp"

namespace angio::dicom {
namespace {

void add_source_objects(DcmItem& item, const SourceLink& source) {
  for (const SourceObject& object : source.objects) {
    DcmItem* reference = nullptr;
    detail::check(item.findOrCreateSequenceItem(DCM_SourceInstanceSequence, reference, -2),
                  "reference");
    detail::check(
        reference->putAndInsertString(DCM_ReferencedSOPClassUID, object.sop_class_uid.c_str()),
        "reference");
    detail::check(
        reference->putAndInsertString(DCM_ReferencedSOPInstanceUID, object.instance_uid.c_str()),
        "reference");
  }
}

}  // namespace

void write_encapsulated_pdf(const std::filesystem::path& path, const EncapsulatedPdf& document) {
  detail::silence_log();
  DcmDataset dataset;
  dataset.putAndInsertString(DCM_SOPClassUID, UID_EncapsulatedPDFStorage);
  detail::put_identity(dataset, document.identity,
                       {"DOC", "Balloon angioplasty report", document.seed, 9001},
                       document.version);
  dataset.putAndInsertString(DCM_ConversionType, "WSD");
  dataset.putAndInsertString(DCM_BurnedInAnnotation, "NO");
  dataset.putAndInsertString(DCM_RecognizableVisualFeatures, "NO");
  dataset.putAndInsertString(DCM_AcquisitionDateTime, "");
  dataset.putAndInsertString(DCM_DocumentTitle, document.title.c_str());
  DcmItem* name = nullptr;
  detail::check(dataset.findOrCreateSequenceItem(DCM_ConceptNameCodeSequence, name), "title");
  name->putAndInsertString(DCM_CodeValue, "126000");
  name->putAndInsertString(DCM_CodingSchemeDesignator, "DCM");
  name->putAndInsertString(DCM_CodeMeaning, "Imaging Measurement Report");
  dataset.putAndInsertString(DCM_MIMETypeOfEncapsulatedDocument, "application/pdf");
  if (document.source) add_source_objects(dataset, *document.source);
  std::string bytes = document.pdf;
  dataset.putAndInsertUint32(DCM_EncapsulatedDocumentLength, Uint32(bytes.size()));
  if (bytes.size() % 2 != 0) bytes.push_back('\0');
  detail::check(
      dataset.putAndInsertUint8Array(DCM_EncapsulatedDocument,
                                     reinterpret_cast<const Uint8*>(bytes.data()), bytes.size()),
      "document");
  detail::write_object(path, dataset);
}

}  // namespace angio::dicom
