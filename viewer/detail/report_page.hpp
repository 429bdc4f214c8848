#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "viewer/detail/figure.hpp"
#include "viewer/detail/tables.hpp"
#include "viewer/doubts.hpp"

/// What the pages of all reports share.
namespace angio::viewer::detail {

/// Writes the pictures beside the page and gives their HTML; figures share one block of a class.
class Album {
 public:
  explicit Album(std::filesystem::path folder) : folder_(std::move(folder)) {}

  [[nodiscard]] std::string block(const std::vector<Figure>& figures, const std::string& css) const;

 private:
  [[nodiscard]] std::string element(const Figure& figure) const;

  std::filesystem::path folder_;
};

/// A part of the page under a heading; empty if it has no body.
std::string section(const std::string& title, const std::string& body);

/// The page up to its first notice.
/// @param title, case_name  plain text; the name stands below the title; empty: it is the title
std::string page_head(const std::string& title, const std::string& version,
                      const std::string& case_name = {});

/// Whose use this is not for.
std::string use_notice();

/// What to doubt in a result, below it: the first, and how many others there are, with a link.
std::string first_doubts(const std::vector<Doubts>& doubts);

/// The others, group by group.
std::string other_doubts(const std::vector<Doubts>& doubts);

/// The tables of all numbers, the conventions, and the page's end.
std::string page_end(const Metrics& metrics, const std::string& run_json);

/// Pictures of an earlier report that this one does not have would tell of another state.
void remove_old_pictures(const std::filesystem::path& folder);

}  // namespace angio::viewer::detail
