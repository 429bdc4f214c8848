#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"
#include "viewer/report.hpp"

/// A case folder as the desktop viewer needs it.
namespace angio::viewer::detail {

/// The files of one written frame.
struct FrameFiles {
  int frame = 0;  ///< as in timeseries.csv
  double time_s = 0.0;
  std::filesystem::path balloon;
  std::filesystem::path vessel;
  std::filesystem::path guidewire;  ///< where it lies in all frames, if it does not move
  std::filesystem::path tissue;     ///< the layered wall; empty without
};

struct CaseData {
  std::optional<Volume<float>> scan;
  TriangleMesh lumen;
  std::vector<CenterlinePath> paths;  ///< points, radius and abscissa only
  std::vector<FrameFiles> frames;     ///< in order of time; empty before the simulation has run
  TimeSeries series;
};

/// @throws InputError (66) if the folder is no case, or has no lumen yet
void check_case(const std::filesystem::path& folder);

/// Reads what is there; only the lumen must be. The frames are those of simulation/, or of the run
/// under way if that wrote its list later.
///
/// @throws InputError (66) as check_case
CaseData read_case(const std::filesystem::path& folder);

/// The folder whose simulation.pvd was written last: simulation/, or that of a run under way
/// (.simulation.tmp-PID). Empty if neither has one.
std::filesystem::path simulation_folder(const std::filesystem::path& case_folder);

/// The lines of centerlines.vtp from the inlet to each outlet: points, radius and abscissa only.
std::vector<CenterlinePath> read_paths(const std::filesystem::path& file);

/// The frames listed in a ParaView collection whose file names begin with "balloon" and "vessel".
std::vector<FrameFiles> read_frame_list(const std::filesystem::path& collection);

/// A table without quotes.
TimeSeries read_time_series(const std::filesystem::path& csv);

/// The row of a frame in the table; nothing if it has none.
std::optional<std::size_t> row_of(const TimeSeries& series, int frame);

/// Places in `frames`: the one nearest to a frame number; the one of the highest pressure.
std::size_t nearest_frame(const std::vector<FrameFiles>& frames, int frame);
std::size_t peak_frame(const CaseData& data);

/// "frame 120   3.000 s   inflate   5.2 atm ..."; what the table does not know is left out.
std::string describe_frame(const CaseData& data, const FrameFiles& files);

}  // namespace angio::viewer::detail
