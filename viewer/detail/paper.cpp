#include "viewer/detail/paper.hpp"

#include <cairo-pdf.h>
#include <librsvg/rsvg.h>
#include <pango/pangocairo.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <sstream>
#include <utility>

#include "core/error.hpp"
#include "viewer/detail/drawing_style.hpp"

namespace angio::viewer::detail {
namespace {

// A4 in points of 1/72 inch.
constexpr double kWidth = 595.276, kHeight = 841.89, kMargin = 45.0, kFooter = 28.0;
constexpr double kColumn = kWidth - 2.0 * kMargin;
constexpr double kGap = 8.0;
constexpr double kCellSpace = 6.0;  // between a table's columns
constexpr double kMostFigureHeight = 430.0;

struct Ink {
  double red, green, blue;
};
constexpr Ink kBlack{0.11, 0.13, 0.16}, kGrey{0.36, 0.39, 0.45}, kLine{0.8, 0.82, 0.86},
    kNotePaper{1.0, 0.957, 0.863};

struct Type {
  double size = 9.0;  ///< [pt]
  bool bold = false;
  Ink ink = kBlack;
  PangoAlignment align = PANGO_ALIGN_LEFT;
};

template <class Object>
struct Unref {
  void operator()(Object* object) const { g_object_unref(object); }
};
template <class Object>
using OwnedObject = std::unique_ptr<Object, Unref<Object>>;
struct FreeSurface {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
};
using Surface = std::unique_ptr<cairo_surface_t, FreeSurface>;

cairo_status_t append(void* file, const unsigned char* bytes, unsigned int count) {
  static_cast<std::string*>(file)->append(reinterpret_cast<const char*>(bytes), count);
  return CAIRO_STATUS_SUCCESS;
}

struct PngSource {
  const std::string* bytes;
  std::size_t at = 0;
};
cairo_status_t read_png(void* closure, unsigned char* bytes, unsigned int count) {
  auto& source = *static_cast<PngSource*>(closure);
  if (source.at + count > source.bytes->size()) return CAIRO_STATUS_READ_ERROR;
  std::memcpy(bytes, source.bytes->data() + source.at, count);
  source.at += count;
  return CAIRO_STATUS_SUCCESS;
}

[[noreturn]] void refuse_figure() {
  throw InputError(
      "a picture of the report is damaged (the page was changed or cut short). Make it again: "
      "`angio report CASE`");
}

/// A picture or a drawing, and how to draw it.
struct PaperFigure {
  Surface picture;
  OwnedObject<RsvgHandle> drawing;
  double width = 0.0, height = 0.0;  ///< of its own [px]
};

PaperFigure load_figure(const PageBlock& block) {
  PaperFigure figure;
  if (block.kind == BlockKind::picture) {
    PngSource source{&block.bytes};
    figure.picture.reset(cairo_image_surface_create_from_png_stream(read_png, &source));
    if (cairo_surface_status(figure.picture.get()) != CAIRO_STATUS_SUCCESS) refuse_figure();
    figure.width = cairo_image_surface_get_width(figure.picture.get());
    figure.height = cairo_image_surface_get_height(figure.picture.get());
    return figure;
  }
  const std::string svg = styled_drawing(block.bytes);
  figure.drawing.reset(
      rsvg_handle_new_from_data(reinterpret_cast<const guint8*>(svg.data()), svg.size(), nullptr));
  if (!figure.drawing) refuse_figure();
  gboolean has_width = 0, has_height = 0, has_box = 0;
  RsvgLength width{}, height{};
  RsvgRectangle box{};
  rsvg_handle_get_intrinsic_dimensions(figure.drawing.get(), &has_width, &width, &has_height,
                                       &height, &has_box, &box);
  if (has_box == 0 || !(box.width > 0.0 && box.height > 0.0)) refuse_figure();
  figure.width = box.width;
  figure.height = box.height;
  return figure;
}

}  // namespace

struct Paper::Sheets {
  std::string file, footer;
  cairo_surface_t* surface = nullptr;
  cairo_t* cairo = nullptr;
  double top = kMargin;  ///< where the next thing goes [pt]
  int number = 1;
  std::vector<PageBlock> headings;  ///< that wait for what they stand above

