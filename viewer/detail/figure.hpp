#pragma once

#include <string>

#include "viewer/detail/picture.hpp"
#include "viewer/report.hpp"

namespace angio::viewer::detail {

/// A picture of the report.
struct Figure {
  std::string file;     ///< name beside index.html, e.g. "tree.png"
  std::string caption;  ///< plain text
  Picture picture;
};

/// The line through the lesion; null if the tree has none of that id with at least two points.
inline const CenterlinePath* lesion_path(const ReportContent& content) {
  for (const CenterlinePath& path : content.tree.paths)
    if (path.id == content.lesion_path && path.points.size() >= 2) return &path;
  return nullptr;
}

/// What the place that the pictures show is: where the balloon is, the worst of the stenoses that
/// are listed, or where a balloon would be tried.
inline std::string site_name(const ReportContent& content) {
  const bool is_any_listed = content.lesions_json.find('{') != std::string::npos;
  return !content.moments.empty() ? "balloon site" : is_any_listed ? "stenosis" : "trial place";
}

}  // namespace angio::viewer::detail
