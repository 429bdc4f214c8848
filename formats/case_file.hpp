#pragma once

/// Where the files of a case lie in its folder, for all who write and read them. docs/contract.md
/// says what is in them.
namespace angio::formats::case_file {

inline constexpr const char* kRun = "run.json";
inline constexpr const char* kMetrics = "metrics.json";
inline constexpr const char* kSettings = "case.toml";

inline constexpr const char* kReconstructed = "reconstruction/volume.nrrd";
inline constexpr const char* kGeometry = "reconstruction/geometry.xml";
inline constexpr const char* kQuality = "reconstruction/quality.json";
inline constexpr const char* kShownFrames = "reconstruction/frames.nrrd";
inline constexpr const char* kShownPlaces = "reconstruction/frames.json";
/// Of views alone.
inline constexpr const char* kFittedLines = "reconstruction/centerlines.vtp";

inline constexpr const char* kScan = "segmentation/volume.nrrd";
inline constexpr const char* kLevelSet = "segmentation/lumen_level_set.nrrd";
/// Of a scan, if there are such places.
inline constexpr const char* kNarrowPlaces = "segmentation/narrow_places.json";
inline constexpr const char* kGivenLumen = "segmentation/lumen_surface.vtp";

inline constexpr const char* kCenterlines = "centerline/centerlines.vtp";
inline constexpr const char* kLesions = "centerline/lesions.json";
inline constexpr const char* kNarrowedLumen = "centerline/narrowed_lumen.vtp";

inline constexpr const char* kLumen = "meshing/lumen.vtp";
inline constexpr const char* kBalloon = "meshing/balloon.vtp";
inline constexpr const char* kGuidewire = "meshing/guidewire.vtp";
inline constexpr const char* kRegion = "meshing/region.vtp";
inline constexpr const char* kAir = "meshing/air.vtu";
inline constexpr const char* kLayeredWall = "meshing/wall.vtu";
inline constexpr const char* kPlacement = "meshing/placement.json";

inline constexpr const char* kFrameList = "simulation/simulation.pvd";
inline constexpr const char* kFrames = "simulation/frames/";  // a folder
inline constexpr const char* kTimeSeries = "simulation/timeseries.csv";
inline constexpr const char* kProfile = "simulation/lumen_profile.csv";
inline constexpr const char* kLumenAfter = "simulation/lumen_after.vtp";
inline constexpr const char* kSummary = "simulation/summary.json";
inline constexpr const char* kDiagnosis = "simulation/diagnosis.json";

inline constexpr const char* kFlow = "report/flow.csv";
inline constexpr const char* kReport = "report/index.html";

}  // namespace angio::formats::case_file
