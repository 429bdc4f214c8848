#include "viewer/contact_sheet.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "formats/html.hpp"
#include "formats/text.hpp"
#include "viewer/detail/canvas.hpp"
#include "viewer/detail/case_data.hpp"
#include "viewer/detail/offscreen.hpp"
#include "viewer/detail/page_style.hpp"
#include "viewer/detail/pictures_2d.hpp"
#include "viewer/detail/pictures_3d.hpp"
#include "viewer/detail/sheet_pictures.hpp"

namespace angio::viewer {
namespace fs = std::filesystem;
namespace {

using detail::Box;
using detail::Canvas;
using detail::kHeading;
using detail::kSheetInk;
using detail::kSheetLesion;
using detail::kSheetLetters;
using detail::Picture;
using detail::Rgb;
using detail::SheetCase;

constexpr int kWidth = 1860, kHeight = 1344;
constexpr int kTitle = 72, kSide = 420, kGap = 4;
constexpr Rgb kGrey{110, 118, 130};
constexpr Rgb kRule{210, 214, 220};

const Box kTree{kSide + kGap, kTitle, 920, 816};
const Box kNotes{kTree.x + kTree.width + kGap, kTitle, kWidth - kTree.x - kTree.width - kGap, 816};
const Box kChart{kSide + kGap, kTitle + kTree.height + kGap, 716, 448};
const Box kBalloon{kChart.x + kChart.width + kGap, kChart.y,
                   kWidth - kChart.x - kChart.width - kGap, 448};

void write_in_words(Canvas& canvas, const Box& box, const std::string& text) {
  constexpr double kLetters = 11.0;
  double y = box.y + 0.45 * box.height;
  for (const std::string& line : detail::wrap_text(text, box.width - 40.0, kLetters)) {
    canvas.write(line, {box.x + 20.0, y}, kLetters, kGrey);
    y += 2.0 * kLetters;
    if (y > box.y + box.height - kLetters) break;
  }
}

void draw_title(Canvas& canvas, const SheetCase& sheet) {
  canvas.write(sheet.name, {12.0, 30.0}, 17.0, kSheetInk);
  const bool has_failed = sheet.status.starts_with("failed");
  const Box name = Canvas::text_box(sheet.name, {12.0, 30.0}, 17.0);
  const double left = name.x + name.width + 40.0;
  const auto status = detail::wrap_text("status: " + sheet.status, kWidth - left - 12.0, 10.0);
  for (std::size_t i = 0; i < std::min<std::size_t>(2, status.size()); ++i)
    canvas.write(status[i], {left, 22.0 + 18.0 * double(i)}, 10.0,
                 has_failed ? kSheetLesion : kSheetInk);
  canvas.write(sheet.input + (sheet.input.empty() ? "" : "    ") + sheet.times, {12.0, 60.0}, 10.0,
               kGrey);
}

/// The scan's three projections, or the surface from three sides.
void draw_left_column(Canvas& canvas, const SheetCase& sheet) {
  std::vector<Picture> pictures;
  if (sheet.content.volume) {
    for (const detail::Figure& figure : detail::draw_projections(sheet.content))
      pictures.push_back(figure.picture);
  } else {
    pictures = detail::draw_sides_of_surface(sheet.content.lumen, kSide);
  }
  for (int i = 0; i < 3; ++i) {
    const Box box{0.0, double(kTitle + i * (kSide + kGap)), kSide, kSide};
    if (std::size_t(i) < pictures.size())
      canvas.place(pictures[std::size_t(i)], box);
    else
      write_in_words(canvas, box, "no picture: " + sheet.why_nothing);
  }
}

void draw_balloon(Canvas& canvas, const SheetCase& sheet) {
  const auto& content = sheet.content;
  Box below = kBalloon;
  below.y += 26.0;
  below.height -= 26.0;
  if (content.moments.empty())
    return write_in_words(canvas, below, "no balloon: nothing was placed or simulated");
  const auto figures = detail::draw_moments(content);
  canvas.place(figures.front().picture, below);
  canvas.write("balloon: " + content.moments.front().title,
               {kBalloon.x + kHeading.x, kBalloon.y + kHeading.y}, kSheetLetters, kSheetInk);
}

/// Lesions, then what the stages said.
void write_notes(Canvas& canvas, const SheetCase& sheet) {
  constexpr double kLine = 17.0;
  const double bottom = kNotes.y + kNotes.height - kLine;
  double y = kNotes.y + 18.0;
  const auto write = [&](const std::string& text, const Rgb& color) {
    for (const std::string& line : detail::wrap_text(text, kNotes.width - 24.0, kSheetLetters)) {
      if (y > bottom) return;
      canvas.write(line, {kNotes.x + 10.0, y}, kSheetLetters, color);
      y += kLine;
    }
  };
  write("lines: " + std::to_string(sheet.content.tree.paths.size()) +
            ", stenoses: " + std::to_string(sheet.lesions.size()),
        kSheetInk);
  for (const detail::SheetLesion& lesion : sheet.lesions) {
    if (y > kNotes.y + 0.6 * kNotes.height) {
      write("...", kSheetInk);
      break;
    }
    write(lesion.name + ": " + formats::fixed_text(lesion.stenosis_percent, 1) + " %DS, MLD " +
              formats::fixed_text(lesion.mld_mm, 2) + " of " +
              formats::fixed_text(lesion.reference_mm, 2) + " mm, line " +
              std::to_string(lesion.path) + " at " + formats::fixed_text(lesion.abscissa_mm, 1) +
              " mm",
          kSheetLesion);
  }
  y += 0.5 * kLine;
  write(sheet.notes.empty() ? "no warnings" : "notes: " + std::to_string(sheet.notes.size()),
        kSheetInk);
  for (const std::string& note : sheet.notes) write("- " + note, kGrey);
}

void draw_rules(Canvas& canvas) {
  canvas.draw_line({{0.0, kTitle - 2.0}, {double(kWidth), kTitle - 2.0}}, kRule, 1);
  const double left = kSide + 0.5 * kGap, low = kTitle + kTree.height + 0.5 * kGap;
  canvas.draw_line({{left, kTitle}, {left, double(kHeight)}}, kRule, 1);
  canvas.draw_line({{left, low}, {double(kWidth), low}}, kRule, 1);
  canvas.draw_line({{kNotes.x - 2.0, kTitle}, {kNotes.x - 2.0, low}}, kRule, 1);
  canvas.draw_line({{kBalloon.x - 2.0, low}, {kBalloon.x - 2.0, double(kHeight)}}, kRule, 1);
}

std::string table_of(const fs::path& csv) {
  if (csv.empty()) return {};
  const TimeSeries table = detail::read_time_series(csv);
  std::string out = "<div class=\"tables\"><table><tr>";
  for (const std::string& name : table.columns)
    out += "<th>" + formats::escape_html(name) + "</th>";
  out += "</tr>\n";
  for (const auto& row : table.rows) {
    out += "<tr>";
    for (const std::string& cell : row) out += "<td>" + formats::escape_html(cell) + "</td>";
    out += "</tr>\n";
  }
  return out + "</table></div>\n";
}

/// A run that failed may have left no case, but then a log.
void require_case(const fs::path& folder, const fs::path& log) {
  std::error_code ignored;
  const bool exists = fs::exists(folder, ignored);
  if (exists && !fs::is_directory(folder, ignored))
    throw InputError("this is a file (a case is a folder). Name the case's folder",
                     ExitCode::no_input);
  for (const char* part : {formats::case_file::kRun, formats::case_file::kLumen})
    if (fs::exists(folder / part, ignored)) return;
  if (fs::exists(log, ignored)) return;
  throw InputError(exists
                       ? "this is no case (it has no run.json, and there is no log that says why)"
                       : "there is no such case, nor a log that says why",
                   ExitCode::no_input);
}

}  // namespace

void write_contact_sheet(const fs::path& case_folder, const fs::path& png, const fs::path& log) {
  require_case(case_folder, log);
  const SheetCase sheet = detail::read_sheet_case(case_folder, log);
  Canvas canvas(detail::blank_picture(kWidth, kHeight));
  draw_title(canvas, sheet);
  {
    const detail::OffscreenDisplay display;
    draw_left_column(canvas, sheet);
    if (sheet.content.lumen.triangles.empty() && sheet.content.tree.paths.empty())
      write_in_words(canvas, kTree, "no tree: " + sheet.why_nothing);
    else
      canvas.place(detail::draw_named_tree(sheet, int(kTree.width), int(kTree.height)), kTree);
    draw_balloon(canvas, sheet);
  }
  canvas.place(detail::draw_diameters(sheet, int(kChart.width), int(kChart.height)), kChart);
  write_notes(canvas, sheet);
  draw_rules(canvas);
  write_text_atomically(png, detail::png_bytes(canvas.picture()));
}

void write_sheet_index(const fs::path& page, const std::vector<std::string>& sheets,
                       const fs::path& table_csv) {
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<title>Contact sheets</title>\n<style>" +
      std::string(detail::kPageStyle) +
      "\nmain{max-width:none}.sheets{display:flex;flex-wrap:wrap;gap:12px}"
      ".sheets figure{margin:0;width:460px}.sheets img{width:100%;height:auto}"
      "td,th{white-space:nowrap}</style>\n</head>\n<body>\n<header><h1>Contact sheets</h1>"
      "<p class=\"sub\">" +
      std::to_string(sheets.size()) + " cases</p></header>\n<main>\n" + table_of(table_csv) +
      "<div class=\"sheets\">\n";
  for (const std::string& sheet : sheets) {
    const std::string name = formats::escape_html(sheet);
    const std::string title = formats::escape_html(fs::path(sheet).stem().string());
    out += "<figure><a href=\"" + name + "\"><img loading=\"lazy\" alt=\"" + title + "\" src=\"" +
           name + "\"></a><figcaption>" + title + "</figcaption></figure>\n";
  }
  write_text_atomically(page, out + "</div>\n</main>\n</body>\n</html>\n");
}

}  // namespace angio::viewer
