#include "reconstruction/detail/read_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/error.hpp"
#include "reconstruction/detail/collimator.hpp"
#include "reconstruction/detail/line_integrals.hpp"
#include "reconstruction/detail/vessel_pictures.hpp"

namespace angio::reconstruction {
namespace detail {

ViewPicture read_view(const RotationalRun& run, int index, double air, double widest_mm,
                      std::vector<char> covered) {
  const angiogram::ConeBeamFrame& frame = run.frames[std::size_t(index)];
  std::vector<float> integrals = read_line_integrals(run, index, 1, air);
  OpenField open = open_field(integrals, frame.columns, frame.rows);
  const OpenField given = around_open(covered, frame.columns, frame.rows);
  open = {std::max(open.first_column, given.first_column),
          std::min(open.last_column, given.last_column), std::max(open.first_row, given.first_row),
          std::min(open.last_row, given.last_row)};
  if (open.first_column > open.last_column || open.first_row > open.last_row)
    throw InputError(fmt::format("view {}: its shutter covers all of it. Give another", index + 1));
  cover_shutter(integrals.data(), frame.columns, frame.rows, open);
  VesselPicture picture = vessels_of(std::move(integrals), frame.columns, frame.rows,
                                     widest_mm / pixel_at_isocentre(frame), run.masks != nullptr);
  covered.resize(picture.line_integrals.size(), 0);
  for (int row = 0; row < frame.rows; ++row)
    for (int c = 0; c < frame.columns; ++c)
      if (c < open.first_column || c > open.last_column || row < open.first_row ||
          row > open.last_row)
        covered[std::size_t(row) * std::size_t(frame.columns) + std::size_t(c)] = 1;
  return make_view_picture(frame, std::move(picture.line_integrals), covered, widest_mm);
}

}  // namespace detail

OpenField around_open(const std::vector<char>& covered, int columns, int rows) {
  if (covered.empty()) return {0, columns - 1, 0, rows - 1};
  OpenField open{columns, -1, rows, -1};
  for (int row = 0; row < rows; ++row)
    for (int c = 0; c < columns; ++c) {
      if (covered[std::size_t(row) * std::size_t(columns) + std::size_t(c)] != 0) continue;
      open = {std::min(open.first_column, c), std::max(open.last_column, c),
              std::min(open.first_row, row), std::max(open.last_row, row)};
    }
  return open;
}

}  // namespace angio::reconstruction
