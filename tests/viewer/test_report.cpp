#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/text.hpp"
#include "testing/viewer/png.hpp"
#include "testing/viewer/report_content.hpp"
#include "testing/viewer/shapes.hpp"
#include "viewer/detail/case_headline.hpp"
#include "viewer/detail/figure.hpp"
#include "viewer/detail/picture.hpp"
#include "viewer/detail/section_slider.hpp"
#include "viewer/detail/tables.hpp"
#include "viewer/report.hpp"

namespace angio::viewer {
namespace {
namespace fs = std::filesystem;
using test::make_report_content;
using test::TemporaryFolder;
using testing::HasSubstr;

std::map<std::string, std::string> read_folder(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder))
    files[entry.path().filename().string()] = read_text(entry.path());
  return files;
}

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
  return found;
}

/// Whether a page holds some words; unlike gmock's matcher it does not print the page.
bool has(const std::string& page, const std::string& words) {
  return page.find(words) != std::string::npos;
}

/// A page without its pictures' bytes, and without the scene's own scripts.
std::string without_pictures(std::string page) {
  const std::string begin = "src=\"data:image/png;base64,";
  for (auto at = page.find(begin); at != std::string::npos; at = page.find(begin, at)) {
    at += 5;
    page.erase(at, page.find('"', at) - at);
  }
  for (const std::string script : {"<script type=\"text/plain\" id=\"scene-program\">",
                                   "<script type=\"text/plain\" id=\"scene-data\">",
                                   "<script>\n// Opens", "<script>\n// Walks"})
    if (const auto at = page.find(script); at != std::string::npos)
      page.erase(at, page.find("</script>", at) + 9 - at);
  return page;
}

using Files = std::map<std::string, std::string>;

void expect_tells_what_a_reader_looks_for(const std::string& page) {
  for (const char* words :
       {"Synthetic case",
        "angio 0.0.0-test",
        "Not for clinical use",
        "60 → 20 %",
        "1.20 → 2.40 mm",
        "at peak 2.90 mm, acute gain 1.20 mm, two runs within 0.010 mm",
        "18 % of the lumen at peak, two runs within 0.3 points",
        "2.395 to 2.405 mm",
        "0.54 mm",
        "3.00 × 12 mm",
        "8.0 atm",
        "Before",
        "At peak, 8.0 atm",
        "After",
        "Diameter along the vessel",
        "reference 3.00 mm",
        "MLD before 1.20 mm",
        "MLD after 2.40 mm",
        "MLD at peak 2.90 mm",
        "Balloon pressure",
        "pressure [atm]",
        "time [s]",
        "Minimal lumen area (MLA)",
        "4.52 mm²",
        "segmentation",
        "12.3 s",
        "0.72 → 0.95",
        "after 0.93 to 0.97; 0.80 and less limits flow",
        "FFR before 0.72",
        "FFR after 0.95",
        "not a measurement",
        "148 mL/min",
        "25.1 mmHg",
        "512 MiB",
        "LPS",
        "240 kPa",
        "Place along the vessel",
        "0.0 mm from the tightest place. Diameter before 1.2",
        "rated burst pressure, 14.0 atm",
        "0.06 mm below what its chart says",
        "Working view",
        "shortens the lesion by 0 %; other parts of the vessel overlap 0 % of it",
        "Before, AP",
        "After, AP"})
    EXPECT_TRUE(has(page, words)) << words;
}

void expect_needs_nothing_but_itself(const std::string& page) {
  for (const char* reference : {"http:", "https:", "<link", "<script", "@import", "url("})
    EXPECT_FALSE(has(without_pictures(page), reference)) << reference;
  EXPECT_EQ(count(page, "src="), count(page, "src=\"data:image/png;base64,"));
}

