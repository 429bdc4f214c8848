#include "viewer/detail/page_blocks.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "formats/text.hpp"

namespace angio::viewer::detail {
namespace {

constexpr std::array<std::string_view, 6> kVoid{"meta", "img", "br", "input", "link", "hr"};
constexpr std::array<std::string_view, 7> kUnseen{"head",   "script", "style", "noscript",
                                                  "button", "select", "canvas"};
constexpr std::array<std::pair<std::string_view, int>, 4> kGrids{
    {{"row", 3}, {"pairs", 2}, {"tiles", 4}, {"charts", 2}}};

template <class List>
bool holds(const List& list, std::string_view name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

struct Tag {
  std::string_view name, attributes;
  bool is_end = false;

  [[nodiscard]] std::string_view attribute(std::string_view key) const {
    const std::string begin = " " + std::string(key) + "=\"";
    const std::size_t at = attributes.find(begin);
    if (at == std::string_view::npos) return {};
    const std::size_t first = at + begin.size();
    return attributes.substr(first, attributes.find('"', first) - first);
  }
  /// Is the word among its classes?
  [[nodiscard]] bool has_class(std::string_view word) const {
    const std::string all = " " + std::string(attribute("class")) + " ";
    return all.find(" " + std::string(word) + " ") != std::string::npos;
  }
};

Tag parse_tag(std::string_view inner) {
  Tag tag;
  tag.is_end = inner.starts_with('/');
  if (tag.is_end) inner.remove_prefix(1);
  const std::size_t end = std::min(inner.find_first_of(" \n/"), inner.size());
  tag.name = inner.substr(0, end);
  tag.attributes = inner.substr(end);
  return tag;
}

std::string unescape(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, char>, 6> kEntities{{{"&amp;", '&'},
                                                                        {"&lt;", '<'},
                                                                        {"&gt;", '>'},
                                                                        {"&quot;", '"'},
                                                                        {"&#39;", '\''},
                                                                        {"&#x27;", '\''}}};
  std::string plain;
  while (!text.empty()) {
    const auto entity = std::find_if(kEntities.begin(), kEntities.end(),
                                     [&](const auto& e) { return text.starts_with(e.first); });
    plain += entity != kEntities.end() ? entity->second : text.front();
    text.remove_prefix(entity != kEntities.end() ? entity->first.size() : 1);
  }
  return plain;
}

/// Line ends and runs of spaces as one space.
std::string squeeze(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const bool is_space = std::isspace(static_cast<unsigned char>(c)) != 0;
    if (!is_space)
      result += c;
    else if (!result.empty() && result.back() != ' ')
      result += ' ';
  }
  if (!result.empty() && result.back() == ' ') result.pop_back();
  return result;
}

std::string picture_bytes(const Tag& image) {
  constexpr std::string_view kHead = "data:image/png;base64,";
  const std::string_view source = image.attribute("src");
  if (!source.starts_with(kHead)) return {};
  return formats::from_base64(source.substr(kHead.size()));
}

/// Walks along a page and gathers its blocks.
class PageReader {
 public:
  explicit PageReader(std::string_view page) : rest_(page) {}

  std::vector<PageBlock> read() {
    while (!rest_.empty()) {
      const std::size_t open = rest_.find('<');
      take_text(rest_.substr(0, open));
      if (open == std::string_view::npos) break;
      rest_.remove_prefix(open);
      const std::size_t close = rest_.find('>');
      if (close == std::string_view::npos) break;
      const Tag tag = parse_tag(rest_.substr(1, close - 1));
      if (tag.name == "svg" && !tag.is_end) {
        take_drawing();
        continue;
      }
      rest_.remove_prefix(close + 1);
      if (!tag.name.starts_with('!')) take_tag(tag);
    }
    end_block();
    return std::move(blocks_);
  }

 private:
  struct Element {
    std::string_view name;
    bool is_unseen = false;
    int columns = 0;  ///< of a grid; 0: it is none
    bool is_note = false, is_card = false;
  };

  [[nodiscard]] bool is_unseen() const {
    return std::any_of(open_.begin(), open_.end(), [](const Element& e) { return e.is_unseen; });
  }
  [[nodiscard]] bool is_in(bool Element::*what) const {
    return std::any_of(open_.begin(), open_.end(), [&](const Element& e) { return e.*what; });
  }
  [[nodiscard]] int grid_columns() const {
    for (auto element = open_.rbegin(); element != open_.rend(); ++element)
      if (element->columns > 0) return element->columns;
    return 1;
  }

