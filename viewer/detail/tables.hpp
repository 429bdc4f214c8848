#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

/// What the report says in words and numbers, from metrics.json and run.json.
namespace angio::viewer::detail {

/// The numbers of metrics.json; anything missing or null is simply not there.
class Metrics {
 public:
  /// @param json  the file's text; empty means no metrics
  /// @throws InputError if it is no JSON object
  explicit Metrics(const std::string& text);
  ~Metrics();
  Metrics(Metrics&&) noexcept;
  Metrics& operator=(Metrics&&) noexcept;

  /// @param group, key  as in docs/contract.md: "lesion", "mld_mm"
  [[nodiscard]] std::optional<double> number(const char* group, const char* key) const;
  /// The two numbers of a range, the smaller first.
  [[nodiscard]] std::optional<std::array<double, 2>> range(const char* group,
                                                           const char* key) const;
  [[nodiscard]] std::string text(const char* group, const char* key) const;  ///< empty if missing
  /// At the top: "status", "status_reason". Empty if missing.
  [[nodiscard]] std::string text(const char* key) const;

  /// One HTML table a group, with names for people and units; unknown keys are shown as they are.
  [[nodiscard]] std::string tables() const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

/// Whether the flow's ratio of pressures may be called fractional flow reserve.
bool is_coronary(const Metrics& metrics);

/// How the case stands, as an HTML notice; empty when it is done, or nothing is known of it.
std::string status_notice(const Metrics& metrics);

/// The headline numbers as HTML cards; of a case without a result, only what the images show, and
/// of one without a lesion, the trial as such.
std::string headline(const Metrics& metrics);

/// The stenoses as one HTML table, a row each, the most severe first; bounds where a throat is
/// narrower than a voxel. Empty for an empty text. @throws InputError if it is no JSON array
std::string lesion_table(const std::string& text);

/// The run as HTML: version, backend and so on, and a row per stage where run.json tells of them.
/// Empty for an empty text. @throws InputError if it is no JSON object
std::string run_tables(const std::string& text);

}  // namespace angio::viewer::detail
