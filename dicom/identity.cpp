#include "dicom/identity.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <array>

namespace angio::dicom {
namespace {

constexpr std::size_t kMaxNameLength = 64;  ///< of PN and LO (PS3.5 6.2)

/// Without what separates a name's components or values; whole UTF-8 characters only.
std::string as_name(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char c) {
        return c == '^' || c == '=' || c == '\\' || static_cast<unsigned char>(c) < 0x20;
      },
      ' ');
  if (text.size() <= kMaxNameLength) return text;
  std::size_t end = kMaxNameLength;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  return text.substr(0, end);
}

}  // namespace

std::string hashed_uid(const std::string& text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  EVP_Digest(text.data(), text.size(), digest.data(), &length, EVP_sha256(), nullptr);
  std::string digits;
  std::array<unsigned char, 16> number{};
  std::copy_n(digest.begin(), number.size(), number.begin());
  bool rest = true;
  while (rest) {  // division by ten, digit by digit of base 256
    unsigned int remainder = 0;
    rest = false;
    for (unsigned char& byte : number) {
      const unsigned int value = remainder * 256u + byte;
      byte = static_cast<unsigned char>(value / 10u);
      remainder = value % 10u;
      rest = rest || byte != 0;
    }
    digits.insert(digits.begin(), char('0' + remainder));
  }
  return "2.25." + digits;
}

StudyIdentity anonymous_identity(const std::string& case_name, const std::string& seed) {
  StudyIdentity identity;
  identity.patient_name = identity.patient_id = as_name(case_name);
  identity.study_uid = hashed_uid(seed + "study");
  identity.frame_of_reference_uid = hashed_uid(seed + "frame of reference");
  return identity;
}

}  // namespace angio::dicom