void expect_shows_every_picture_beside_it(const Files& files) {
  const std::string& page = files.at("index.html");
  EXPECT_EQ(count(page, "<img "), files.size() - 2);  // all but the page and corrections.svg
  EXPECT_EQ(count(page, "<svg "),
            23u);  // eleven, for wide and for narrow pages, and a section
  for (const char* name :
       {"tree.png", "close_up_1.png", "close_up_2.png", "close_up_3.png", "contact.png",
        "projection_axial.png", "projection_coronal.png", "projection_sagittal.png",
        "angiogram_1.png", "angiogram_2.png", "straightened.png", "slice_axial.png",
        "slice_coronal.png", "slice_sagittal.png", "cross_sections.png"})
    EXPECT_EQ(files.count(name), 1u) << name;
}

int count_blue(const std::string& png) {
  const detail::Picture picture = angio::test::picture_from_png(png);
  int blue = 0;
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3)
    blue += picture.rgb[i + 2] > picture.rgb[i] + 30 ? 1 : 0;
  return blue;
}

void expect_pictures_show_something(const Files& files) {
  for (const auto& [name, bytes] : files) {
    if (!name.ends_with(".png")) continue;
    const detail::Picture picture = angio::test::picture_from_png(bytes);
    const auto [low, high] = std::minmax_element(picture.rgb.begin(), picture.rgb.end());
    EXPECT_GT(*high - *low, 100) << name;
  }
  // The balloon, blue, is seen through the lumen's wall, and is large at peak.
  EXPECT_GT(count_blue(files.at("close_up_1.png")), 1000);
  EXPECT_GT(count_blue(files.at("close_up_2.png")), 2 * count_blue(files.at("close_up_1.png")));
}

void expect_elements_close_in_order(const std::string& page) {
  const std::string text = without_pictures(page);
  std::vector<std::string> open;
  for (auto at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    const auto end = text.find('>', at);
    ASSERT_NE(end, std::string::npos);
    const std::string tag = text.substr(at + 1, end - at - 1);
    const std::string name = tag.substr(0, tag.find_first_of(" \n"));
    if (tag.ends_with("/") || name == "!DOCTYPE" || name == "meta" || name == "img" ||
        name == "input")
      continue;
    if (name.starts_with("/")) {
      ASSERT_FALSE(open.empty()) << name;
      ASSERT_EQ("/" + open.back(), name);
      open.pop_back();
    } else {
      open.push_back(name);
    }
  }
  EXPECT_TRUE(open.empty());
}

TEST(Report, IsOneCompletePageAndTheSameBytesEveryTime) {
  const TemporaryFolder folder_a, folder_b;
  ReportContent content = make_report_content();
  content.doubts = {{"the simulation", {"no stenosis over 30 % was found"}},
                    {"the image", {"it is clipped"}}};
  write_report(folder_a.path(), content);
  const Files files = read_folder(folder_a.path());
  expect_tells_what_a_reader_looks_for(files.at("index.html"));
  expect_needs_nothing_but_itself(files.at("index.html"));
  expect_shows_every_picture_beside_it(files);
  expect_pictures_show_something(files);
  expect_elements_close_in_order(files.at("index.html"));

  write_report(folder_b.path(), content);
  const Files again = read_folder(folder_b.path());
  ASSERT_EQ(files.size(), again.size());
  for (const auto& [name, bytes] : files) EXPECT_TRUE(bytes == again.at(name)) << name;
}

TEST(Report, TheResultComesFirstThenWhatToDoubtInItThenRemarks) {
  const TemporaryFolder folder;
  ReportContent content = make_report_content();
  content.doubts = {{"the simulation", {"off balance"}}, {"lines", {}}, {"the image", {"a", "b"}}};
  write_report(folder.path(), content);
  const std::string page = read_text(folder / "index.html");
  const auto at = [&](const char* text) {
    EXPECT_EQ(count(page, text), 1u) << text;
    return page.find(text);
  };
  EXPECT_LT(at("Minimal lumen diameter</div>"), at("off balance"));
  EXPECT_LT(at("off balance"), at("2 on the image"));
  EXPECT_LT(at("2 on the image"), at("<h3>On the image</h3><ul><li>a</li><li>b</li></ul>"));
  EXPECT_FALSE(has(page, "On lines"));
}

