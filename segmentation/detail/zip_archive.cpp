#include "segmentation/detail/zip_archive.hpp"

#include <zip.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <utility>

#include "core/error.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr zip_int64_t kMaxEntryCount = 200000;
/// Deflate packs nothing tighter than this; such an archive holds no scan, but zeros.
constexpr std::uint64_t kMaxRatio = 1000;
constexpr std::uint64_t kRatioCountsFrom = std::uint64_t(1) << 26;  ///< unpacked [bytes]
constexpr std::uint64_t kMaxTotalBytes = std::uint64_t(1) << 37;

[[noreturn]] void fail(const std::string& why) {
  throw InputError("cannot read the zip archive (" + why +
                   "). Unpack it, and give the folder instead");
}

}  // namespace

struct ZipArchive::Handle {
  zip_t* zip = nullptr;
};

bool is_zip_archive(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 4> head{};
  file.read(head.data(), head.size());
  return file.gcount() == 4 &&
         (std::memcmp(head.data(), "PK\3\4", 4) == 0 || std::memcmp(head.data(), "PK\5\6", 4) == 0);
}

ZipArchive::ZipArchive(const std::filesystem::path& path) : handle_(std::make_unique<Handle>()) {
  int error = 0;
  handle_->zip = zip_open(path.c_str(), ZIP_RDONLY, &error);
  if (!handle_->zip) fail("it is truncated or damaged");
}

ZipArchive::~ZipArchive() {
  if (handle_->zip) zip_discard(handle_->zip);
}

std::vector<ZipArchive::Entry> ZipArchive::entries() const {
  const zip_int64_t count = zip_get_num_entries(handle_->zip, 0);
  if (count > kMaxEntryCount) fail("it holds more than 200000 files");
  std::vector<std::pair<std::string, Entry>> named;
  std::uint64_t packed = 0;
  std::uint64_t unpacked = 0;
  for (zip_int64_t i = 0; i < count; ++i) {
    zip_stat_t stat;
    zip_stat_init(&stat);
    if (zip_stat_index(handle_->zip, zip_uint64_t(i), 0, &stat) != 0 ||
        !(stat.valid & ZIP_STAT_SIZE) || !(stat.valid & ZIP_STAT_NAME))
      fail("its list of files is damaged");
    const std::string name = stat.name;
    if (name.empty() || name.back() == '/') continue;
    if ((stat.valid & ZIP_STAT_ENCRYPTION_METHOD) && stat.encryption_method != ZIP_EM_NONE)
      fail("it is locked with a password");
    named.push_back({name, {i, stat.size}});
    if (stat.size > kMaxTotalBytes) fail("it would unpack to more than 128 GiB");
    unpacked += stat.size;
    packed += (stat.valid & ZIP_STAT_COMP_SIZE) ? stat.comp_size : 0;
    if (unpacked > kMaxTotalBytes) fail("it would unpack to more than 128 GiB");
  }
  if (unpacked > kRatioCountsFrom && unpacked / kMaxRatio > packed)
    fail("it would unpack to over 1000 times its size, as no scan does");
  std::sort(named.begin(), named.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first, a.second.index) < std::pair(b.first, b.second.index);
  });
  std::vector<Entry> found;
  for (const auto& [name, entry] : named) found.push_back(entry);
  return found;
}

std::vector<char> ZipArchive::read(std::int64_t index, std::uint64_t limit) const {
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_stat_index(handle_->zip, zip_uint64_t(index), 0, &stat) != 0)
    fail("its list of files is damaged");
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(
      zip_fopen_index(handle_->zip, zip_uint64_t(index), 0), zip_fclose);
  if (!file) fail("a file in it cannot be unpacked");
  // A size is but a claim: memory is taken as the bytes come.
  constexpr std::size_t kStep = std::size_t(16) << 20;
  const auto size = std::size_t(std::min<std::uint64_t>(stat.size, limit));
  std::vector<char> bytes;
  for (std::size_t got = 0; got < size;) {
    bytes.resize(std::min(size, std::max(bytes.size(), got + kStep)));
    const zip_int64_t count = zip_fread(file.get(), bytes.data() + got, bytes.size() - got);
    if (count <= 0) fail("a file in it is truncated or damaged");
    got += std::size_t(count);
  }
  return bytes;
}

}  // namespace angio::segmentation::detail
