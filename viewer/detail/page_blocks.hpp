#pragma once

#include <string>
#include <vector>

/// What a report's page says, without how a browser lays it out.
namespace angio::viewer::detail {

enum class BlockKind {
  title,
  heading,
  subheading,
  text,
  note,
  bullet,
  card,
  table,
  picture,
  drawing
};

struct TableCell {
  std::string text;
  bool is_name = false;  ///< of its row or column
};

struct PageBlock {
  BlockKind kind = BlockKind::text;
  std::string text;    ///< plain; of a picture or drawing its caption
  std::string value;   ///< of a card: what it says, large; text is its name
  std::string detail;  ///< of a card: the small line below
  std::vector<std::vector<TableCell>> rows;
  std::string bytes;  ///< of a picture: PNG; of a drawing: SVG without a style
  int columns = 1;    ///< how many such pictures stand side by side
};

/// The blocks of a page that this program wrote, in its order. Left out are scripts, styles, and
/// what only a browser can show: the scene, the slider of sections, charts drawn for phones.
/// @throws InputError if a picture's bytes are damaged
std::vector<PageBlock> read_page(const std::string& page);

}  // namespace angio::viewer::detail
