#include <fmt/format.h>

#include "core/error.hpp"
#include "dicom/archive.hpp"
#include "dicom/detail/connection.hpp"
#include "dicom/detail/guarded_session.hpp"

namespace angio::dicom {
namespace fs = std::filesystem;
namespace {

constexpr Uint16 kWarningFirst = 0xb000, kWarningLast = 0xbfff;  ///< stored, but changed

std::string class_of(const fs::path& file) {
  DcmFileFormat object;
  OFString uid;
  if (object.loadFile(file.c_str(), EXS_Unknown, EGL_noChange, 4096).bad() ||
      object.getDataset()->findAndGetOFString(DCM_SOPClassUID, uid).bad())
    throw InputError(file.filename().string() + " cannot be sent (it is no DICOM object)");
  return uid.c_str();
}

void store(detail::Connection& connection, const fs::path& file, const std::string& sop_class) {
  const std::string name = file.filename().string();
  const auto context = connection.context_of(sop_class, "the storage of " + name);
  Uint16 status = 0;
  connection.require(connection.sendSTORERequest(context, file.c_str(), nullptr, status),
                     "C-STORE of " + name);
  if (status != STATUS_Success && (status < kWarningFirst || status > kWarningLast))
    throw IoError(fmt::format("{} did not take {} ({}). Its log says why", connection.name(), name,
                              detail::status_text(status)));
}

void send(const ArchiveAddress& address, const std::vector<fs::path>& files,
          const detail::TellFraction& tell) {
  std::vector<std::string> classes;
  for (const fs::path& file : files) classes.push_back(class_of(file));
  detail::Connection connection(address);
  connection.offer(UID_VerificationSOPClass, detail::uncompressed_syntaxes());
  for (const std::string& sop_class : classes)
    connection.offer(sop_class, detail::uncompressed_syntaxes());
  connection.setDatasetConversionMode(OFTrue);
  connection.connect();
  connection.check_answers();
  for (std::size_t i = 0; i < files.size(); ++i) {
    store(connection, files[i], classes[i]);
    tell(double(i + 1) / double(files.size()));
  }
  connection.close();
}

}  // namespace

void send_to_archive(const ArchiveAddress& address, const std::vector<fs::path>& files,
                     const Progress& progress) {
  address.validate();
  detail::run_session(address, "sending to " + address.ae_title, progress,
                      [&](const detail::TellFraction& tell) -> std::vector<std::int64_t> {
                        send(address, files, tell);
                        return {std::int64_t(files.size())};
                      });
}

}  // namespace angio::dicom
