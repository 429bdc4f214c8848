#include "formats/csv.hpp"

#include <string>

#include "fuzz/target.hpp"

/// A case's tables, and the cells of a manifest.
ANGIO_FUZZ_TARGET(csv) {
  angio::formats::parse_csv(std::string(bytes), ';');
  const auto table = angio::formats::read_csv_table(angio::fuzz::file_of(bytes, "table.csv"));
  for (const std::string& column : table.columns) static_cast<void>(table.numbers(column));
}
