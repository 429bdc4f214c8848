#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "dicom/archive.hpp"

namespace angio::dicom {
namespace {

TEST(ArchiveAddress, IsTitleHostAndPort) {
  const ArchiveAddress address = parse_archive_address("PACS@radiology.example:11112");
  EXPECT_EQ(address.ae_title, "PACS");
  EXPECT_EQ(address.host, "radiology.example");
  EXPECT_EQ(address.port, 11112);
  EXPECT_EQ(parse_archive_address("A B@[::1]:104").host, "::1");
}

TEST(ArchiveAddress, OthersAreAUsageError) {
  for (const char* text :
       {"", "PACS", "PACS@host", "@host:104", "PACS@:104", "PACS@host:0", "PACS@host:70000",
        "PACS@host:10x", "SEVENTEEN-LETTERS@host:104", "host:104", "P\\S@host:104"}) {
    try {
      (void)parse_archive_address(text);
      FAIL() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code(), ExitCode::usage) << text;
    }
  }
}

TEST(ArchiveLocation, HasAStudyAndMaybeASeries) {
  const ArchiveLocation whole = parse_archive_location("pacs://PACS@host:104/1.2.3");
  EXPECT_EQ(whole.query.study_uid, "1.2.3");
  EXPECT_EQ(whole.query.series_uid, "");
  EXPECT_EQ(parse_archive_location("pacs://PACS@host:104/1.2.3/4.5").query.series_uid, "4.5");
  EXPECT_TRUE(is_archive_location("pacs://x"));
  EXPECT_FALSE(is_archive_location("/pacs/x"));
  for (const char* text : {"pacs://PACS@host:104", "pacs://PACS@host:104/", "pacs://x/1.2",
                           "pacs://PACS@host:104/one", "pacs://PACS@host:104/1.2/"})
    EXPECT_THROW((void)parse_archive_location(text), Error) << text;
}

TEST(ArchiveAddress, TimeoutIsWithinItsRange) {
  ArchiveAddress address = parse_archive_address("PACS@host:104");
  EXPECT_NO_THROW(address.validate());
  for (const double timeout : {0.0, -1.0, 4000.0, std::nan("")}) {
    address.timeout_s = timeout;
    EXPECT_THROW(address.validate(), Error) << timeout;
  }
}

}  // namespace
}  // namespace angio::dicom
