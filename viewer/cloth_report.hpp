#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/progress.hpp"
#include "core/triangle_mesh.hpp"
#include "viewer/doubts.hpp"

namespace angio::viewer {

/// A state of the seed paper's cloth, which lies in the plane z = 0.
struct ClothMoment {
  std::string title;  ///< "+35 %"
  TriangleMesh mesh;
  std::vector<double> thickness_mm;  ///< per vertex
};

struct ClothReport {
  std::string title;  ///< case name; no identity
  std::string version;
  std::vector<ClothMoment> moments;  ///< at least one; the first is the cloth at rest
  std::string metrics_json;          ///< metrics.json, shown as tables
  std::string run_json;              ///< run.json: stages, seconds, memory
  std::vector<Doubts> doubts;
};

/// Renders the cloth's mesh above its thickness, as the seed paper's Figure 5, and writes the
/// report: index.html, one file, opens offline; cloth.png beside it.
/// @throws Error (69) if nothing can render here, saying what to install
void write_cloth_report(const std::filesystem::path& folder, const ClothReport& content,
                        const Progress& progress = {});

}  // namespace angio::viewer