  OwnedObject<PangoLayout> layout(const std::string& text, const Type& type, double width) const {
    OwnedObject<PangoLayout> result(pango_cairo_create_layout(cairo));
    PangoFontDescription* font = pango_font_description_from_string("DejaVu Sans, Sans");
    pango_font_description_set_absolute_size(font, type.size * PANGO_SCALE);
    if (type.bold) pango_font_description_set_weight(font, PANGO_WEIGHT_BOLD);
    pango_layout_set_font_description(result.get(), font);
    pango_font_description_free(font);
    pango_layout_set_width(result.get(), int(width * PANGO_SCALE));
    pango_layout_set_wrap(result.get(), PANGO_WRAP_WORD_CHAR);
    pango_layout_set_alignment(result.get(), type.align);
    pango_layout_set_text(result.get(), text.c_str(), int(text.size()));
    return result;
  }
  static double height_of(PangoLayout* layout) {
    int width = 0, height = 0;
    pango_layout_get_size(layout, &width, &height);
    return double(height) / PANGO_SCALE;
  }
  void set_ink(const Ink& ink) const { cairo_set_source_rgb(cairo, ink.red, ink.green, ink.blue); }
  void draw(PangoLayout* text, const Ink& ink, double left, double at) const {
    set_ink(ink);
    cairo_move_to(cairo, left, at);
    pango_cairo_show_layout(cairo, text);
  }
  /// Where text of a type is drawn; its height comes back.
  double write(const std::string& text, const Type& type, double left, double at,
               double width) const {
    const auto shape = layout(text, type, width);
    draw(shape.get(), type.ink, left, at);
    return height_of(shape.get());
  }
  void end_sheet() {
    const std::string text = footer + " · " + std::to_string(number);
    write(text, {7.5, false, kGrey, PANGO_ALIGN_CENTER}, kMargin, kHeight - kFooter, kColumn);
    cairo_show_page(cairo);
    ++number;
    top = kMargin;
  }
  static Type type_of(BlockKind kind) {
    if (kind == BlockKind::title) return {17.0, true};
    if (kind == BlockKind::heading) return {12.5, true};
    if (kind == BlockKind::subheading) return {10.0, true};
    return {};
  }
  static double space_before(BlockKind kind) {
    return kind == BlockKind::heading ? 14.0 : kind == BlockKind::subheading ? 8.0 : 2.0;
  }
  static constexpr double kAfterHeading = 3.0;
  OwnedObject<PangoLayout> shape_of(const PageBlock& heading) const {
    return layout(heading.text, type_of(heading.kind), kColumn);
  }
  /// What is left of this sheet below the headings that wait.
  double room() const {
    double left = kHeight - kMargin - top;
    for (const PageBlock& heading : headings)
      left -= space_before(heading.kind) + height_of(shape_of(heading).get()) + kAfterHeading;
    return left;
  }
  double width_of(const std::string& text, const Type& type) const {
    const auto shape = layout(text, type, kColumn);
    pango_layout_set_width(shape.get(), -1);
    int width = 0, height = 0;
    pango_layout_get_size(shape.get(), &width, &height);
    return double(width) / PANGO_SCALE;
  }
  /// Every column holds its longest word; what is left of the sheet's width goes to those whose
  /// longest text is longer, up to a share of it.
  std::vector<double> column_widths(const std::vector<std::vector<TableCell>>& rows,
                                    std::size_t columns, const Type& type) const {
    constexpr double kMostText = 200.0;
    std::vector<double> word(columns, 1.0), whole(columns, 1.0);
    for (const auto& row : rows)
      for (std::size_t c = 0; c < row.size(); ++c) {
        std::istringstream words(row[c].text);
        for (std::string one; words >> one;)
          word[c] = std::max(word[c], std::min(kMostText, width_of(one, type)));
        whole[c] = std::max(whole[c], std::min(kMostText, width_of(row[c].text, type)));
      }
    const double space = kColumn - kCellSpace * double(columns);
    const double words = std::accumulate(word.begin(), word.end(), 0.0),
                 more = std::max(1e-9, std::accumulate(whole.begin(), whole.end(), -words));
    std::vector<double> widths;
    for (std::size_t c = 0; c < columns; ++c)
      widths.push_back(kCellSpace +
                       (words > space ? space * word[c] / words
                                      : word[c] + (space - words) * (whole[c] - word[c]) / more));
    return widths;
  }
  /// Begins a new sheet unless there is so much left of this one, for the headings that wait, too;
  /// writes these.
  void need(double height) {
    if (height > room() && top > kMargin) end_sheet();
    for (const PageBlock& heading : headings) {
      const auto shape = shape_of(heading);
      top += space_before(heading.kind);
      draw(shape.get(), kBlack, kMargin, top);
      top += height_of(shape.get()) + kAfterHeading;
    }
    headings.clear();
  }
  /// A heading is written with what comes behind it; one that nothing comes behind is left out.
  void await(const PageBlock& heading) {
    while (!headings.empty() && headings.back().kind >= heading.kind) headings.pop_back();
    headings.push_back(heading);
  }
  void draw_figure(const PaperFigure& figure, double left, double at, double width,
                   double height) const {
    if (figure.drawing) {
      const RsvgRectangle place{left, at, width, height};
      cairo_save(cairo);
      cairo_rectangle(cairo, left, at, width, height);  // a page shows no more of it, either
      cairo_clip(cairo);
      rsvg_handle_render_document(figure.drawing.get(), cairo, &place, nullptr);
      cairo_restore(cairo);
      return;
    }
    cairo_save(cairo);
    cairo_translate(cairo, left, at);
    cairo_scale(cairo, width / figure.width, height / figure.height);
    cairo_set_source_surface(cairo, figure.picture.get(), 0.0, 0.0);
    cairo_paint(cairo);
    cairo_restore(cairo);
  }
  void draw_row(const std::vector<PageBlock>& figures, std::size_t first, std::size_t count,
                int columns);
};

Paper::Paper(const std::string& title, const std::string& version, std::string footer)
    : sheets_(std::make_unique<Sheets>()) {
  sheets_->footer = std::move(footer);
  sheets_->surface = cairo_pdf_surface_create_for_stream(append, &sheets_->file, kWidth, kHeight);
  cairo_pdf_surface_set_metadata(sheets_->surface, CAIRO_PDF_METADATA_TITLE, title.c_str());
  cairo_pdf_surface_set_metadata(sheets_->surface, CAIRO_PDF_METADATA_CREATOR,
                                 ("angio " + version).c_str());
  // The same page gives the same bytes.
  cairo_pdf_surface_set_metadata(sheets_->surface, CAIRO_PDF_METADATA_CREATE_DATE,
                                 "1900-01-01T00:00:00Z");
  sheets_->cairo = cairo_create(sheets_->surface);
}

Paper::~Paper() {
  cairo_destroy(sheets_->cairo);
  cairo_surface_destroy(sheets_->surface);
}

void Paper::add_text(const PageBlock& block) {
  if (block.kind == BlockKind::heading || block.kind == BlockKind::subheading)
    return sheets_->await(block);
  const Type type = Sheets::type_of(block.kind);
  const double before = Sheets::space_before(block.kind);
  double left = kMargin;
  if (block.kind == BlockKind::bullet) left += 12.0;
  const bool is_note = block.kind == BlockKind::note;
  if (is_note) left += 8.0;
  const double width = kWidth - kMargin - left - (is_note ? 8.0 : 0.0);
  const auto shape = sheets_->layout(block.text, type, width);
  const double height = Sheets::height_of(shape.get());
  sheets_->need(before + height);
  sheets_->top += before;
  if (is_note) {
    sheets_->set_ink(kNotePaper);
    cairo_rectangle(sheets_->cairo, kMargin, sheets_->top - 3.0, kColumn, height + 6.0);
    cairo_fill(sheets_->cairo);
  }
  if (block.kind == BlockKind::bullet) sheets_->write("•", type, kMargin + 2.0, sheets_->top, 10.0);
  sheets_->draw(shape.get(), type.ink, left, sheets_->top);
  sheets_->top += height + (is_note ? 7.0 : 3.0);
}

void Paper::add_cards(const std::vector<PageBlock>& cards) {
  constexpr int kColumns = 3;
  constexpr double kInner = 7.0, kCardHeight = 66.0;
  const double width = (kColumn - (kColumns - 1) * kGap) / kColumns;
  for (std::size_t i = 0; i < cards.size(); ++i) {
    const int column = int(i % kColumns);
    if (column == 0) sheets_->need(kCardHeight + kGap);
    const double left = kMargin + column * (width + kGap);
    double at = sheets_->top + kInner;
    sheets_->set_ink(kLine);
    cairo_set_line_width(sheets_->cairo, 0.7);
    cairo_rectangle(sheets_->cairo, left, sheets_->top, width, kCardHeight);
    cairo_stroke(sheets_->cairo);
    const double inner = width - 2.0 * kInner;
    at += sheets_->write(cards[i].value, {12.5, true}, left + kInner, at, inner);
    at += sheets_->write(cards[i].text, {8.0, true}, left + kInner, at, inner);
    sheets_->write(cards[i].detail, {7.0, false, kGrey}, left + kInner, at, inner);
    if (column == kColumns - 1 || i + 1 == cards.size()) sheets_->top += kCardHeight + kGap;
  }
}

void Paper::add_table(const PageBlock& table) {
  std::size_t columns = 0;
  for (const auto& row : table.rows) columns = std::max(columns, row.size());
  if (columns == 0) return;
  const Type plain{8.0, false, kBlack};
  const std::vector<double> widths = sheets_->column_widths(table.rows, columns, plain);
  for (const auto& row : table.rows) {
    std::vector<OwnedObject<PangoLayout>> cells;
    double height = 0.0;
    for (std::size_t c = 0; c < row.size(); ++c) {
      Type type = plain;
      if (row[c].is_name) type.ink = kGrey;
      type.align = c == 0 ? PANGO_ALIGN_LEFT : PANGO_ALIGN_RIGHT;
      cells.push_back(sheets_->layout(row[c].text, type, widths[c] - kCellSpace));
      height = std::max(height, Sheets::height_of(cells.back().get()));
    }
    sheets_->need(height + 5.0);
    double left = kMargin;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      sheets_->draw(cells[c].get(), row[c].is_name ? kGrey : kBlack, left + 3.0,
                    sheets_->top + 2.0);
      left += widths[c];
    }
    sheets_->top += height + 4.0;
    sheets_->set_ink(kLine);
    cairo_set_line_width(sheets_->cairo, 0.4);
    cairo_move_to(sheets_->cairo, kMargin, sheets_->top);
    cairo_line_to(sheets_->cairo, kMargin + kColumn, sheets_->top);
    cairo_stroke(sheets_->cairo);
  }
  sheets_->top += 6.0;
}

