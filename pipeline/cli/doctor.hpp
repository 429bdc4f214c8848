#pragma once

#include <string>

namespace angio::pipeline {

/// What this computer has (threads, memory, GPU and driver, display) and what will be used, as
/// text for people or as JSON.
std::string examine_computer(bool as_json);

}  // namespace angio::pipeline
