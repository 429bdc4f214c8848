#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/progress.hpp"

/// A picture archive (PACS), spoken to by DICOM's network services (PS3.4, PS3.7, PS3.8), without
/// encryption. No message names a patient or a UID. Each of these ends at once when `progress`
/// throws, and within the address's time-out when the archive falls silent.
namespace angio::dicom {

struct ArchiveAddress {
  std::string ae_title;                ///< of the archive, at most 16 characters
  std::string host;                    ///< name or number
  int port = 104;                      ///< [1, 65535]
  std::string our_ae_title = "ANGIO";  ///< at most 16 characters; the archive may have to know it
  double timeout_s = 30.0;             ///< of connecting, and of each answer; [1, 3600]

  void validate() const;
};

/// "AET@HOST:PORT". @throws Error (64)
ArchiveAddress parse_archive_address(const std::string& text);

/// Which objects are wanted; empty members ask for nothing. They name one study.
struct ArchiveQuery {
  std::string study_uid = {}, series_uid = {};
  std::string patient_id = {}, accession_number = {};
  std::string study_date = {};  ///< YYYYMMDD, or a range YYYYMMDD-YYYYMMDD
  std::string modality = {};    ///< of the series: "XA"
};

/// An archive and what is wanted of it: "pacs://AET@HOST:PORT/STUDY_UID[/SERIES_UID]".
struct ArchiveLocation {
  ArchiveAddress address;
  ArchiveQuery query;
};
bool is_archive_location(const std::string& text);
/// @throws Error (64)
ArchiveLocation parse_archive_location(const std::string& text);

/// Asks whether the archive answers (C-ECHO), and sends it files (C-STORE).
/// @throws Error (69) if it cannot be reached or refuses us, IoError (74) if it does not take a
/// file
void send_to_archive(const ArchiveAddress& address, const std::vector<std::filesystem::path>& files,
                     const Progress& progress = {});

struct Fetched {
  std::int64_t series_count = 0;
  std::int64_t object_count = 0;
};

/// Looks for a study (C-FIND) and fetches its series (C-GET) into a folder, which appears when it
/// is whole: files 000001.dcm and so on, by the order of their UIDs, readable by their owner only.
/// @param folder  must not exist, or be empty
/// @throws Error (69) as above; InputError (66) if there is no such study or series, (65) if
/// several
///         studies match; IoError (73) if the folder is not empty, (74) if objects are missing
Fetched fetch_from_archive(const ArchiveLocation& location, const std::filesystem::path& folder,
                           const Progress& progress = {});

}  // namespace angio::dicom
