#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmsr/dsrdoc.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>

#include "core/atomic_file.hpp"
#include "testing/temporary_folder.hpp"
#include "tests/dicom/example_objects.hpp"

namespace angio::dicom {
namespace {
using test::TemporaryFolder;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

std::string text_of(const fs::path& file, const DcmTagKey& tag) {
  DcmFileFormat object;
  EXPECT_TRUE(object.loadFile(file.c_str()).good());
  OFString value;
  object.getDataset()->findAndGetOFString(tag, value);
  return value.c_str();
}

/// What dciodvfy (package dicom3tools) has to say; "skipped" where it is missing.
std::string verdict(const fs::path& file) {
  if (std::system("command -v dciodvfy > /dev/null 2>&1") != 0) return "skipped";
  const fs::path out = file.string() + ".verdict";
  EXPECT_GE(std::system(("dciodvfy " + file.string() + " > " + out.string() + " 2>&1").c_str()), 0);
  return read_text(out);
}

/// The report as DCMTK prints it.
std::string printed(const fs::path& file) {
  DcmFileFormat object;
  DSRDocument document;
  EXPECT_TRUE(object.loadFile(file.c_str()).good());
  EXPECT_TRUE(document.read(*object.getDataset()).good());
  std::ostringstream out;
  document.print(out, DSRTypes::PF_printSOPInstanceUID | DSRTypes::PF_printConceptNameCodes);
  return out.str();
}

TEST(EncapsulatedPdfObject, HoldsTheDocumentByteForByte) {
  const TemporaryFolder folder;
  for (const char* more : {"", "x"}) {  // of even and odd length
    EncapsulatedPdf document = test::example_pdf();
    document.pdf += more;
    write_encapsulated_pdf(folder / "a.dcm", document);
    DcmFileFormat object;
    ASSERT_TRUE(object.loadFile((folder / "a.dcm").c_str()).good());
    const Uint8* bytes = nullptr;
    Uint32 length = 0;
    object.getDataset()->findAndGetUint8Array(DCM_EncapsulatedDocument, bytes);
    object.getDataset()->findAndGetUint32(DCM_EncapsulatedDocumentLength, length);
    EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes), length), document.pdf);
  }
}

TEST(DicomObjects, AreFiledUnderTheCaseUnlessTheyAreLinked) {
  const TemporaryFolder folder;
  EncapsulatedPdf document = test::example_pdf();
  write_encapsulated_pdf(folder / "a.dcm", document);
  EXPECT_EQ(text_of(folder / "a.dcm", DCM_PatientName), "CASE-1");
  EXPECT_EQ(text_of(folder / "a.dcm", DCM_PatientBirthDate), "");
  EXPECT_EQ(text_of(folder / "a.dcm", DCM_StudyInstanceUID).substr(0, 5), "2.25.");
  document.identity = test::someone();
  document.source = test::someones_scan();
  write_encapsulated_pdf(folder / "b.dcm", document);
  EXPECT_EQ(text_of(folder / "b.dcm", DCM_PatientName), "Müller^Jörg");
  EXPECT_EQ(text_of(folder / "b.dcm", DCM_SpecificCharacterSet), "ISO_IR 192");
  EXPECT_EQ(text_of(folder / "b.dcm", DCM_StudyInstanceUID), "1.2.826.0.1.3680043.2.10");
  EXPECT_THAT(read_text(folder / "b.dcm"), HasSubstr("1.2.826.0.1.3680043.2.102"));
  EXPECT_THAT(read_text(folder / "a.dcm"), Not(HasSubstr("1.2.826.0.1.3680043.2.102")));
}

TEST(MeasurementReportObject, SaysEachMeasurementWithUnitAndCode) {
  const TemporaryFolder folder;
  write_measurement_report(folder / "a.dcm", test::example_report());
  const std::string text = printed(folder / "a.dcm");
  for (const char* part :
       {"Lesion before", "G-0364,SRT", "1.23457", "mm,UCUM", "255605001,SCT", "99ANGIO",
        "Reference diameter", "12.5", "122304,DCM", "the vessel is narrow", "126000,DCM"})
    EXPECT_THAT(text, HasSubstr(part));
  DcmFileFormat object;
  ASSERT_TRUE(object.loadFile((folder / "a.dcm").c_str()).good());
  DcmItem* scheme = nullptr;
  ASSERT_TRUE(object.getDataset()
                  ->findAndGetSequenceItem(DCM_CodingSchemeIdentificationSequence, scheme)
                  .good());
}

