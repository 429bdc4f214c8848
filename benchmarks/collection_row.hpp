#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "testing/pipeline/reading.hpp"

/// A row of the collection's table. docs/collection.md says by which rules the columns are counted.
namespace angio {

/// Of the lines against their wall.
struct RowLines {
  int count = 0, points = 0, outside = 0, sharp_steps = 0, sharp_turns = 0;
  double inside_percent = 0.0, radius_error_95_percent = 0.0, radius_off_percent = 0.0;
  double too_long_percent = 0.0;
};

/// Of the frames of a simulation.
struct RowSimulation {
  int frames = 0, crossing_frames = 0;
  double max_penetration_mm = 0.0, air_percent = 0.0;  ///< of the frames that had their air mesh
};

struct CollectionRow {
  std::string name, split, certainty, status;
  int exit_code = 0;
  double wall_s = 0.0, cpu_s = 0.0;
  std::optional<RowLines> lines;  ///< unset: there are none
  std::optional<RowSimulation> simulation;
  std::optional<int>
      ends_read;  ///< unset: not counted by the reader, or nothing was asked of lines
  int ends_found = 0, ends_of_lines = 0;
  bool ends_by_place = false;        ///< otherwise by number only
  std::optional<bool> inlet_right;   ///< unset: not read
  std::optional<int> stenoses_read;  ///< unset: not read
  int stenoses_found = 0, stenoses_wrong = 0;

  [[nodiscard]] bool is_certain() const { return certainty != "low"; }
};

/// Lines, simulation and status, from the case folder.
void judge_run(const std::filesystem::path& case_folder, CollectionRow& row);

/// Ends, inlet and stenoses against the reading. A case without lines has found none of them.
void judge_against(const Reading& reading, const std::filesystem::path& case_folder,
                   const std::filesystem::path& input, CollectionRow& row);

extern const char* const kCollectionHeader;
std::string csv_line(const CollectionRow& row);

std::string markdown_head();
/// What misses the bar is bold.
std::string markdown_line(const CollectionRow& row);
/// The bars over all rows: of the readings that are certain, and of all.
std::string summary(const std::vector<CollectionRow>& rows);

}  // namespace angio