TEST(Report, EscapesEverythingThatItIsGiven) {
  const TemporaryFolder folder;
  const std::string evil = "<script>alert('1')</script> & \"co\"";
  ReportContent content;
  content.title = evil;
  content.version = evil;
  content.doubts = {{evil, {evil}}, {evil, {evil}}};
  content.lumen = test::make_tube({});
  content.time_series = {{"time_s", "phase", "pressure_atm"},
                         {{"0", evil, "1"}, {"9", evil, "2"}, {"10", "rest", "2"}}};
  content.metrics_json = R"({"lesion":{"reference_rule":"<script>alert('1')</script>",
      "<script>":1}, "balloon":{"material":"<script>"}})";
  content.run_json = R"({"device":"<script>","stages":{"<script>":{"status":"<script>"}}})";
  write_report(folder.path(), content);
  const std::string page = without_pictures(read_text(folder / "index.html"));
  EXPECT_FALSE(has(page, "<script"));
  EXPECT_FALSE(has(page, "alert('1')"));
  EXPECT_GE(count(page, "&lt;script&gt;"), 8u);
}

TEST(CaseHeadline, SaysWhatTheCaseIs) {
  const auto headline = [](const std::string& json, const char* kind) {
    return detail::case_headline(detail::Metrics(json), kind);
  };
  const std::string balloon = R"("balloon":{"nominal_diameter_mm":3,"length_mm":12})";
  EXPECT_EQ(headline(R"({"status":"done","lesion":{"diameter_stenosis_percent":59.6,
                        "centerline_id":1},)" +
                         balloon + "}",
                     "volume"),
            "Scan: stenosis of 60 % on line 1, 3.00 × 12 mm balloon");
  EXPECT_EQ(headline(R"({"lesion":{"diameter_stenosis_percent":80,
                        "stenosis_at_least_percent":75,"centerline_id":0}})",
                     ""),
            "Stenosis of at least 75 % on line 0");
  EXPECT_EQ(headline(R"({"status":"no_lesion",)" + balloon + "}", "surface"),
            "Surface: no certain stenosis, trial of a 3.00 × 12 mm balloon");
  EXPECT_EQ(headline(R"({"status":"no_lesion",
                        "balloon":{"nominal_diameter_mm":16.5,"length_mm":16.5}})",
                     "surface"),
            "Surface: no certain stenosis, trial of a 16.50 × 16.5 mm balloon");
  EXPECT_EQ(headline(R"({"status":"no_lesion"})", "run"), "X-ray frames: no certain stenosis");
  EXPECT_EQ(headline(R"({"status":"not_determined"})", "volume"), "");
}

TEST(Report, ItsTitleIsWhatTheCaseIsAndItsNameStandsBelow) {
  const TemporaryFolder folder;
  ReportContent content;
  content.title = "0123 <b>";
  content.input_kind = "phantom";
  content.lumen = test::make_tube({});
  content.metrics_json = R"({"lesion":{"diameter_stenosis_percent":60,"centerline_id":2}})";
  write_report(folder.path(), content);
  const std::string page = read_text(folder / "index.html");
  EXPECT_TRUE(has(page, "<h1>Phantom: stenosis of 60 % on line 2</h1>"));
  EXPECT_TRUE(has(page, "Case 0123 &lt;b&gt; · "));
}

TEST(Report, SurfaceWithoutScanStenosisOrDilationIsReportedToo) {
  const TemporaryFolder folder;
  write_text_atomically(folder / "contact.png", "of an earlier report");
  ReportContent content;
  content.title = "surface";
  content.lumen = test::make_tube({.depth = 0.0});
  content.tree.paths = {test::make_path({.depth = 0.0})};
  content.lesion_abscissa_mm = 10.0;
  content.metrics_json = R"({"lesion":{"mld_mm":3.0,"diameter_stenosis_percent":null}})";
  write_report(folder.path(), content);
  const auto files = read_folder(folder.path());
  EXPECT_EQ(files.count("tree.png"), 1u);
  EXPECT_EQ(files.count("cross_sections.png"), 1u);
  EXPECT_EQ(files.count("contact.png"), 0u);
  EXPECT_EQ(files.count("projection_axial.png"), 0u);
  EXPECT_TRUE(has(files.at("index.html"), ">3.00 mm<"));
  EXPECT_FALSE(has(without_pictures(files.at("index.html")), "wire and scan"));
}

