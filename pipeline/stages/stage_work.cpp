#include "pipeline/stages/stage_work.hpp"

#include <algorithm>

namespace angio::pipeline {

void keep(std::vector<std::string>& warnings, const std::vector<std::string>& more) {
  for (const std::string& warning : more)
    if (std::find(warnings.begin(), warnings.end(), warning) == warnings.end())
      warnings.push_back(warning);
}

}  // namespace angio::pipeline
