// fuzz_replay TARGET FOLDER: runs a target over every file of a folder, as CTest does.

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "fuzz/target.hpp"

namespace angio::fuzz {
namespace {

std::map<std::string, Target>& targets() {
  static std::map<std::string, Target> all;
  return all;
}

int replay(const std::string& name, const std::filesystem::path& folder) {
  const auto found = targets().find(name);
  if (found == targets().end()) {
    std::fprintf(stderr, "there is no target %s\n", name.c_str());
    return 64;
  }
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    std::printf("%s\n", file.filename().c_str());
    std::fflush(stdout);  // the last one is at fault where the process ends
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
    run_target(found->second, bytes);
  }
  return files.empty() ? 66 : 0;
}

}  // namespace

Registration::Registration(const char* name, Target target) { targets()[name] = target; }

}  // namespace angio::fuzz

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "fuzz_replay TARGET FOLDER\n");
    return 64;
  }
  return angio::fuzz::replay(argv[1], argv[2]);
}
