#pragma once

#include <string>

#include "dicom/encapsulated_pdf.hpp"
#include "dicom/measurement_report.hpp"

namespace angio::test {

/// The least that is a PDF file.
inline std::string smallest_pdf() {
  return "%PDF-1.4\n1 0 obj<</Type/Catalog/Pages 2 0 R>>endobj\n2 0 obj<</Type/Pages/Kids[3 0 R]"
         "/Count 1>>endobj\n3 0 obj<</Type/Page/Parent 2 0 R/MediaBox[0 0 9 9]>>endobj\n"
         "trailer<</Root 1 0 R>>\n%%EOF\n";
}

inline dicom::StudyIdentity someone() {
  dicom::StudyIdentity identity;
  identity.patient_name = "Müller^Jörg";
  identity.patient_id = "4711";
  identity.birth_date = "19500607";
  identity.sex = "M";
  identity.study_uid = "1.2.826.0.1.3680043.2.10";
  identity.study_id = "S1";
  identity.study_date = "20200102";
  identity.study_time = "101112";
  identity.accession_number = "A77";
  identity.referring_physician = "House^Gregory";
  identity.frame_of_reference_uid = "1.2.826.0.1.3680043.2.20";
  return identity;
}

inline dicom::SourceLink someones_scan() {
  return {someone(),
          "XA",
          "1.2.826.0.1.3680043.2.100",
          {{"1.2.840.10008.5.1.4.1.1.12.1", "1.2.826.0.1.3680043.2.101"},
           {"1.2.840.10008.5.1.4.1.1.12.1", "1.2.826.0.1.3680043.2.102"}}};
}

inline dicom::EncapsulatedPdf example_pdf() {
  return {"CASE-1", smallest_pdf(), "1.2.3", dicom::anonymous_identity("CASE-1", "seed"),
          {},       "pdf"};
}

inline dicom::MeasurementReport example_report() {
  const dicom::Code mm{"mm", "UCUM", "mm"};
  return {"1.2.3",
          dicom::anonymous_identity("CASE-1", "seed"),
          {},
          {{"Lesion before",
            {"415582006", "SCT", "Stenosis"},
            {{{"G-0364", "SRT", "Vessel lumen diameter"},
              1.2345678,
              mm,
              dicom::Code{"255605001", "SCT", "Minimum"}},
             {{"REFERENCE_D", dicom::kPrivateScheme, "Reference diameter"}, 3.0, mm, {}}}},
           {"After",
            {"122304", "DCM", "Angioplasty balloon deflated"},
            {{{"R-101BB", "SRT", "Lumen Diameter Stenosis"}, 12.5, {"%", "UCUM", "%"}, {}}}}},
          {"Not for clinical use", "the vessel is narrow"},
          "sr"};
}

}  // namespace angio::test