void Paper::Sheets::draw_row(const std::vector<PageBlock>& blocks, std::size_t first,
                             std::size_t count, int columns) {
  const double cell = (kColumn - (columns - 1) * kGap) / columns;
  std::vector<PaperFigure> figures;
  std::vector<OwnedObject<PangoLayout>> captions;
  std::vector<double> scales;
  double height = 0.0;
  for (std::size_t i = first; i < first + count; ++i) {
    figures.push_back(load_figure(blocks[i]));
    const PaperFigure& figure = figures.back();
    scales.push_back(std::min(cell / figure.width, kMostFigureHeight / figure.height));
    captions.push_back(layout(blocks[i].text, {7.5, false, kGrey}, cell));
    height =
        std::max(height, scales.back() * figure.height + 3.0 + height_of(captions.back().get()));
  }
  // A picture of its own row is made smaller rather than that much of a sheet stays empty.
  constexpr double kLeastShrunk = 0.6;
  const double whole = scales.front() * figures.front().height, too_high = height + kGap - room();
  if (columns == 1 && too_high > 0.0 && whole - too_high >= kLeastShrunk * whole) {
    scales.front() *= 1.0 - too_high / whole;
    height -= too_high;
  }
  need(height + kGap);
  for (std::size_t i = 0; i < count; ++i) {
    const double width = scales[i] * figures[i].width, drawn = scales[i] * figures[i].height;
    const double left = kMargin + double(i) * (cell + kGap);
    draw_figure(figures[i], left + (columns == 1 ? 0.5 * (cell - width) : 0.0), top, width, drawn);
    draw(captions[i].get(), kGrey, left, top + drawn + 3.0);
  }
  top += height + kGap;
}

void Paper::add_figures(const std::vector<PageBlock>& figures) {
  for (std::size_t first = 0; first < figures.size();) {
    const int columns = std::max(1, figures[first].columns);
    std::size_t count = 0;
    while (count < std::size_t(columns) && first + count < figures.size() &&
           figures[first + count].columns == columns)
      ++count;
    sheets_->draw_row(figures, first, count, columns);
    first += count;
  }
}

std::string Paper::finish() {
  sheets_->end_sheet();
  cairo_surface_finish(sheets_->surface);
  if (cairo_surface_status(sheets_->surface) != CAIRO_STATUS_SUCCESS)
    throw IoError("the report's PDF could not be made (no memory for it). Close other programs");
  return std::move(sheets_->file);
}

}  // namespace angio::viewer::detail
