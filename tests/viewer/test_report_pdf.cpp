#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdlib>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/text.hpp"
#include "testing/temporary_folder.hpp"
#include "testing/viewer/png.hpp"
#include "viewer/detail/chart.hpp"
#include "viewer/detail/page_blocks.hpp"
#include "viewer/detail/picture.hpp"
#include "viewer/report_pdf.hpp"

namespace angio::viewer {
namespace {
using detail::BlockKind;
using detail::PageBlock;
using testing::HasSubstr;
using testing::Not;

std::string figure(int width, int height, const std::string& caption) {
  detail::Picture picture = detail::blank_picture(width, height);
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) picture.rgb[i] = std::uint8_t(i % 251);
  return "<figure><img width=\"" + std::to_string(width) + "\" alt=\"" + caption +
         "\" src=\"data:image/png;base64," + formats::base64(detail::png_bytes(picture)) +
         "\"><figcaption>" + caption + "</figcaption></figure>\n";
}

std::string chart() {
  detail::Chart curve;
  curve.title = "Diameter";
  curve.x_label = "Distance [mm]";
  curve.y_label = "Diameter [mm]";
  curve.series.push_back({"before", {0, 1, 2, 3}, {3, 1, 2, 3}});
  return detail::svg_for_page(curve);
}

/// As write_report lays a page out.
std::string page() {
  return "<!DOCTYPE html><html><head><style>p{color:red}</style></head><body><header><h1>A &amp; B"
         "</h1></header><main>\n<div class=\"notice\"><strong>Not for</strong> clinical use.</div>"
         "<div class=\"cards\"><div class=\"card\"><div class=\"value\">58 % → 12 %</div><div "
         "class=\"label\">Diameter stenosis</div><div class=\"detail\">reference 3.00 "
         "mm</div></div>"
         "</div><section><h2>Pictures</h2><div class=\"row\">" +
         figure(60, 40, "first") + figure(60, 40, "second") + "</div></section><h3>Curve</h3>" +
         chart() +
         "<section id=\"scene\"><p>only on a screen</p></section><script>let unseen;</script>"
         "<div class=\"table\"><h3>Lesion</h3><table><tr><th scope=\"row\">MLD</th><td>1.20 mm</td>"
         "</tr></table></div><ul><li>one</li><li>two</li></ul></main></body></html>";
}

std::vector<PageBlock> of_kind(BlockKind kind) {
  std::vector<PageBlock> found;
  for (const PageBlock& block : detail::read_page(page()))
    if (block.kind == kind) found.push_back(block);
  return found;
}

TEST(PageBlocks, AreThePagesWordsInTheirOrder) {
  EXPECT_EQ(of_kind(BlockKind::title).at(0).text, "A & B");
  EXPECT_EQ(of_kind(BlockKind::note).at(0).text, "Not for clinical use.");
  const PageBlock card = of_kind(BlockKind::card).at(0);
  EXPECT_EQ(card.value, "58 % → 12 %");
  EXPECT_EQ(card.text, "Diameter stenosis");
  EXPECT_EQ(card.detail, "reference 3.00 mm");
  const auto rows = of_kind(BlockKind::table).at(0).rows;
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].at(0).text, "MLD");
  EXPECT_TRUE(rows[0].at(0).is_name);
  EXPECT_EQ(rows[0].at(1).text, "1.20 mm");
  EXPECT_EQ(of_kind(BlockKind::bullet).size(), 2u);
  for (const PageBlock& block : detail::read_page(page())) {
    EXPECT_THAT(block.text, Not(HasSubstr("only on a screen")));
    EXPECT_THAT(block.text, Not(HasSubstr("unseen")));
    EXPECT_THAT(block.text, Not(HasSubstr("color")));
  }
}

TEST(PageBlocks, KeepPicturesByteForByteAndOneOfEachChart) {
  const auto pictures = of_kind(BlockKind::picture);
  ASSERT_EQ(pictures.size(), 2u);
  EXPECT_EQ(pictures[1].text, "second");
  EXPECT_EQ(pictures[1].columns, 3);
  EXPECT_EQ(angio::test::picture_from_png(pictures[0].bytes).width, 60);
  EXPECT_EQ(of_kind(BlockKind::drawing).size(), 1u) << "not the phone's";
}

TEST(PageBlocks, EndWhereThePageWasCutShort) {
  const std::string whole = page();
  for (std::size_t length = 0; length < whole.size(); length += 97)
    EXPECT_NO_THROW(detail::read_page(whole.substr(0, length))) << length;
}

