#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <system_error>
#include <utility>

#include "core/error.hpp"
#include "dicom/archive.hpp"
#include "dicom/detail/connection.hpp"
#include "dicom/detail/guarded_session.hpp"

namespace angio::dicom {
namespace fs = std::filesystem;
namespace {

constexpr std::array kImageClasses{UID_XRayAngiographicImageStorage,
                                   UID_EnhancedXAImageStorage,
                                   UID_XRay3DAngiographicImageStorage,
                                   UID_CTImageStorage,
                                   UID_EnhancedCTImageStorage,
                                   UID_MRImageStorage,
                                   UID_EnhancedMRImageStorage,
                                   UID_SecondaryCaptureImageStorage,
                                   UID_MultiframeGrayscaleWordSecondaryCaptureImageStorage};
/// One context each, so that the archive may send an image as it is.
constexpr std::array kPackedSyntaxes{UID_JPEGProcess14SV1TransferSyntax,
                                     UID_JPEGProcess14TransferSyntax,
                                     UID_JPEGLSLosslessTransferSyntax,
                                     UID_JPEG2000LosslessOnlyTransferSyntax,
                                     UID_RLELosslessTransferSyntax,
                                     UID_JPEG2000TransferSyntax,
                                     UID_JPEGProcess1TransferSyntax,
                                     UID_JPEGProcess2_4TransferSyntax,
                                     UID_DeflatedExplicitVRLittleEndianTransferSyntax};

struct FoundSeries {
  std::string uid;
  std::int64_t object_count = 0;  ///< 0: the archive does not say
};

std::string value(DcmItem& item, const DcmTagKey& tag) {
  OFString text;
  return item.findAndGetOFString(tag, text).good() ? text.c_str() : "";
}

/// Puts what comes into numbered files.
class FetchingConnection : public detail::Connection {
 public:
  FetchingConnection(const ArchiveAddress& address, fs::path folder, detail::TellFraction tell)
      : Connection(address), folder_(std::move(folder)), tell_(std::move(tell)) {
    setStorageMode(DCMSCU_STORAGE_BIT_PRESERVING);
    setStorageDir(folder_.c_str());
  }
  void expect(std::int64_t count) { expected_count_ = count; }
  [[nodiscard]] std::int64_t count() const { return std::int64_t(objects_.size()); }

  OFCondition handleSTORERequestFile(T_ASC_PresentationContextID* context, const OFString&,
                                     T_DIMSE_C_StoreRQ* request) override {
    const fs::path file = folder_ / fmt::format("arrival-{:06}", objects_.size());
    const OFCondition stored = DcmSCU::handleSTORERequestFile(context, file.c_str(), request);
    if (stored.good()) objects_.emplace_back(request->AffectedSOPInstanceUID, file);
    if (expected_count_ > 0)
      tell_(std::min(1.0, double(objects_.size()) / double(expected_count_)));
    return stored;
  }
  /// Names them in the order of their UIDs: the same study gives the same folder.
  void number_files() {
    std::sort(objects_.begin(), objects_.end());
    for (std::size_t i = 0; i < objects_.size(); ++i)
      fs::rename(objects_[i].second, folder_ / fmt::format("{:06}.dcm", i + 1));
  }

