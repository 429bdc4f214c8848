#include "core/error.hpp"

#include <string>

namespace angio::detail {

void fail_expectation(const char* condition, const char* file, int line) {
  throw InternalError(std::string("expectation failed: ") + condition + " (" + file + ":" +
                      std::to_string(line) + ")");
}

}  // namespace angio::detail
