#include "segmentation/detail/dicom_load.hpp"

#include <dcmtk/dcmdata/dcdicdir.h>
#include <dcmtk/dcmdata/dcdict.h>
#include <dcmtk/dcmdata/dcistrmb.h>
#include <dcmtk/oflog/oflog.h>

#include <cstring>
#include <fstream>
#include <limits>
#include <mutex>

#include "core/child_process.hpp"
#include "core/error.hpp"

namespace angio::segmentation::detail {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kHeadBytes = 132;

bool head_may_be_dicom(const std::vector<char>& head) {
  if (head.size() >= kHeadBytes && std::memcmp(head.data() + 128, "DICM", 4) == 0) return true;
  if (head.size() < 8) return false;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(head[i]); };
  const bool little = (byte(0) == 0x02 || byte(0) == 0x08) && byte(1) == 0;
  const bool big = byte(0) == 0 && (byte(1) == 0x02 || byte(1) == 0x08);
  return (little && byte(3) == 0) || (big && byte(2) == 0);
}

bool is_dicom_directory(DcmFileFormat& file) {
  OFString uid;
  DcmMetaInfo* meta = file.getMetaInfo();
  return meta && meta->findAndGetOFString(DCM_MediaStorageSOPClassUID, uid).good() &&
         uid == UID_MediaStorageDirectoryStorage;
}

/// "A\B\C" as its parts.
std::vector<std::string> split_file_id(const OFString& id) {
  std::vector<std::string> names(1);
  for (const char c : id) {
    if (c == '\\')
      names.emplace_back();
    else
      names.back() += c;
  }
  for (auto& name : names)
    while (!name.empty() && (name.back() == ' ' || name.back() == '\0')) name.pop_back();
  return names;
}

std::vector<std::vector<std::string>> file_ids_of(DcmFileFormat& file) {
  std::vector<std::vector<std::string>> ids;
  DcmSequenceOfItems* records = nullptr;
  if (file.getDataset()->findAndGetSequence(DCM_DirectoryRecordSequence, records).bad() || !records)
    return ids;
  DcmObject* record = nullptr;
  while ((record = records->nextInContainer(record)) != nullptr) {
    auto* item = dynamic_cast<DcmItem*>(record);
    OFString type;
    OFString id;
    if (!item || item->findAndGetOFString(DCM_DirectoryRecordType, type).bad() || type != "IMAGE" ||
        item->findAndGetOFStringArray(DCM_ReferencedFileID, id).bad() || id.empty())
      continue;
    ids.push_back(split_file_id(id));
  }
  return ids;
}

}  // namespace

void silence_dcmtk() {
  static std::once_flag once;
  std::call_once(once, [] { OFLog::configure(OFLogger::OFF_LOG_LEVEL); });
}

void prepare_dcmtk() {
  silence_dcmtk();
  dcmDataDict.rdlock();  // reads it, where nobody has before
  dcmDataDict.rdunlock();
}

const ZipArchive& DicomLoader::archive(const fs::path& path) {
  if (!archive_ || archive_path_ != path) {
    archive_ = std::make_unique<ZipArchive>(path);
    archive_path_ = path;
  }
  return *archive_;
}

bool DicomLoader::may_be_dicom(const DicomSource& source) {
  if (source.entry >= 0)
    return head_may_be_dicom(archive(source.path).read(source.entry, kHeadBytes));
  std::ifstream file(source.path, std::ios::binary);
  std::vector<char> head(kHeadBytes);
  file.read(head.data(), std::streamsize(head.size()));
  head.resize(std::size_t(file.gcount()));
  return head_may_be_dicom(head);
}

OFCondition DicomLoader::load(const DicomSource& source, Uint32 read_limit_bytes,
                              DcmFileFormat& file) {
  silence_dcmtk();
  if (source.entry < 0)
    return file.loadFile(source.path.c_str(), EXS_Unknown, EGL_noChange, read_limit_bytes,
                         ERM_autoDetect);
  bytes_ = archive(source.path).read(source.entry, std::numeric_limits<std::uint64_t>::max());
  DcmInputBufferStream stream;
  stream.setBuffer(bytes_.data(), offile_off_t(bytes_.size()));
  stream.setEos();
  file.transferInit();
  const OFCondition status = file.read(stream, EXS_Unknown, EGL_noChange, DCM_MaxReadLength);
  file.transferEnd();
  return status;
}

std::vector<std::vector<std::string>> read_dicom_directory(const fs::path& path) {
  std::vector<std::vector<std::string>> ids;
  prepare_dcmtk();
  ChildLimits limits;
  limits.reach.read = {path};
  const ChildResult result = run_guarded(
      limits,
      [&](ChildOutput& output) {
        DicomLoader loader;
        DcmFileFormat file;
        const DicomSource source{path, -1};
        std::vector<std::vector<std::string>> found;
        if (loader.may_be_dicom(source) && loader.load(source, DCM_MaxReadLength, file).good() &&
            is_dicom_directory(file))
          found = file_ids_of(file);
        output.put(std::uint64_t(found.size()));
        for (const auto& names : found) {
          output.put(std::uint64_t(names.size()));
          for (const auto& name : names) output.put(name);
        }
      },
      [&](ChildInput& input) {
        std::uint64_t count = 0;
        input.get(count);
        for (std::uint64_t i = 0; i < count; ++i) {
          std::uint64_t name_count = 0;
          input.get(name_count);
          auto& names = ids.emplace_back();
          for (std::uint64_t n = 0; n < name_count; ++n) input.get(names.emplace_back());
        }
      });
  if (result.end != ChildEnd::done)
    ids.clear();  // what is wrong with it, its header's reader tells
  return ids;
}

}  // namespace angio::segmentation::detail
