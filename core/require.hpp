#pragma once

#include <string>
#include <string_view>

/// Range checks of options, in one wording for all stages.
namespace angio {

/// What is wrong with a value that lies outside [low, high], or is not a number; empty if nothing
/// is: "FIELD is VALUE (it must lie in [LOW, HIGH])".
std::string range_fault(std::string_view field, double value, double low, double high);

/// @param field   "section.key"
/// @param advice  follows the message: ". Leave it out for the default"
/// @throws OptionError if the value lies outside [low, high], or is not a number
void require_within(std::string_view field, double value, double low, double high,
                    std::string_view advice = {});

/// For what one interval does not say.
/// @param allowed  in words: "0, 2, 3 or 5"
/// @throws OptionError "FIELD is out of range (allowed: ALLOWED)" unless `good`
void require(bool good, std::string_view field, std::string_view allowed);

}  // namespace angio
