#include "pipeline/version.hpp"

#include "pipeline/commit.hpp"

namespace angio::pipeline {

std::string version_with_commit() {
  const std::string commit = kCommit;
  return commit.empty() ? kVersion : kVersion + (" (" + commit + ")");
}

}  // namespace angio::pipeline
