#pragma once

#include <string>

namespace angio::pipeline {

/// A message without the names of the input, which often are a patient's: its path, as it was typed
/// and as it is, becomes INPUT, and the name of each file and folder in it FILE.
/// Names are whole words; one that our own messages are made of ("in", "ct") is replaced only as a
/// part of a path, or in quotes. What a case, a log
/// or a summary holds is freed of them by this; the console may say what was typed.
///
/// @param input  path of a scan or surface; a phantom is nobody's
std::string without_input(std::string message, const std::string& input);

}  // namespace angio::pipeline
