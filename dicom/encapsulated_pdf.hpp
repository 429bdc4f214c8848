#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "dicom/identity.hpp"

namespace angio::dicom {

struct EncapsulatedPdf {
  std::string title;    ///< of the document
  std::string pdf;      ///< the whole PDF file
  std::string version;  ///< of the program
  StudyIdentity identity;
  std::optional<SourceLink> source;  ///< what the document was made from; its identity is not used
  std::string seed;                  ///< of the object's UIDs
};

/// Writes a document as an Encapsulated PDF object (DICOM PS3.3 A.45.1).
/// @throws IoError if it cannot be written
void write_encapsulated_pdf(const std::filesystem::path& path, const EncapsulatedPdf& document);

}  // namespace angio::dicom