  PageBlock& begin_block(BlockKind kind, const std::string& text) {
    PageBlock& block = blocks_.emplace_back();
    block.kind = kind;
    block.text = text;
    block.columns = grid_columns();
    return block;
  }
  void take_text(std::string_view text) {
    if (!is_unseen()) text_ += unescape(text);
  }
  void take_drawing() {
    constexpr std::string_view kEnd = "</svg>";
    const std::size_t end = std::min(rest_.find(kEnd), rest_.size() - kEnd.size()) + kEnd.size();
    const std::string_view drawing = rest_.substr(0, end);
    rest_.remove_prefix(end);
    if (is_unseen()) return;
    end_block();
    begin_block(BlockKind::drawing, {}).bytes = drawing;
  }
  void take_tag(const Tag& tag) {
    if (tag.name == "img" && !is_unseen()) {
      end_block();
      begin_block(BlockKind::picture, unescape(tag.attribute("alt"))).bytes = picture_bytes(tag);
    }
    if (holds(kVoid, tag.name)) return;
    if (tag.is_end)
      end_element(tag);
    else
      begin_element(tag);
  }
  void begin_element(const Tag& tag) {
    Element element{tag.name};
    const std::string_view id = tag.attribute("id");
    element.is_unseen = holds(kUnseen, tag.name) || tag.has_class("on-narrow") || id == "scene" ||
                        id == "section-slider";
    for (const auto& [name, columns] : kGrids)
      if (tag.has_class(name)) element.columns = columns;
    element.is_note = tag.has_class("notice");
    element.is_card = tag.has_class("card");
    if (is_block(tag.name)) end_block();
    open_.push_back(element);
    if (is_unseen()) return;
    if (element.is_card) begin_block(BlockKind::card, {});
    if (tag.name == "table") begin_block(BlockKind::table, {});
    if (tag.name == "tr" && !blocks_.empty()) blocks_.back().rows.emplace_back();
    card_part_ = element.is_card ? "" : std::string(tag.attribute("class"));
  }
  void end_element(const Tag& tag) {
    if (is_block(tag.name)) end_block();
    while (!open_.empty()) {
      const bool found = open_.back().name == tag.name;
      open_.pop_back();
      if (found) return;
    }
  }
  static bool is_block(std::string_view name) {
    constexpr std::array<std::string_view, 18> kBlocks{
        "h1",   "h2",    "h3", "p",  "li", "ul",     "div",        "section", "header",
        "main", "table", "tr", "th", "td", "figure", "figcaption", "body",    "html"};
    return holds(kBlocks, name);
  }

  /// Puts the text since the last border where the innermost element says.
  void end_block() {
    const std::string text = squeeze(text_);
    text_.clear();
    if (text.empty() || open_.empty()) return;
    const std::string_view name = open_.back().name;
    if (is_in(&Element::is_card) && !blocks_.empty()) return add_to_card(text);
    if (name == "th" || name == "td") {
      if (!blocks_.empty() && !blocks_.back().rows.empty())
        blocks_.back().rows.back().push_back({text, name == "th"});
      return;
    }
    if (name == "figcaption" && !blocks_.empty()) {
      blocks_.back().text = text;
      return;
    }
    begin_block(kind_of(name), text);
  }
  void add_to_card(const std::string& text) {
    PageBlock& card = blocks_.back();
    (card_part_ == "value" ? card.value : card_part_ == "detail" ? card.detail : card.text) = text;
  }
  [[nodiscard]] BlockKind kind_of(std::string_view name) const {
    if (name == "h1") return BlockKind::title;
    if (name == "h2") return BlockKind::heading;
    if (name == "h3") return BlockKind::subheading;
    if (name == "li") return BlockKind::bullet;
    return is_in(&Element::is_note) ? BlockKind::note : BlockKind::text;
  }

  std::string_view rest_;
  std::vector<Element> open_;
  std::string text_, card_part_;
  std::vector<PageBlock> blocks_;
};

}  // namespace

std::vector<PageBlock> read_page(const std::string& page) { return PageReader(page).read(); }

}  // namespace angio::viewer::detail
