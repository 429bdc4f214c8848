#pragma once

#include <dcmtk/dcmdata/dcfilefo.h>
#include <dcmtk/dcmdata/dcrleerg.h>
#include <dcmtk/dcmjpeg/djencode.h>
#include <dcmtk/dcmjpls/djencode.h>
#include <dcmtk/oflog/oflog.h>
#include <gtest/gtest.h>

#include <filesystem>

/// Files compressed without loss.
namespace angio::segmentation {

/// Encoders of DCMTK, for the length of a test.
struct Encoders {
  Encoders() {
    OFLog::configure(OFLogger::OFF_LOG_LEVEL);
    DJEncoderRegistration::registerCodecs();
    DJLSEncoderRegistration::registerCodecs(0, 0, 0, 0, OFFalse);  // the pixels as they are
    DcmRLEEncoderRegistration::registerCodecs();
  }
  ~Encoders() {
    DJEncoderRegistration::cleanup();
    DJLSEncoderRegistration::cleanup();
    DcmRLEEncoderRegistration::cleanup();
  }
  Encoders(const Encoders&) = delete;
  Encoders& operator=(const Encoders&) = delete;
};

/// Compresses a file.
inline void recode(const std::filesystem::path& path, E_TransferSyntax syntax,
                   const DcmRepresentationParameter* parameter) {
  DcmFileFormat file;
  ASSERT_TRUE(file.loadFile(path.c_str()).good());
  ASSERT_TRUE(file.getDataset()->chooseRepresentation(syntax, parameter).good());
  file.loadAllDataIntoMemory();
  ASSERT_TRUE(file.saveFile(path.c_str(), syntax).good());
}

}  // namespace angio::segmentation
