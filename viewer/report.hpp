#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "angiogram/cone_beam.hpp"
#include "angiogram/working_view.hpp"
#include "core/centerline.hpp"
#include "core/progress.hpp"
#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"
#include "viewer/doubts.hpp"

namespace angio::viewer {

/// A diameter along the lesion's line, before, at peak or after; not a number where a section
/// misses the lumen.
struct DiameterProfile {
  std::vector<double> abscissa_mm;
  std::vector<double> inscribed_diameter_mm;
  std::vector<double> equivalent_diameter_mm;
};

/// Fractional flow reserve along the lesion's line, and one standard deviation to both sides.
struct FlowProfile {
  std::vector<double> ffr, low, high;
};

/// What the balloon measures alone, by its chart; may be empty.
struct BalloonChart {
  std::vector<double> pressure_atm, diameter_mm;  ///< shape [point]
};

/// Columns of timeseries.csv, by the names of docs/contract.md.
struct TimeSeries {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

/// A moment of the inflation, for a picture.
struct Moment {
  std::string title;  ///< "Before", "At peak, 8.0 atm", "After"
  TriangleMesh balloon;
  TriangleMesh wall;                         ///< the region that moved
  std::vector<double> contact_pressure_kpa;  ///< per wall vertex
  std::vector<Vec3> guidewire;               ///< nodes inside the balloon; may be empty
};

/// A written frame of the simulation, for the scene.
struct CourseFrame {
  double time_s = 0.0;
  std::string phase;
  double pressure_atm = 0.0;
  bool is_peak = false;
  Moment shape;  ///< the same triangles in each frame
};

/// A virtual angiogram.
struct Angiogram {
  std::string title;                 ///< "Before, LAO 32 CRA 15"
  double pixel_mm = 1.0;             ///< > 0
  int pixels = 0;                    ///< to a side
  std::vector<double> transmission;  ///< of the beam, [0, 1], rows from the top
};

/// A frame that the case was reconstructed from.
struct XrayPicture {
  std::string title;               ///< "Frame 57, LAO 32"
  angiogram::ConeBeamFrame place;  ///< where its pixels lie
  std::vector<float> attenuation;  ///< line integrals, shape [place.rows, place.columns]
  bool is_subtracted = false;      ///< contrast medium alone
};

/// How a C-arm sees the case.
struct CArmViews {
  std::optional<angiogram::WorkingView> working;
  std::vector<Angiogram> angiograms;
};

struct ReportContent {
  std::string title;       ///< case name; no identity
  std::string input_kind;  ///< "volume", "surface", "phantom" or "run"; empty: not told
  std::string version;
  std::optional<Volume<float>> volume;     ///< unset when the input was a surface
  std::optional<Volume<float>> level_set;  ///< signed distance [mm], on a grid of its own
  TriangleMesh lumen;                      ///< open lumen mesh, whole tree
  CenterlineTree tree;
  int lesion_path = 0;  ///< CenterlineIds of the line through the lesion
  double lesion_abscissa_mm = 0.0;
  std::vector<Moment> moments;      ///< before, at peak, after
  std::vector<Moment> sequence;     ///< the whole course, for one picture; may be empty
  std::vector<CourseFrame> course;  ///< the whole course, for the scene; may be empty
  DiameterProfile before, peak, after;
  std::vector<double> flow_abscissa_mm;  ///< of the flow's profiles; empty: there are none
  FlowProfile flow_before, flow_after;
  CArmViews views;
  std::vector<XrayPicture> frames;  ///< all of one size; may be empty
  BalloonChart balloon_chart;
  TimeSeries time_series;
  std::string metrics_json;    ///< metrics.json, shown as tables
  std::string lesions_json;    ///< lesions.json: a row per stenosis; may be empty
  std::string run_json;        ///< run.json: stages, seconds, memory
  std::vector<Doubts> doubts;  ///< the result's own first: they stand beside it
};

/// Renders the pictures and writes the report: index.html, one file, opens offline; every picture
/// and chart (SVG) is inside. Also leaves the pictures as PNG beside it, and the chart of friction
/// and adhesion as corrections.svg.
/// @throws Error (69) if nothing can render here, saying what to install
void write_report(const std::filesystem::path& folder, const ReportContent& content,
                  const Progress& progress = {});

/// A frame that a collection lists, by the number in its files' names.
struct FrameTime {
  int frame = 0;
  double time_s = 0.0;
};
/// Nine places among a simulation's frames, as in the seed paper's figures: the start, five steps
/// to the peak, and three to the end. Ascending; some are the same where there are few frames.
/// @param peak  its place, less than frame_count
std::vector<std::size_t> sequence_places(std::size_t frame_count, std::size_t peak);

std::vector<FrameTime> read_frame_times(const std::filesystem::path& path);  ///< ascending

}  // namespace angio::viewer
