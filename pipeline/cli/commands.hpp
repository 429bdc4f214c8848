#pragma once

#include <filesystem>

namespace angio::pipeline {

/// Parses the command line, does what it says and returns the exit code. Every failure prints one
/// line on standard error.
int run_command_line(int argc, char** argv);

}  // namespace angio::pipeline
