#include "pipeline/case/case_folder.hpp"

#include <filesystem>
#include <string>

#include "core/error.hpp"
#include "fuzz/target.hpp"
#include "pipeline/cli/verify_case.hpp"

namespace {

/// A record beside a settings file, parted by a line "%%"; as from elsewhere.
constexpr std::string_view kPart = "\n%%\n";

}  // namespace

ANGIO_FUZZ_TARGET(case_folder) {
  const auto part = bytes.find(kPart);
  const std::string_view record = bytes.substr(0, part);
  angio::fuzz::file_of(record, "case/run.json");
  angio::fuzz::file_of(
      part == std::string_view::npos ? std::string_view() : bytes.substr(part + kPart.size()),
      "case/case.toml");
  const std::filesystem::path folder =
      angio::fuzz::file_of(record, "case/metrics.json").parent_path();
  try {
    const angio::pipeline::CaseFolder found(folder);
    static_cast<void>(found.read_record());
    static_cast<void>(found.is_record_intact());
  } catch (const angio::InputError&) {
    // verify says so in its way
  }
  angio::pipeline::verify_case(angio::pipeline::CaseFolder(folder));
}
