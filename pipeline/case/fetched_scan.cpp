#include "pipeline/case/fetched_scan.hpp"

#include "dicom/archive.hpp"

namespace angio::pipeline {

FetchedScan::FetchedScan(const std::string& input, const std::string& calling,
                         const Progress& progress)
    : path_(input) {
  if (!dicom::is_archive_location(input)) return;
  dicom::ArchiveLocation location = dicom::parse_archive_location(input);
  if (!calling.empty()) location.address.our_ae_title = calling;
  folder_.emplace("angio-scan");
  path_ = (folder_->path() / "scan").string();
  dicom::fetch_from_archive(location, path_, progress);
}

}  // namespace angio::pipeline
