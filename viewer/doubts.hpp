#pragma once

#include <string>
#include <vector>

namespace angio::viewer {

/// What was noticed that makes the result less certain.
struct Doubts {
  std::string about;  ///< "the image"
  std::vector<std::string> texts;
};

}  // namespace angio::viewer
