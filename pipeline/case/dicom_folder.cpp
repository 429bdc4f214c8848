#include "pipeline/case/dicom_folder.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "dicom/encapsulated_pdf.hpp"
#include "formats/case_file.hpp"
#include "formats/nrrd.hpp"
#include "pipeline/case/case_folder.hpp"
#include "pipeline/case/dicom_measurements.hpp"
#include "pipeline/case/fetched_scan.hpp"
#include "pipeline/case/input_kind.hpp"
#include "pipeline/case/mask_on_grid.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/config/config.hpp"
#include "pipeline/version.hpp"
#include "segmentation/dicom_link.hpp"
#include "segmentation/dicom_segmentation.hpp"
#include "viewer/report_pdf.hpp"

namespace angio::pipeline {
namespace file = formats::case_file;
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr const char* kMask = "segmentation/lumen_mask.nrrd";
constexpr const char* kPrivateLink = "source.private.json";
constexpr const char* kNotForUse =
    "Not for clinical use: a research computation that must not guide the treatment of a patient.";

/// The scan that a case was made from.
struct Source {
  FetchedScan scan;
  segmentation::ReadOptions options;
  dicom::SourceLink link;
};

Source find_source(const CaseFolder& folder, const Progress& progress) {
  if (!folder.exists(kPrivateLink))
    throw InputError(
        fmt::format("{} does not say what scan it was made from (it was run without --keep-link). "
                    "Run it again with --keep-link, or leave the option out here",
                    folder.root().string()),
        ExitCode::no_input);
  const std::string input = read_json(folder.path(kPrivateLink)).value("input", std::string());
  Config config;
  load_config(config, folder.path(file::kSettings));
  Source source{FetchedScan(input, {}, progress), config.input, {}};
  std::error_code ignored;
  if (!fs::exists(source.scan.path(), ignored))
    throw InputError(
        "the scan that the case was made from is not where it was. Put it back, or leave out "
        "--keep-link",
        ExitCode::no_input);
  source.link = segmentation::read_source_link(source.scan.path(), source.options);
  return source;
}

std::string read_page(const CaseFolder& folder) {
  if (!folder.exists(file::kRun))
    throw InputError(
        fmt::format("{} is no case (it has no run.json). Give the folder of `angio run`",
                    folder.root().string()),
        ExitCode::no_input);
  if (!folder.exists(file::kReport))
    throw InputError(fmt::format("{} has no report yet. Make it: `angio report {}`",
                                 folder.root().string(), folder.root().string()),
                     ExitCode::no_input);
  return read_text(folder.path(file::kReport));
}

/// Why the case is not `done`, what it warned of, and that it is no medical device.
std::vector<std::string> remarks_of(const json& metrics, const RunRecord& record) {
  std::vector<std::string> remarks{kNotForUse};
  const json reason = metrics.value("status_reason", json());
  if (reason.is_string()) remarks.push_back(reason.get<std::string>());
  for (const auto& [stage, entry] : record.stages)
    remarks.insert(remarks.end(), entry.warnings.begin(), entry.warnings.end());
  return remarks;
}

void write_segmentation(const CaseFolder& folder, const std::optional<Source>& source,
                        const dicom::StudyIdentity& identity, const RunRecord& record,
                        const fs::path& path) {
  if (source && record.input_kind != name(InputKind::run)) {
    segmentation::write_dicom_segmentation(
        path, segmentation::read_volume_file(folder.path(file::kLevelSet)), source->scan.path(),
        source->options, {.keep_patient = true});
    return;
  }
  const Volume<float> mask = formats::read_nrrd(folder.path(kMask));
  const bool has_scan = folder.exists(file::kScan);  // not where little was kept
  const VolumeGeometry grid =
      has_scan ? formats::read_nrrd(folder.path(file::kScan)).geometry : mask.geometry;
  segmentation::write_dicom_segmentation(path, mask_on_grid(mask, grid), identity);
}

}  // namespace

std::vector<fs::path> write_dicom_folder(const fs::path& case_folder, const fs::path& folder,
                                         DicomLink link, const Progress& progress) {
  const CaseFolder case_files(case_folder);
  const std::string page = read_page(case_files);
  const RunRecord record = case_files.read_record();
  const json metrics = read_json(case_files.path(file::kMetrics));
  std::optional<Source> source;
  if (link == DicomLink::source) source.emplace(find_source(case_files, progress));
  const std::string seed = record.input_sha256 + record.case_name;
  const dicom::StudyIdentity identity =
      source ? source->link.identity : dicom::anonymous_identity(record.case_name, seed);
  std::optional<dicom::SourceLink> reference;
  if (source) reference = source->link;

  progress.report(0.2, "report");
  make_folder(folder);
  std::vector<fs::path> files{folder / "report.dcm"};
  dicom::write_encapsulated_pdf(
      files.back(), {record.case_name, viewer::report_pdf(page, record.case_name, kVersion),
                     kVersion, identity, reference, sha256_of_text(seed + "report" + page)});
  progress.report(0.5, "measurements");
  const auto groups = measurement_groups(metrics);
  if (!groups.empty()) {
    files.push_back(folder / "measurements.dcm");
    dicom::write_measurement_report(
        files.back(), {kVersion, identity, reference, groups, remarks_of(metrics, record),
                       sha256_of_text(seed + "measurements" + metrics.dump())});
  }
  progress.report(0.6, "lumen");
  if (case_files.exists(kMask)) {
    files.push_back(folder / "lumen.dcm");
    write_segmentation(case_files, source, identity, record, files.back());
  }
  const fs::perms wanted = source ? fs::perms::owner_read | fs::perms::owner_write
                                  : fs::status(files.front()).permissions();
  for (const fs::path& path : files) fs::permissions(path, wanted);
  progress.report(1.0);
  return files;
}

void write_case_pdf(const fs::path& case_folder, const fs::path& path) {
  const CaseFolder folder(case_folder);
  const std::string page = read_page(folder);
  write_text_atomically(path, viewer::report_pdf(page, folder.read_record().case_name, kVersion));
}

}  // namespace angio::pipeline