TEST(Straightened, FillsItsSheetWhateverTheVesselsShape) {
  const auto picture_of = [](double radius, double length) {
    const test::TubeShape shape{.radius_mm = radius, .length_mm = length, .depth = 0.0};
    ReportContent content;
    content.lumen = test::make_tube(shape);
    content.tree.paths = {test::make_path(shape)};
    content.lesion_abscissa_mm = 0.5 * length;
    content.after.abscissa_mm = {0.0, length};
    return detail::draw_straightened(content).at(0).picture;
  };
  // Long and thin: above each other. Short and wide, wider than long: side by side.
  for (const auto& [radius, length] : {std::pair{1.5, 40.0}, {10.0, 60.0}, {10.0, 20.0}}) {
    const detail::Picture picture = picture_of(radius, length);
    std::size_t bare = 0;
    for (std::size_t i = 0; i < picture.rgb.size(); i += 3)
      bare += std::min({picture.rgb[i], picture.rgb[i + 1], picture.rgb[i + 2]}) > 200 ? 1U : 0U;
    EXPECT_LT(double(bare), 0.15 * double(picture.rgb.size()) / 3.0) << radius << ' ' << length;
    EXPECT_GE(picture.width, picture.height) << radius << ' ' << length;
  }
}

TEST(Cards, TellTheThroatsStandardDeviationWhereItIsKnown) {
  const auto cards = [](const std::string& lesion, const std::string& rest) {
    return detail::headline(
        detail::Metrics(R"({"lesion":{"mld_mm":1.2,"mla_mm2":1.13)" + lesion + "}" + rest + "}"));
  };
  const std::string known = R"(,"mld_sd_mm":0.052)";
  EXPECT_TRUE(has(cards(known, ""), ">1.20 ± 0.05 mm<"));
  EXPECT_TRUE(
      has(cards(known, R"(,"status":"done","result":{"mld_mm":2.4})"), ">1.20 ± 0.05 → 2.40 mm<"));
  EXPECT_TRUE(has(cards(known, ""), ">1.13 mm²<"));  // of the diameter alone
  EXPECT_TRUE(has(cards(R"(,"mld_sd_mm":null)", ""), ">1.20 mm<"));
  EXPECT_FALSE(
      has(cards(known + R"(,"resolution_mm":1.5,"stenosis_at_least_percent":50)", ""), "±"));
}

TEST(Cards, OfWhatIsNotDeterminedTellTheRangeAndNoNumberOfIt) {
  const std::string metrics = R"({"status":"not_determined","status_reason":"two runs disagree",
      "lesion":{"mld_mm":1.2,"mla_mm2":1.1,"diameter_stenosis_percent":60.0},
      "result":{"mld_mm":2.08,"mla_mm2":3.4,"diameter_stenosis_percent":30.6,"acute_gain_mm":0.88,
        "recoil_mm":0.81,"recoil_percent":28.1,"mld_range_mm":[2.08,2.23],
        "acute_gain_range_mm":[0.88,1.03],"recoil_range_percent":[22.2,28.1]},
      "flow":{"ffr_before":0.72,"ffr_before_range":[0.64,0.79],"ffr_after":0.955}})";
  const std::string cards = detail::headline(detail::Metrics(metrics));
  EXPECT_TRUE(has(cards, "1.20 → 2.08 to 2.23 mm"));
  EXPECT_TRUE(has(cards, "acute gain 0.88 to 1.03 mm"));
  EXPECT_TRUE(has(cards, "22 to 28 % of the lumen at peak"));
  EXPECT_TRUE(has(cards, "60 → not determined"));
  EXPECT_TRUE(has(cards, "0.72 → not determined"));
  EXPECT_TRUE(has(cards, "before 0.64 to 0.79"));
  EXPECT_FALSE(has(cards, "0.81 mm"));
  EXPECT_FALSE(has(cards, "uncertain"));
  const std::string notice = detail::status_notice(detail::Metrics(metrics));
  EXPECT_TRUE(has(notice, "Not determined."));
  EXPECT_TRUE(has(notice, "Two runs disagree"));
}

