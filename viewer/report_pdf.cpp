#include "viewer/report_pdf.hpp"

#include <vector>

#include "viewer/detail/page_blocks.hpp"
#include "viewer/detail/paper.hpp"

namespace angio::viewer {
using namespace detail;
namespace {

bool is_figure(const PageBlock& block) {
  return block.kind == BlockKind::picture || block.kind == BlockKind::drawing;
}

/// The blocks from `first` on that are of the same sort.
template <class IsOfSort>
std::vector<PageBlock> run_of(const std::vector<PageBlock>& blocks, std::size_t first,
                              const IsOfSort& is_of_sort) {
  std::vector<PageBlock> run;
  for (std::size_t i = first; i < blocks.size() && is_of_sort(blocks[i]); ++i)
    run.push_back(blocks[i]);
  return run;
}

/// A chart's name stands above it: it becomes the caption, so that both stay on one sheet.
std::vector<PageBlock> with_captions(std::vector<PageBlock> blocks) {
  std::vector<PageBlock> result;
  for (PageBlock& block : blocks) {
    if (block.kind == BlockKind::drawing && block.text.empty() && !result.empty() &&
        result.back().kind == BlockKind::subheading) {
      block.text = result.back().text;
      result.pop_back();
    }
    result.push_back(std::move(block));
  }
  return result;
}

/// The page's heading and the case's name.
std::string title_of(const std::vector<PageBlock>& blocks, const std::string& name) {
  for (const PageBlock& block : blocks)
    if (block.kind == BlockKind::title && block.text != name) return block.text + ", case " + name;
  return name;
}

}  // namespace

std::string report_pdf(const std::string& page, const std::string& name,
                       const std::string& version) {
  const std::vector<PageBlock> blocks = with_captions(read_page(page));
  Paper paper(title_of(blocks, name), version,
              "Not for clinical use · angio " + version + " · " + name);
  const auto is_card = [](const PageBlock& block) { return block.kind == BlockKind::card; };
  for (std::size_t i = 0; i < blocks.size();) {
    if (is_card(blocks[i])) {
      const auto cards = run_of(blocks, i, is_card);
      paper.add_cards(cards);
      i += cards.size();
    } else if (is_figure(blocks[i])) {
      const auto figures = run_of(blocks, i, is_figure);
      paper.add_figures(figures);
      i += figures.size();
    } else {
      if (blocks[i].kind == BlockKind::table)
        paper.add_table(blocks[i]);
      else
        paper.add_text(blocks[i]);
      ++i;
    }
  }
  return paper.finish();
}

}  // namespace angio::viewer
