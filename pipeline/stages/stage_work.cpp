#include "pipeline/stages/stage_work.hpp"

namespace angio::pipeline {

void keep(std::vector<std::string>& warnings, const std::vector<std::string>& more) {
  warnings.insert(warnings.end(), more.begin(), more.end());
}

Progress part(const Progress& whole, double first, double last) {
  return Progress([&whole, first, last](double fraction, std::string_view step) {
    whole.report(first + (last - first) * fraction, step);
  });
}

}  // namespace angio::pipeline
