#pragma once

#include <string>

namespace angio::pipeline {

inline constexpr const char* kPhantomPrefix = "phantom:";

/// What kind of thing INPUT names, by its name; what is called a volume may be a `run` of
/// projections, which its content tells (segmentation/read_run.hpp). @throws InputError (66) if it
/// does not exist, Error (64) for a phantom that there is not
enum class InputKind { volume, surface, phantom, run };
InputKind input_kind(const std::string& input);
const char* name(InputKind kind);

}  // namespace angio::pipeline
