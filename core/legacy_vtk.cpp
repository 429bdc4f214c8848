#include "core/legacy_vtk.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>

namespace angio {

std::string legacy_vtk_data_set(const std::filesystem::path& path) {
  constexpr std::size_t kMostHead = 8192;  // bytes: version, title, encoding, a field at most
  std::string head(kMostHead, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), std::streamsize(head.size()));
  head.resize(std::size_t(std::max<std::streamsize>(file.gcount(), 0)));
  if (!head.starts_with("# vtk DataFile")) return {};
  std::istringstream lines(head);
  for (std::string line; std::getline(lines, line);) {
    std::transform(line.begin(), line.end(), line.begin(),
                   [](unsigned char c) { return char(std::toupper(c)); });
    std::istringstream words(line);
    std::string word, kind;
    if (words >> word >> kind && word == "DATASET") return kind;
  }
  return {};
}

bool is_legacy_surface(const std::string& data_set) {
  return data_set == "POLYDATA" || data_set == "UNSTRUCTURED_GRID" || data_set == "STRUCTURED_GRID";
}

}  // namespace angio
