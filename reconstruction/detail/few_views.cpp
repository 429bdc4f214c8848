#include "reconstruction/detail/few_views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "reconstruction/detail/line_integrals.hpp"
#include "reconstruction/detail/total_variation.hpp"
#include "reconstruction/detail/vessel_pictures.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kWidestVesselMm = 12.0;  ///< that is told from its background
constexpr double kMayMiss = 0.1;          ///< of the frames
constexpr int kMostIterations = 40;
constexpr double kStill = 0.01;
constexpr int kSmoothingSteps = 8;
constexpr int kFramesInSubset = 4;
constexpr double kSeen = 2.0;  ///< of the noise: a line integral that tells of a vessel

/// A frame's values on its plane, lines along v one behind the other.
template <class Value, class From>
void turn_over(const PlaneGrid& plane, const From& from, Value* to) {
  for (int j = 0; j < plane.v_count; ++j)
    for (int i = 0; i < plane.u_count; ++i)
      to[std::size_t(i) * std::size_t(plane.v_count) + std::size_t(j)] = from(i, j);
}

void take_frame(VesselPicture picture, const RotationalRun& run, const Orbit& orbit,
                std::size_t index, const PlaneGrid& plane, VesselFrames& frames) {
  const angiogram::ConeBeamFrame& frame = run.frames[index];
  const PlaneFrame place = place_on_plane(frame, orbit, index, plane);
  const PlaneMap map = plane_map(frame, orbit, index, plane);
  const std::vector<float> values = bring_onto_plane(picture.line_integrals.data(), map, plane);
  const std::vector<float> mask(picture.is_vessel.begin(), picture.is_vessel.end());
  const std::vector<float> seen = bring_onto_plane(mask.data(), map, plane);
  const auto at = [&](int i, int j) {
    return std::size_t(j) * std::size_t(plane.u_count) + std::size_t(i);
  };
  const std::size_t first = index * frames.pictures.per_frame();
  const double radius = double(place.radius);
  turn_over(
      plane,
      [&](int i, int j) {
        const double u = double(place.first_u) + i * plane.sample_mm,
                     v = double(place.first_v) + j * plane.sample_mm - double(place.height);
        const double across = std::hypot(radius, u);
        return values[at(i, j)] * float(across / std::hypot(across, v));
      },
      frames.pictures.values.data() + first);
  turn_over(
      plane, [&](int i, int j) { return std::uint8_t(seen[at(i, j)] > 0.5F); },
      frames.is_vessel.data() + first);
  frames.pictures.places[index] = place;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Frames in subsets whose members lie as far apart as the run allows.
std::vector<std::vector<int>> subsets_of(int frames) {
  const int count = std::max(1, frames / kFramesInSubset);
  std::vector<std::vector<int>> subsets(static_cast<std::size_t>(count));
  for (int f = 0; f < frames; ++f) subsets[std::size_t(f % count)].push_back(f);
  return subsets;
}

/// y - A x of some frames, in place of A x.
std::vector<float> left_over(const VesselFrames& frames, const ChosenVoxels& voxels,
                             const std::vector<float>& x, const std::vector<int>& which) {
  std::vector<float> samples = project(voxels, x, frames.pictures, which);
  const std::size_t per_frame = frames.pictures.per_frame();
  parallel_for(std::ptrdiff_t(which.size()), [&](std::ptrdiff_t n) {
    const float* y = frames.pictures.values.data() + std::size_t(which[std::size_t(n)]) * per_frame;
    float* s = samples.data() + std::size_t(n) * per_frame;
    for (std::size_t i = 0; i < per_frame; ++i) s[i] = y[i] - s[i];
  });
  return samples;
}

/// 1 / (A'A 1), and their mean.
struct Steps {
  std::vector<float> of_voxel;
  double mean = 0.0;
};
Steps make_steps(const VesselFrames& frames, const ChosenVoxels& voxels,
                 const std::vector<int>& all) {
  const std::vector<float> one(voxels.count, 1.0F);
  Steps steps{
      project_back(voxels, project(voxels, one, frames.pictures, all), frames.pictures, all), 0.0};
  const float least = 1e-3F * *std::max_element(steps.of_voxel.begin(), steps.of_voxel.end());
  for (float& value : steps.of_voxel) {
    value = 1.0F / std::max(value, least);
    steps.mean += double(value) / double(voxels.count);
  }
  return steps;
}

/// Of the samples that see the vessels that were found.
double residual_of(const VesselFrames& frames, const ChosenVoxels& voxels,
                   const std::vector<float>& x, const std::vector<int>& all) {
  double squares = 0.0;
  std::size_t count = 0;
  for (const int f : all) {
    const std::vector<float> seen = project(voxels, x, frames.pictures, {f});
    const float* y = frames.pictures.values.data() + std::size_t(f) * frames.pictures.per_frame();
    for (std::size_t i = 0; i < seen.size(); ++i)
      if (double(seen[i]) > kSeen * frames.noise) {
        squares += double(y[i] - seen[i]) * double(y[i] - seen[i]);
        ++count;
      }
  }
  return std::sqrt(squares / double(std::max<std::size_t>(count, 1)));
}

}  // namespace