TEST(Cards, OfAVesselWithoutALesionAreAMereTrial) {
  const auto told = [](const std::string& status) {
    return detail::headline(detail::Metrics(
        R"({"lesion":{"mld_mm":1.2,"diameter_stenosis_percent":60},"result":{"mld_mm":1.5},"status":")" +
        status + "\"}"));
  };
  EXPECT_TRUE(has(told("no_lesion"), "Trial inflation, not a treatment."));
  EXPECT_TRUE(has(told("no_lesion"), "1.20 → 1.50 mm"));
  EXPECT_FALSE(has(told("no_lesion"), "Diameter stenosis"));  // of none there is no percentage
  EXPECT_TRUE(has(told("no_lesion"), "reference diameter"));
  EXPECT_TRUE(has(told("done"), "Diameter stenosis"));
  EXPECT_FALSE(has(told("done"), "Trial"));
  EXPECT_TRUE(
      has(detail::headline(detail::Metrics(R"({"status":"no_lesion"})")), "no balloon was tried"));
}

TEST(SiteName, IsOfTheBalloonOfAListedStenosisOrOfATrial) {
  ReportContent content;
  EXPECT_EQ(detail::site_name(content), "trial place");
  content.lesions_json = "[]";
  EXPECT_EQ(detail::site_name(content), "trial place");
  content.lesions_json = R"([{"centerline_id": 0}])";
  EXPECT_EQ(detail::site_name(content), "stenosis");
  content.moments.emplace_back();
  EXPECT_EQ(detail::site_name(content), "balloon site");
}

TEST(Cards, WithoutABalloonTellNothingOfOne) {
  const std::string cards =
      detail::headline(detail::Metrics(R"({"status":"no_lesion","lesion":{"mld_mm":4.9,"mla_mm2":20,
          "reference_diameter_mm":5.2},"peak":{"mld_mm":null},"result":{"mld_mm":null},
          "balloon":{"nominal_diameter_mm":null,"peak_pressure_atm":null}})"));
  EXPECT_TRUE(has(cards, ">4.90 mm<"));
  EXPECT_TRUE(has(cards, ">reference diameter 5.20 mm<"));
  EXPECT_TRUE(has(cards, ">Lumen diameter there<"));
  for (const char* word : {"at peak", "gain", "recoil", "Balloon", "Peak pressure", "Minimal", "–"})
    EXPECT_FALSE(has(cards, word)) << word;
}

TEST(Cards, TellBoundsOfAThroatThatIsNarrowerThanAVoxel) {
  const std::string cards = detail::headline(detail::Metrics(
      R"({"status":"done","lesion":{"mld_mm":0.57,"mla_mm2":0.4,"diameter_stenosis_percent":89.0,
          "resolution_mm":1.0,"stenosis_at_least_percent":81.2},
          "result":{"mld_mm":2.9,"mla_mm2":6.8,"diameter_stenosis_percent":44.0},
          "flow":{"ffr_before":0.2,"ffr_before_range":[0.1,0.3],"ffr_after":0.9}})"));
  EXPECT_TRUE(has(cards, "≥ 81 → 44 %"));
  EXPECT_TRUE(has(cards, "&lt; 1.00 → 2.90 mm"));
  EXPECT_TRUE(has(cards, "&lt; 0.79 → 6.80 mm²"));
  EXPECT_TRUE(has(cards, "narrower than the voxels that show it"));
  EXPECT_FALSE(has(cards, "0.57"));
  EXPECT_FALSE(has(cards, "0.10 to 0.30"));
}