TEST(ReportPdf, SaysWhatThePageSays) {
  const test::TemporaryFolder folder;
  const std::string pdf = report_pdf(page(), "A & B", "1.2.3");
  EXPECT_EQ(pdf.substr(0, 5), "%PDF-");
  EXPECT_NE(pdf.find("/CreationDate (19000101000000Z)"), std::string::npos);
  write_text_atomically(folder / "a.pdf", pdf);
  if (std::system("command -v pdftotext > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "pdftotext (package poppler-utils) is not installed";
  const std::string file = (folder / "a.pdf").string();
  ASSERT_EQ(std::system(("pdftotext -layout " + file + " " + file + ".txt").c_str()), 0);
  const std::string text = read_text(file + ".txt");
  for (const char* part : {"A & B", "Not for clinical use", "58 % → 12 %", "second", "1.20 mm",
                           "Distance [mm]", "two"})
    EXPECT_THAT(text, HasSubstr(part));
}

TEST(ReportPdf, HasTheReportsTitle) {
  EXPECT_NE(report_pdf(page(), "0123abcd", "1").find("/Title (A & B, case 0123abcd)"),
            std::string::npos);
  EXPECT_NE(report_pdf(page(), "A & B", "1").find("/Title (A & B)"), std::string::npos);
}

TEST(ReportPdf, IsTheSameBytesEachTime) {
  EXPECT_EQ(report_pdf(page(), "A", "1"), report_pdf(page(), "A", "1"));
}

TEST(ReportPdf, GoesOnOverAsManySheetsAsItNeeds) {
  std::string many = "<html><body>";
  for (int i = 0; i < 30; ++i) many += figure(300, 200, "picture " + std::to_string(i));
  const std::string pdf = report_pdf(many + "</body></html>", "A", "1");
  std::size_t sheets = 0;
  for (std::size_t at = pdf.find("/Type /Page %"); at != std::string::npos;
       at = pdf.find("/Type /Page %", at + 1))
    ++sheets;
  EXPECT_EQ(sheets, 15u) << "two of that height on each";
}

/// Without compression: what the sheets' streams say.
std::string inflated(const std::string& pdf) {
  std::string all;
  for (std::size_t at = pdf.find("stream\n"); at != std::string::npos;
       at = pdf.find("stream\n", at + 1)) {
    const std::size_t begin = at + 7, end = pdf.find("endstream", begin);
    std::string text(1u << 20, '\0');
    uLongf size = uLongf(text.size());
    if (uncompress(reinterpret_cast<Bytef*>(text.data()), &size,
                   reinterpret_cast<const Bytef*>(pdf.data() + begin), uLong(end - begin)) == Z_OK)
      all += text.substr(0, size);
  }
  return all;
}

TEST(ReportPdf, ADrawingEndsWhereItsWindowEnds) {
  // As the strip of sections does: a box that is far larger than the view.
  const std::string pdf = report_pdf(
      "<html><body><figure><svg viewBox=\"0 0 10 10\"><rect x=\"-900\" y=\"-900\" width=\"1800\" "
      "height=\"1800\" fill=\"#123\"/></svg></figure></body></html>",
      "A", "1");
  const std::string drawn = inflated(pdf);
  const std::size_t fill = drawn.find("0.0666667 0.133333 0.2 rg");
  ASSERT_NE(fill, std::string::npos) << drawn;
  EXPECT_NE(drawn.rfind(" re W n", fill), std::string::npos) << drawn;
}

TEST(ReportPdf, AHeadingThatNothingFollowsIsLeftOut) {
  const std::string filler = figure(300, 200, "one") + figure(300, 200, "two");
  const auto sheet_count = [](const std::string& pdf) {
    std::size_t sheets = 0;
    for (std::size_t at = pdf.find("/Type /Page %"); at != std::string::npos;
         at = pdf.find("/Type /Page %", at + 1))
      ++sheets;
    return sheets;
  };
  const std::string begin = "<html><body>" + filler, end = "</body></html>";
  EXPECT_EQ(sheet_count(report_pdf(begin + "<h2>Below</h2>" + end, "A", "1")), 1u)
      << "nothing comes behind it";
  EXPECT_EQ(
      sheet_count(report_pdf(begin + "<h2>Below</h2>" + figure(300, 200, "x") + end, "A", "1")),
      2u);
}

TEST(ReportPdf, RefusesADamagedPicture) {
  EXPECT_THROW(report_pdf("<html><body><figure><img alt=\"x\" src=\"data:image/png;base64,AAAA\">"
                          "</figure></body></html>",
                          "A", "1"),
               InputError);
}

}  // namespace
}  // namespace angio::viewer
