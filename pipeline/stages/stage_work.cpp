#include "pipeline/stages/stage_work.hpp"

namespace angio::pipeline {

void keep(std::vector<std::string>& warnings, const std::vector<std::string>& more) {
  warnings.insert(warnings.end(), more.begin(), more.end());
}

}  // namespace angio::pipeline
