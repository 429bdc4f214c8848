#pragma once

#include <optional>

#include "core/vec3.hpp"
#include "formats/files.hpp"
#include "pipeline/case/stage_files.hpp"

namespace angio::pipeline {

/// The standard deviation of the diameter of fitted vessels [mm]: twice that of the radius, linear
/// between points, at the place of the lines nearest to a throat.
/// @param fitted  with the point arrays TubeRadius and RadiusStandardDeviation
/// @return nothing where that place is farther than its radius (the throat is none of theirs), and
///         where the fit gave no number
std::optional<double> fitted_diameter_sd(const formats::PolylineData& fitted, const Vec3& throat);

/// The same of a case whose vessels were fitted to views; nothing of another, and where its lumen
/// was narrowed afterwards.
std::optional<double> throat_sd(const StageFiles& files, const Vec3& throat);

}  // namespace angio::pipeline