TEST(MeasurementReportObject, RefersToTheImagesOfALinkedScan) {
  const TemporaryFolder folder;
  MeasurementReport report = test::example_report();
  report.identity = test::someone();
  report.source = test::someones_scan();
  write_measurement_report(folder / "a.dcm", report);
  DcmFileFormat object;
  ASSERT_TRUE(object.loadFile((folder / "a.dcm").c_str()).good());
  DcmSequenceOfItems* evidence = nullptr;
  ASSERT_TRUE(object.getDataset()
                  ->findAndGetSequence(DCM_CurrentRequestedProcedureEvidenceSequence, evidence)
                  .good());
  DcmItem* series = nullptr;
  ASSERT_TRUE(
      evidence->getItem(0)->findAndGetSequenceItem(DCM_ReferencedSeriesSequence, series).good());
  DcmSequenceOfItems* instances = nullptr;
  ASSERT_TRUE(series->findAndGetSequence(DCM_ReferencedSOPSequence, instances).good());
  EXPECT_EQ(instances->card(), 2u);
  EXPECT_THAT(printed(folder / "a.dcm"), HasSubstr("Image Library"));
}

TEST(DicomObjects, PassDciodvfy) {
  const TemporaryFolder folder;
  for (const bool is_linked : {false, true}) {
    EncapsulatedPdf document = test::example_pdf();
    MeasurementReport report = test::example_report();
    if (is_linked) {
      document.identity = report.identity = test::someone();
      document.source = report.source = test::someones_scan();
    }
    write_encapsulated_pdf(folder / "pdf.dcm", document);
    write_measurement_report(folder / "sr.dcm", report);
    for (const char* name : {"pdf.dcm", "sr.dcm"}) {
      const std::string said = verdict(folder / name);
      if (said == "skipped") GTEST_SKIP() << "dciodvfy (package dicom3tools) is not installed";
      EXPECT_THAT(said, Not(HasSubstr("Error"))) << name << ":\n" << said;
    }
  }
}

TEST(DicomObjects, AreTheSameBytesEachTime) {
  const TemporaryFolder folder;
  write_encapsulated_pdf(folder / "a.dcm", test::example_pdf());
  write_encapsulated_pdf(folder / "b.dcm", test::example_pdf());
  EXPECT_EQ(read_text(folder / "a.dcm"), read_text(folder / "b.dcm"));
  write_measurement_report(folder / "c.dcm", test::example_report());
  write_measurement_report(folder / "d.dcm", test::example_report());
  EXPECT_EQ(read_text(folder / "c.dcm"), read_text(folder / "d.dcm"));
}

TEST(AnonymousIdentity, IsTheCasesName) {
  const StudyIdentity identity = anonymous_identity("A^B=C\\D", "seed");
  EXPECT_EQ(identity.patient_name, "A B C D");
  EXPECT_EQ(identity.study_uid, anonymous_identity("other", "seed").study_uid);
  EXPECT_NE(identity.study_uid, anonymous_identity("A", "seed 2").study_uid);
  // 64 bytes at most, and no half of a character.
  std::string long_name = "x";
  for (int i = 0; i < 40; ++i) long_name += "é";
  const std::string cut = anonymous_identity(long_name, "s").patient_name;
  EXPECT_EQ(cut.size(), 63u);
  EXPECT_EQ(cut, long_name.substr(0, 63));
}

TEST(HashedUid, IsANumberOf128BitsAfter2_25) {
  for (const char* text : {"", "a", "b", "a longer text"}) {
    const std::string uid = hashed_uid(text);
    EXPECT_EQ(uid.substr(0, 5), "2.25.");
    EXPECT_LE(uid.size(), 5u + 39u);
    EXPECT_EQ(uid.find_first_not_of("0123456789."), std::string::npos);
    EXPECT_EQ(uid, hashed_uid(text));
  }
  EXPECT_NE(hashed_uid("a"), hashed_uid("b"));
}

}  // namespace
}  // namespace angio::dicom