TEST(Report, TheSlidersFirstSectionIsWhereTheMldIsMarked) {
  ReportContent content = make_report_content();
  content.lesion_abscissa_mm += 0.4;  // of the image; the simulated wall is narrowest elsewhere
  const auto& profile = content.before;
  const auto narrowest =
      std::min_element(profile.inscribed_diameter_mm.begin(), profile.inscribed_diameter_mm.end());
  const std::string mld = formats::fixed_text(*narrowest, 2);
  const detail::Metrics metrics(R"({"lesion":{"mld_mm":)" + std::to_string(*narrowest) + "}}");
  const std::string slider = detail::section_slider(content, metrics);
  EXPECT_TRUE(has(slider.substr(slider.find("id=\"section-text\"")),
                  "0.0 mm from the tightest place. Diameter before " + mld))
      << slider.substr(slider.find("id=\"section-text\""), 200);
}

TEST(Report, TheSolversChartsComeAfterTheResults) {
  const TemporaryFolder folder;
  write_report(folder.path(), make_report_content());
  const std::string page = read_text(folder / "index.html");
  const auto solver = page.find("<h2>Solver</h2>");
  ASSERT_NE(solver, std::string::npos);
  EXPECT_GT(solver, page.find("<h2>Images</h2>"));
  for (const char* chart : {"Corrections by friction", "Penetration of the surfaces"})
    EXPECT_GT(page.find(chart), solver) << chart;
  EXPECT_LT(page.find("<h3>Diameters</h3>"), solver);
  EXPECT_TRUE(has(page, "Pink: the wall"));
}

TEST(Report, TheTitleNamesTheStenosissPlace) {
  const detail::Metrics metrics(
      R"({"lesion":{"centerline_id":4,"abscissa_mm":29.4,"diameter_stenosis_percent":60.2}})");
  EXPECT_EQ(detail::case_headline(metrics, "volume"),
            "Scan: stenosis of 60 % on line 4, 29 mm from the inlet");
}

TEST(Cards, TellABalloonThatDoesNotFillTheLumenFromContactsGap) {
  // Between a balloon of 3 mm and what it touches: a gap of 0.05 mm on both sides, and facets of
  // two meshes with edges of 0.3 mm, 4 * 0.3^2 / (8 * 1.5) = 0.03 mm.
  const auto told = [](double lumen_mm) {
    return detail::headline(detail::Metrics(
        R"({"status":"done","lesion":{"mld_mm":1.0},"result":{"mld_mm":2.5},
            "peak":{"contact_gap_mm":0.05,"mld_mm":)" +
        std::to_string(lumen_mm) +
        R"(},"balloon":{"peak_diameter_mm":3.0},"mesh":{"mean_edge_mm":0.3}})"));
  };
  EXPECT_TRUE(has(told(3.12), "(0.12 mm more than the balloon: contact"));
  EXPECT_FALSE(has(told(3.12), "does not fill"));
  EXPECT_TRUE(has(told(3.14), "(the balloon does not fill the lumen: it is 0.14 mm narrower)"));
  EXPECT_FALSE(has(told(3.14), "more than the balloon"));
  EXPECT_FALSE(has(told(3.01), " mm more"));
}

TEST(Metrics, EveryKeyOfAWallIsOneRow) {
  const std::string tables =
      detail::Metrics(R"({"wall":{"model":"layered","over_strength_percent":12.5}})").tables();
  EXPECT_EQ(count(tables, "<tr>"), 2u);
}

TEST(Cards, CallThePressuresRatioFractionalFlowReserveInCoronaryArteriesAlone) {
  const auto cards = [](const std::string& vessel) {
    return detail::headline(
        detail::Metrics(R"({"flow":{"ffr_before":0.72,"ffr_before_range":[0.64,0.79],"vessel":")" +
                        vessel + "\"}}"));
  };
  EXPECT_TRUE(has(cards("coronary"), "Fractional flow reserve"));
  EXPECT_TRUE(has(cards("coronary"), "0.80"));
  EXPECT_FALSE(has(cards("other"), "Fractional flow reserve"));
  EXPECT_FALSE(has(cards("other"), "0.80"));
  EXPECT_TRUE(has(cards("other"), ">0.72<"));
}

