#pragma once

#include <string_view>
#include <vector>

namespace angio::datasets::detail {

/// The known name that needs the fewest letters changed, added or dropped (Levenshtein); the first
/// of equals. @param known  not empty
std::string_view nearest_name(std::string_view name, const std::vector<std::string_view>& known);

}  // namespace angio::datasets::detail