VesselFrames read_vessel_frames(const RotationalRun& run, double air, const Orbit& orbit,
                                const PlaneGrid& plane, const Progress& progress) {
  const int count = int(run.frames.size());
  const angiogram::ConeBeamFrame& first = run.frames.front();
  VesselFrames frames;
  frames.pictures.u_count = plane.u_count;
  frames.pictures.v_count = plane.v_count;
  frames.pictures.places.resize(std::size_t(count));
  frames.pictures.values.resize(frames.pictures.per_frame() * std::size_t(count));
  frames.is_vessel.resize(frames.pictures.values.size());
  std::vector<double> noise(static_cast<std::size_t>(count));
  const std::size_t pixels = std::size_t(first.columns) * std::size_t(first.rows);
  constexpr int kAtATime = 8;
  for (int from = 0; from < count; from += kAtATime) {
    const int number = std::min(kAtATime, count - from);
    progress.report(double(from) / count,
                    fmt::format("taking the background out, frame {} of {}", from + 1, count));
    const std::vector<float> integrals = read_line_integrals(run, from, number, air);
    parallel_for_uneven(number, [&](std::ptrdiff_t n) {
      const std::size_t index = std::size_t(from) + std::size_t(n);
      const auto begin = integrals.begin() + std::ptrdiff_t(std::size_t(n) * pixels);
      VesselPicture picture =
          vessels_of({begin, begin + std::ptrdiff_t(pixels)}, first.columns, first.rows,
                     kWidestVesselMm / plane.sample_mm, run.masks != nullptr);
      noise[index] = picture.noise;
      take_frame(std::move(picture), run, orbit, index, plane, frames);
    });
  }
  frames.noise = median(std::move(noise));
  return frames;
}

