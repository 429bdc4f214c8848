#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dicom/identity.hpp"

namespace angio::dicom {

/// A term of a coding scheme (DICOM PS3.3 8.8).
struct Code {
  std::string value;    ///< at most 16 characters
  std::string scheme;   ///< "DCM", "SCT", "SRT", "UCUM", or kPrivateScheme
  std::string meaning;  ///< at most 64 characters
};

/// Of the terms that no public scheme has. Each report says what it is (PS3.3 C.12.1.1.1.1).
inline constexpr const char* kPrivateScheme = "99ANGIO";

struct Measurement {
  Code name;
  double value = 0.0;
  Code unit;                       ///< of UCUM
  std::optional<Code> derivation;  ///< "Minimum"
};

/// What was measured of one finding at one moment.
struct MeasurementGroup {
  std::string label;  ///< "Lesion before"; at most 64 characters
  Code finding;
  std::vector<Measurement> measurements;  ///< at least one
};

struct MeasurementReport {
  std::string version;  ///< of the program
  StudyIdentity identity;
  std::optional<SourceLink> source;  ///< the images that were measured; its identity is not used
  std::vector<MeasurementGroup> groups;  ///< at least one
  std::vector<std::string> remarks;
  std::string seed;  ///< of the object's UIDs
};

/// Writes a structured report after the template TID 1500, "Measurement Report" (DICOM PS3.16), as
/// an Enhanced SR object: a TID 1501 group each, the program as its observer (TID 1004), remarks as
/// comments, and with a source the image library (TID 1600) and the evidence.
/// @throws IoError if it cannot be made or written
void write_measurement_report(const std::filesystem::path& path, const MeasurementReport& report);

}  // namespace angio::dicom
