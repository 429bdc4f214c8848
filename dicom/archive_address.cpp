#include <algorithm>
#include <cctype>
#include <charconv>

#include "core/error.hpp"
#include "dicom/archive.hpp"

namespace angio::dicom {
namespace {

constexpr std::string_view kScheme = "pacs://";
constexpr std::size_t kMaxTitleLength = 16;  ///< of an AE (PS3.5 6.2)
constexpr std::size_t kMaxUidLength = 64;

[[noreturn]] void refuse(const std::string& problem) { throw Error(ExitCode::usage, problem); }

void check_title(const std::string& title, const char* whose) {
  const bool is_plain = std::all_of(title.begin(), title.end(), [](unsigned char c) {
    return c >= 0x20 && c < 0x7f && c != '\\';
  });
  if (title.empty() || title.size() > kMaxTitleLength || !is_plain ||
      title.find_first_not_of(' ') == std::string::npos)
    refuse(std::string("the application entity title of ") + whose +
           " has to be 1 to 16 plain characters");
}

std::string checked_uid(const std::string& text) {
  const bool is_uid = !text.empty() && text.size() <= kMaxUidLength &&
                      text.find_first_not_of("0123456789.") == std::string::npos;
  if (!is_uid)
    refuse(
        "the address of a scan needs UIDs of digits and dots. Give "
        "pacs://AET@HOST:PORT/STUDY_UID or .../STUDY_UID/SERIES_UID");
  return text;
}

}  // namespace

void ArchiveAddress::validate() const {
  check_title(ae_title, "the archive");
  check_title(our_ae_title, "this program (--calling)");
  if (host.empty() || port < 1 || port > 65535)
    refuse("an archive's address needs a host and a port from 1 to 65535, as AET@HOST:PORT");
  if (!(timeout_s >= 1.0 && timeout_s <= 3600.0))
    refuse("--timeout has to be from 1 to 3600 seconds");
}

ArchiveAddress parse_archive_address(const std::string& text) {
  const std::size_t at = text.find('@'), colon = text.rfind(':');
  if (at == std::string::npos || colon == std::string::npos || colon < at)
    refuse(text + " is no archive's address. Give AET@HOST:PORT, as PACS@192.168.0.7:104");
  ArchiveAddress address;
  address.ae_title = text.substr(0, at);
  address.host = text.substr(at + 1, colon - at - 1);
  if (address.host.size() > 2 && address.host.front() == '[' && address.host.back() == ']')
    address.host = address.host.substr(1, address.host.size() - 2);
  const char *begin = text.data() + colon + 1, *end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(begin, end, address.port);
  if (error != std::errc() || rest != end) address.port = 0;
  address.validate();
  return address;
}

bool is_archive_location(const std::string& text) { return text.starts_with(kScheme); }

ArchiveLocation parse_archive_location(const std::string& text) {
  const std::string rest = text.substr(std::min(kScheme.size(), text.size()));
  const std::size_t slash = rest.find('/');
  if (!is_archive_location(text) || slash == std::string::npos)
    refuse(
        "the address of a scan in an archive is pacs://AET@HOST:PORT/STUDY_UID or "
        "pacs://AET@HOST:PORT/STUDY_UID/SERIES_UID");
  ArchiveLocation location;
  location.address = parse_archive_address(rest.substr(0, slash));
  const std::string uids = rest.substr(slash + 1);
  const std::size_t between = uids.find('/');
  location.query.study_uid = checked_uid(uids.substr(0, between));
  if (between != std::string::npos)
    location.query.series_uid = checked_uid(uids.substr(between + 1));
  return location;
}

}  // namespace angio::dicom