TEST(Report, NamesNoFractionalFlowReserveOfAVesselThatIsNotSaidToBeCoronary) {
  const TemporaryFolder folder;
  ReportContent content = make_report_content();
  const std::string said = "\"vessel\":\"coronary\"";
  content.metrics_json.replace(content.metrics_json.find(said), said.size(),
                               "\"vessel\":\"other\"");
  write_report(folder.path(), content);
  const std::string page = read_text(folder / "index.html");
  EXPECT_TRUE(has(page, "Pd/Pa before 0.72"));
  EXPECT_FALSE(has(page, "FFR before"));
  EXPECT_FALSE(has(page, "<h2>Fractional flow reserve</h2>"));
  EXPECT_FALSE(has(page, "0.80 and less"));
}

TEST(Report, EveryStenosisIsARowInTheOrderGiven) {
  const std::string table = detail::lesion_table(
      R"([{"centerline_id":2,"mld_mm":1.1,"reference_interpolated_mm":3.0,
           "diameter_stenosis_percent":63.3,"length_mm":9.0},
          {"centerline_id":0,"mld_mm":1.6,"reference_interpolated_mm":null,
           "diameter_stenosis_percent":45.0,"reference_rule":"<script>"}])");
  EXPECT_EQ(count(table, "<tr>"), 3u);
  EXPECT_LT(table.find("63.3"), table.find("45.0"));
  EXPECT_TRUE(has(table, ">3.00<"));
  EXPECT_TRUE(has(table, "–"));
  EXPECT_FALSE(has(table, "<script"));
  EXPECT_FALSE(has(table, "image")) << "it may be of a surface";
  EXPECT_TRUE(has(detail::lesion_table("[]"), "No stenosis"));
  EXPECT_EQ(detail::lesion_table(""), "");
  EXPECT_THROW(detail::lesion_table("{"), InputError);
}

TEST(Report, AStenosisBelowItsOwnVoxelsIsARowOfBounds) {
  // Of a voxel of 1 mm in a vessel of 5: 80 % of the diameter, 1 - 1/25 of the area.
  const std::string table = detail::lesion_table(
      R"([{"mld_mm":0.583,"mla_mm2":0.466,"reference_diameter_mm":5.0,"resolution_mm":1.0,
           "mld_below_resolution":true,"stenosis_at_least_percent":80.0,
           "diameter_stenosis_percent":88.6,"area_stenosis_percent":97.7},
          {"mld_mm":1.491,"mla_mm2":3.66,"reference_diameter_mm":4.3,"resolution_mm":1.0,
           "mld_below_resolution":false,"stenosis_at_least_percent":null,
           "diameter_stenosis_percent":65.6,"area_stenosis_percent":75.1}])");
  for (const char* bound : {"<td>&lt; 1.00<", "<td>&lt; 0.79<", "<td>≥ 80.0<", "<td>≥ 96.0<"})
    EXPECT_TRUE(has(table, bound)) << bound;
  for (const char* measured : {"0.58", "0.47", "88.6", "97.7"})
    EXPECT_FALSE(has(table, measured)) << measured;
  for (const char* measured : {">1.49<", ">3.66<", ">65.6<", ">75.1<"})
    EXPECT_TRUE(has(table, measured)) << measured;
}

TEST(Report, DamagedMetricsAreRefusedByName) {
  const TemporaryFolder folder;
  ReportContent content;
  content.lumen = test::make_tube({});
  content.metrics_json = "{";
  try {
    write_report(folder.path(), content);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("metrics.json"));
  }
  EXPECT_FALSE(fs::exists(folder / "index.html"));
}

}  // namespace
}  // namespace angio::viewer
