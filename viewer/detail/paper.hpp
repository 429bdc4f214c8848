#pragma once

#include <memory>
#include <string>
#include <vector>

#include "viewer/detail/page_blocks.hpp"

namespace angio::viewer::detail {

/// White A4 sheets that are filled from the top; what does not fit begins a new one.
class Paper {
 public:
  /// @param title, version  of the document; both stand in its head
  /// @param footer          on every sheet, beside its number
  Paper(const std::string& title, const std::string& version, std::string footer);
  ~Paper();
  Paper(const Paper&) = delete;
  Paper& operator=(const Paper&) = delete;

  /// A title, heading, text, note or bullet.
  void add_text(const PageBlock& block);
  /// Cards, three beside each other.
  void add_cards(const std::vector<PageBlock>& cards);
  void add_table(const PageBlock& table);
  /// Pictures and drawings, as many beside each other as they say.
  /// @throws InputError if one is damaged
  void add_figures(const std::vector<PageBlock>& figures);

  /// Ends the last sheet. @return the whole PDF file
  std::string finish();

 private:
  struct Sheets;
  std::unique_ptr<Sheets> sheets_;
};

}  // namespace angio::viewer::detail
