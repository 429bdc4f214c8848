#pragma once

#include <memory>

#include "centerline/centerline.hpp"
#include "core/triangle_mesh.hpp"
#include "pipeline/case/stage_files.hpp"

namespace angio::pipeline {

/// What a case's data can show: a scan by its voxels, a surface by its triangles.
struct Resolution {
  double longest_mm = 0.0;  ///< edge of a voxel. Narrower throats are seen, but not measured
  double mean_mm = 0.0;     ///< edge of a cube of a voxel's volume
  std::shared_ptr<const TriangleMesh> surface;  ///< null: there are voxels
};

/// Of the scan or the surface that the case's lumen was found in.
Resolution case_resolution(const StageFiles& files);
/// What that reads.
std::vector<std::string> resolution_files();

/// The settings for lesions, with what the data can show.
centerline::LesionOptions lesion_options(centerline::LesionOptions options,
                                         const Resolution& resolution);

/// The same for the whole tree, wherever the settings want to look.
centerline::LesionOptions whole_tree(centerline::LesionOptions options);

/// The narrowest vessel that a surface shows around a place: of six vertices around, so two of its
/// edges wide. The edges are the median of those within `reach` [mm], or of the nearest triangle.
double least_diameter_shown(const TriangleMesh& surface, const Vec3& place, double reach);

}  // namespace angio::pipeline
