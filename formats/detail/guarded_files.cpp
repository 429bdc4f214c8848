#include "formats/detail/guarded_files.hpp"

#include <algorithm>
#include <cstdint>
#include <system_error>
#include <type_traits>
#include <utility>

#include "core/child_process.hpp"
#include "core/error.hpp"
#include "formats/detail/surface_cleanup.hpp"
#include "formats/detail/xml_files.hpp"

namespace angio::formats::detail {
namespace fs = std::filesystem;
namespace {

// ---- what crosses from the child ---------------------------------------------------------------

struct Putter {
  ChildOutput& output;

  template <class Value>
  void operator()(const Value& value) const {
    output.put(value);
  }
  void operator()(const std::vector<DataArray>& arrays) const;
  void operator()(const std::vector<std::vector<int>>& lists) const {
    output.put(std::uint64_t(lists.size()));
    for (const auto& list : lists) output.put(list);
  }
};

struct Getter {
  ChildInput& input;

  template <class Value>
  void operator()(Value& value) const {
    input.get(value);
  }
  void operator()(std::vector<DataArray>& arrays) const;
  void operator()(std::vector<std::vector<int>>& lists) const {
    std::uint64_t count = 0;
    input.get(count);
    for (std::uint64_t i = 0; i < count; ++i) input.get(lists.emplace_back());
  }
};

template <class Array, class Side>
void cross_array(Array& array, const Side& side) {
  side(array.name);
  side(array.values);
  side(array.component_count);
  side(array.type);
}

void Putter::operator()(const std::vector<DataArray>& arrays) const {
  output.put(std::uint64_t(arrays.size()));
  for (const DataArray& array : arrays) cross_array(array, *this);
}

void Getter::operator()(std::vector<DataArray>& arrays) const {
  std::uint64_t count = 0;
  input.get(count);
  for (std::uint64_t a = 0; a < count; ++a) cross_array(arrays.emplace_back(), *this);
}

/// Every field of a file, for the side that puts or the one that gets.
template <class Data, class Side>
void cross(Data& data, const Side& side) {
  using Kind = std::remove_const_t<Data>;
  if constexpr (std::is_same_v<Kind, ParsedSurface>) {
    side(data.data.mesh.vertices);
    side(data.data.mesh.triangles);
    side(data.data.unit);
    side(data.in_ras);
    side(data.data.point_arrays);
    side(data.data.cell_arrays);
  } else {
    if constexpr (std::is_same_v<Kind, PolylineData>) {
      side(data.points);
      side(data.lines);
    } else if constexpr (std::is_same_v<Kind, TetData>) {
      side(data.mesh.vertices);
      side(data.mesh.tets);
      side(data.boundary);
    } else {
      side(data.points);
      side(data.wedges);
    }
    side(data.point_arrays);
    side(data.cell_arrays);
  }
}

// ---- the child ---------------------------------------------------------------------------------

/// Numbers are packed, and held as float64 twice.
ChildLimits limits_for(const std::vector<fs::path>& paths) {
  std::size_t largest = 0, all = 0;
  for (const fs::path& path : paths) {
    std::error_code ignored;
    const auto size = std::size_t(fs::file_size(path, ignored));
    const std::size_t bytes = ignored ? 0 : std::min(size, std::size_t(1) << 36);
    largest = std::max(largest, bytes);
    all += bytes;
  }
  constexpr std::size_t kMostPerByte = 128;
  constexpr std::size_t kBytesPerSecond = std::size_t(1) << 20;
  ChildLimits limits;
  limits.memory_bytes = (std::size_t(1) << 30) + kMostPerByte * largest;
  limits.cpu_seconds = 120 + int(all / kBytesPerSecond);
  limits.silent_seconds = limits.cpu_seconds;
  limits.reach.read = paths;
  limits.handed_bytes = limits.memory_bytes;
  return limits;
}

/// Why a child that read files came to its end over one of them.
std::string failure_text(const ChildResult& result, const fs::path& path) {
  switch (result.end) {
    case ChildEnd::refused:
      return result.message;
    case ChildEnd::out_of_memory:
      return path.string() +
             " asks for more memory than it can hold (it is damaged, or memory is short). Write it "
             "again, or close programs";
    case ChildEnd::timed_out:
      return path.string() +
             " takes minutes to read (it is damaged, or on a slow disk). Copy it again";
    default:
      return path.string() + " is damaged beyond reading. Write it again";
  }
}

/// Each file's data goes to `take`, in order.
template <class Data, class Take>
void read_guarded(const std::vector<fs::path>& paths, Data (*parse)(const fs::path&),
                  const Take& take) {
  // What is not there, or empty, is said without a child, and with a code of its own.
  for (const fs::path& path : paths) require_input(path);
  if (paths.empty()) return;
  std::size_t under_way = 0;
  const ChildResult result = run_guarded(
      limits_for(paths),
      [&](ChildOutput& output) {
        for (const fs::path& path : paths) {
          const Data parsed = parse(path);
          cross(parsed, Putter{output});
          output.flush();
        }
      },
      [&](ChildInput& input) {
        for (; under_way < paths.size(); ++under_way) {
          Data data;
          cross(data, Getter{input});
          take(std::move(data));
        }
      });
  if (result.end != ChildEnd::done)
    throw InputError(failure_text(result, paths[std::min(under_way, paths.size() - 1)]));
}

template <class Data>
Data read_guarded(const fs::path& path, Data (*parse)(const fs::path&)) {
  Data data;
  read_guarded<Data>({path}, parse, [&](Data&& read) { data = std::move(read); });
  return data;
}

}  // namespace

void read_vtp_surfaces(const std::vector<fs::path>& paths,
                       const std::function<void(ParsedSurface&&)>& take) {
  read_guarded<ParsedSurface>(paths, parse_vtk_surface, take);
}

ParsedSurface read_vtk_surface(const fs::path& path) {
  return read_guarded(path, parse_vtk_surface);
}

std::vector<PolylineData> read_vtp_polylines(const std::vector<fs::path>& paths) {
  std::vector<PolylineData> all;
  read_guarded<PolylineData>(paths, parse_vtp_polylines,
                             [&](PolylineData&& data) { all.push_back(std::move(data)); });
  return all;
}

TetData read_vtu_tets(const fs::path& path) { return read_guarded(path, parse_vtu_tets); }

WedgeData read_vtu_wedges(const fs::path& path) { return read_guarded(path, parse_vtu_wedges); }

}  // namespace angio::formats::detail