 private:
  fs::path folder_;
  detail::TellFraction tell_;
  std::int64_t expected_count_ = 0;
  std::vector<std::pair<std::string, fs::path>> objects_;
};

/// C-FIND. @return the data sets that match
std::vector<std::unique_ptr<DcmDataset>> find(detail::Connection& connection, DcmDataset& keys) {
  const auto context =
      connection.context_of(UID_FINDStudyRootQueryRetrieveInformationModel, "queries (C-FIND)");
  OFList<QRResponse*> responses;
  const OFCondition asked = connection.sendFINDRequest(context, &keys, &responses);
  std::vector<std::unique_ptr<DcmDataset>> found;
  Uint16 status = STATUS_Success;
  for (QRResponse* response : responses) {
    status = response->m_status;
    if (response->m_dataset != nullptr) found.emplace_back(std::exchange(response->m_dataset, {}));
    delete response;
  }
  connection.require(asked, "query");
  if (status != STATUS_Success)
    throw IoError(fmt::format("{} could not answer the query ({}). Its log says why",
                              connection.name(), detail::status_text(status)));
  return found;
}

std::string find_study(detail::Connection& connection, const ArchiveQuery& query) {
  if (!query.study_uid.empty()) return query.study_uid;
  DcmDataset keys;
  keys.putAndInsertString(DCM_QueryRetrieveLevel, "STUDY");
  keys.putAndInsertString(DCM_StudyInstanceUID, "");
  keys.putAndInsertString(DCM_PatientID, query.patient_id.c_str());
  keys.putAndInsertString(DCM_AccessionNumber, query.accession_number.c_str());
  keys.putAndInsertString(DCM_StudyDate, query.study_date.c_str());
  const auto studies = find(connection, keys);
  if (studies.empty())
    throw InputError(connection.name() +
                         " has no such study (or does not show it to us). Check "
                         "number and date",
                     ExitCode::no_input);
  if (studies.size() > 1)
    throw InputError(
        fmt::format("{} has {} such studies, and one is fetched at a time. Add --study, "
                    "--accession or --date",
                    connection.name(), studies.size()));
  return value(*studies.front(), DCM_StudyInstanceUID);
}

std::vector<FoundSeries> find_series(detail::Connection& connection, const ArchiveQuery& query,
                                     const std::string& study_uid) {
  DcmDataset keys;
  keys.putAndInsertString(DCM_QueryRetrieveLevel, "SERIES");
  keys.putAndInsertString(DCM_StudyInstanceUID, study_uid.c_str());
  keys.putAndInsertString(DCM_SeriesInstanceUID, query.series_uid.c_str());
  keys.putAndInsertString(DCM_Modality, query.modality.c_str());
  keys.putAndInsertString(DCM_NumberOfSeriesRelatedInstances, "");
  std::vector<FoundSeries> series;
  for (const auto& item : find(connection, keys)) {
    const std::string modality = value(*item, DCM_Modality);
    if (!query.modality.empty() && !modality.empty() && modality != query.modality) continue;
    series.push_back({value(*item, DCM_SeriesInstanceUID),
                      std::atoll(value(*item, DCM_NumberOfSeriesRelatedInstances).c_str())});
  }
  if (series.empty())
    throw InputError(connection.name() +
                         " has no such series in that study (or no such study). "
                         "Check the UIDs and --modality",
                     ExitCode::no_input);
  return series;
}

/// C-GET of one series.
void get_series(FetchingConnection& connection, const std::string& study_uid,
                const std::string& series_uid) {
  DcmDataset keys;
  keys.putAndInsertString(DCM_QueryRetrieveLevel, "SERIES");
  keys.putAndInsertString(DCM_StudyInstanceUID, study_uid.c_str());
  keys.putAndInsertString(DCM_SeriesInstanceUID, series_uid.c_str());
  const auto context =
      connection.context_of(UID_GETStudyRootQueryRetrieveInformationModel, "retrieval (C-GET)");
  OFList<RetrieveResponse*> responses;
  const OFCondition asked = connection.sendCGETRequest(context, &keys, &responses);
  Uint16 status = STATUS_Success;
  int failed_count = 0;
  for (RetrieveResponse* response : responses) {
    status = response->m_status;
    failed_count = response->m_numberOfFailedSubops;
    delete response;
  }
  connection.require(asked, "request of a series");
  if (failed_count > 0)
    throw IoError(
        fmt::format("{} could not send {} objects of the series (they are packed in a way "
                    "that was not agreed on, or damaged). Its log says why",
                    connection.name(), failed_count));
  if (status != STATUS_Success)
    throw IoError(fmt::format("{} could not send the series ({}). Its log says why",
                              connection.name(), detail::status_text(status)));
}

void offer_images(FetchingConnection& connection) {
  for (const char* image : kImageClasses) {
    connection.offer(image, detail::uncompressed_syntaxes(), ASC_SC_ROLE_SCP);
    for (const char* packed : kPackedSyntaxes) {
      OFList<OFString> syntax;
      syntax.push_back(packed);
      connection.offer(image, syntax, ASC_SC_ROLE_SCP);
    }
  }
}

Fetched fetch(const ArchiveLocation& location, const fs::path& folder,
              const detail::TellFraction& tell) {
  FetchingConnection connection(location.address, folder, tell);
  connection.offer(UID_VerificationSOPClass, detail::uncompressed_syntaxes());
  connection.offer(UID_FINDStudyRootQueryRetrieveInformationModel, detail::uncompressed_syntaxes());
  connection.offer(UID_GETStudyRootQueryRetrieveInformationModel, detail::uncompressed_syntaxes());
  offer_images(connection);
  connection.connect();
  connection.check_answers();
  const std::string study_uid = find_study(connection, location.query);
  const std::vector<FoundSeries> series = find_series(connection, location.query, study_uid);
  std::int64_t expected = 0;
  for (const FoundSeries& one : series) expected += one.object_count;
  connection.expect(expected);
  for (const FoundSeries& one : series) get_series(connection, study_uid, one.uid);
  connection.close();
  if (connection.count() == 0)
    throw InputError(connection.name() +
                     " sent no image (the series hold none that this program "
                     "reads: XA, CT, MR or secondary captures)");
  connection.number_files();
  return {std::int64_t(series.size()), connection.count()};
}

/// A folder in the making beside its final place; removed unless it is kept.
class NewFolder {
 public:
  explicit NewFolder(fs::path path) : path_(std::move(path)) {
    std::error_code ignored;
    if (fs::exists(path_, ignored) && !(fs::is_directory(path_, ignored) && fs::is_empty(path_)))
      throw IoError(path_.string() + " is there already (and not empty). Name a new folder",
                    ExitCode::cannot_create);
    const fs::path parent = fs::absolute(path_).lexically_normal().parent_path();
    temporary_ = parent / ("." + path_.filename().string() + ".tmp-" + std::to_string(getpid()));
    std::error_code failed;
    fs::create_directories(temporary_, failed);
    if (!failed) fs::permissions(temporary_, fs::perms::owner_all, failed);
    if (failed)
      throw IoError(path_.string() + " cannot be created (" + failed.message() + ")",
                    ExitCode::cannot_create);
  }
  ~NewFolder() {
    std::error_code ignored;
    fs::remove_all(temporary_, ignored);
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;
  [[nodiscard]] const fs::path& path() const { return temporary_; }
  void keep() const {
    std::error_code failed;
    fs::remove(path_, failed);  // an empty one
    fs::rename(temporary_, path_, failed);
    if (failed)
      throw IoError(path_.string() + " cannot be created (" + failed.message() + ")",
                    ExitCode::cannot_create);
  }

 private:
  fs::path path_, temporary_;
};

}  // namespace

Fetched fetch_from_archive(const ArchiveLocation& location, const fs::path& folder,
                           const Progress& progress) {
  location.address.validate();
  const NewFolder made(folder);
  const std::vector<std::int64_t> counts =
      detail::run_session(location.address, "fetching from " + location.address.ae_title, progress,
                          [&](const detail::TellFraction& tell) -> std::vector<std::int64_t> {
                            const Fetched fetched = fetch(location, made.path(), tell);
                            return {fetched.series_count, fetched.object_count};
                          });
  made.keep();
  return {counts.at(0), counts.at(1)};
}

}  // namespace angio::dicom