ChosenVoxels choose_voxels(const VesselFrames& frames, const ColumnGrid& grid) {
  const FrameStack& stack = frames.pictures;
  const int may_miss = int(kMayMiss * double(stack.places.size()));
  std::vector<std::vector<VoxelRun>> found(static_cast<std::size_t>(grid.j_count));
  parallel_for_uneven(grid.j_count, [&](std::ptrdiff_t j) {
    std::vector<int> missed(static_cast<std::size_t>(grid.k_count));
    const float y = grid.first_y + float(j) * grid.voxel;
    for (int i = 0; i < grid.i_count; ++i) {
      const float x = grid.first_x + float(i) * grid.voxel;
      if (x * x + y * y > grid.field_radius * grid.field_radius) continue;
      std::fill(missed.begin(), missed.end(), 0);
      for (std::size_t f = 0; f < stack.places.size(); ++f) {
        const ColumnView view = view_column(stack.places[f], x, y);
        const int u = int(std::lround(view.u));
        if (u < 0 || u >= stack.u_count) continue;
        const std::uint8_t* line = frames.is_vessel.data() + f * stack.per_frame() +
                                   std::size_t(u) * std::size_t(stack.v_count);
        for (int k = 0; k < grid.k_count; ++k) {
          const int v = int(view.v + view.v_per_mm * (grid.first_z + float(k) * grid.voxel) + 0.5F);
          missed[std::size_t(k)] += v >= 0 && v < stack.v_count && !line[v] ? 1 : 0;
        }
      }
      for (int k = 0; k < grid.k_count; ++k) {
        if (missed[std::size_t(k)] > may_miss) continue;
        auto& runs = found[std::size_t(j)];
        if (runs.empty() || runs.back().i != i || runs.back().first_k + runs.back().count != k)
          runs.push_back({i, int(j), k, 0, 0});
        ++runs.back().count;
      }
    }
  });
  ChosenVoxels voxels{grid, {}, 0};
  for (const auto& runs : found)
    for (VoxelRun run : runs) {
      run.offset = voxels.count;
      voxels.count += std::size_t(run.count);
      voxels.runs.push_back(run);
    }
  return voxels;
}

FewViews reconstruct_few_views(const VesselFrames& frames, const ChosenVoxels& voxels,
                               const Progress& progress) {
  FewViews result;
  result.values.assign(voxels.count, 0.0F);
  if (voxels.count == 0) return result;
  const int frame_count = int(frames.pictures.places.size());
  std::vector<int> all;
  for (int f = 0; f < frame_count; ++f) all.push_back(f);
  const auto subsets = subsets_of(frame_count);
  const Steps steps = make_steps(frames, voxels, all);
  const Neighbours beside = neighbours(voxels);
  const float strength =
      float(steps.mean * frames.noise * double(voxels.grid.voxel) * std::sqrt(double(frame_count)));
  std::vector<std::array<float, 3>> dual;
  for (int n = 0; n < kMostIterations && !result.has_converged; ++n) {
    progress.report(
        double(n) / kMostIterations,
        fmt::format("fitting the vessels to {} frames, iteration {}", frame_count, n + 1));
    const std::vector<float> before = result.values;
    for (const std::vector<int>& subset : subsets) {
      const std::vector<float> by = project_back(
          voxels, left_over(frames, voxels, result.values, subset), frames.pictures, subset);
      const float scale = float(frame_count) / float(subset.size());
      for (std::size_t v = 0; v < voxels.count; ++v)
        result.values[v] += scale * steps.of_voxel[v] * by[v];
      result.values =
          smooth_by_total_variation(result.values, strength, beside, kSmoothingSteps, dual);
    }
    double change = 0.0, size = 0.0;
    for (std::size_t v = 0; v < voxels.count; ++v) {
      const double step = double(result.values[v] - before[v]);
      change += step * step;
      size += double(result.values[v]) * double(result.values[v]);
    }
    result.iterations = n + 1;
    result.has_converged = change <= kStill * kStill * size;
  }
  result.residual = residual_of(frames, voxels, result.values, all);
  return result;
}

std::vector<float> in_columns(const ChosenVoxels& voxels, const std::vector<float>& values) {
  const ColumnGrid& g = voxels.grid;
  std::vector<float> columns(
      std::size_t(g.i_count) * std::size_t(g.j_count) * std::size_t(g.k_count), 0.0F);
  for (const VoxelRun& run : voxels.runs)
    std::copy_n(values.begin() + std::ptrdiff_t(run.offset), run.count,
                columns.begin() + std::ptrdiff_t((std::size_t(run.j) * std::size_t(g.i_count) +
                                                  std::size_t(run.i)) *
                                                     std::size_t(g.k_count) +
                                                 std::size_t(run.first_k)));
  return columns;
}

}  // namespace angio::reconstruction::detail
