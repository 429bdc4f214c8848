#include "segmentation/dicom_segmentation.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <system_error>

#include "core/atomic_file.hpp"
#include "core/child_process.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "segmentation/detail/dicom_load.hpp"
#include "segmentation/detail/dicom_series.hpp"
#include "segmentation/detail/segmentation_object.hpp"
#include "segmentation/detail/source_identity.hpp"
#include "segmentation/detail/volume_file.hpp"

namespace angio::segmentation {
namespace fs = std::filesystem;
namespace {

/// The box of voxels below zero and one voxel around it, in continuous indices.
struct IndexBox {
  Vec3 least{1e30, 1e30, 1e30};
  Vec3 most{-1e30, -1e30, -1e30};

  [[nodiscard]] bool contains(const Vec3& index) const {
    return index.x >= least.x && index.y >= least.y && index.z >= least.z && index.x <= most.x &&
           index.y <= most.y && index.z <= most.z;
  }
};

IndexBox lumen_box(const Volume<float>& level_set) {
  IndexBox box;
  const auto& size = level_set.geometry.size;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) {
        if (!(level_set.at(i, j, k) < 0.0f)) continue;
        const Vec3 index{double(i), double(j), double(k)};
        for (int axis = 0; axis < 3; ++axis) {
          box.least[axis] = std::min(box.least[axis], index[axis] - 1.0);
          box.most[axis] = std::max(box.most[axis], index[axis] + 1.0);
        }
      }
  for (int axis = 0; axis < 3; ++axis) {  // half a voxel beyond the grid belongs to its last voxel
    box.least[axis] = std::max(box.least[axis], -0.5);
    box.most[axis] = std::min(box.most[axis], double(size[std::size_t(axis)]) - 0.5);
  }
  return box;
}

/// The lumen on one source slice, 1 inside; empty if there is none of it.
std::vector<std::uint8_t> mask_on_slice(const Volume<float>& level_set, const IndexBox& box,
                                        const detail::DicomFrame& frame, int columns, int rows) {
  const VolumeGeometry& grid = level_set.geometry;
  const Vec3 origin = grid.index_from_lps(frame.position);
  const Vec3 step_i = grid.index_from_lps(frame.position + frame.spacing_i * frame.axis_i) - origin;
  const Vec3 step_j = grid.index_from_lps(frame.position + frame.spacing_j * frame.axis_j) - origin;
  std::vector<std::uint8_t> mask(std::size_t(columns) * std::size_t(rows), 0);
  bool any = false;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const Vec3 index = origin + double(i) * step_i + double(j) * step_j;
      if (!box.contains(index) || !(interpolate(level_set, grid.lps_from_index(index)) < 0.0))
        continue;
      mask[std::size_t(j) * std::size_t(columns) + std::size_t(i)] = 1;
      any = true;
    }
  if (!any) mask.clear();
  return mask;
}

detail::SegmentationFrames resample_to(const detail::DicomSeries& series,
                                       const Volume<float>& level_set) {
  const IndexBox box = lumen_box(level_set);
  const detail::DicomHeader& first = series.headers.front();
  const detail::DicomFrame& place = series.frame(series.slices.front());
  detail::SegmentationFrames frames;
  frames.rows = first.pixels.rows;
  frames.columns = first.pixels.columns;
  frames.spacing_i = place.spacing_i;
  frames.spacing_j = place.spacing_j;
  frames.thickness = series.stack.geometry.spacing.z;
  frames.axis_i = place.axis_i;
  frames.axis_j = place.axis_j;
  frames.source_series_uid = first.series_uid;
  std::vector<std::vector<std::uint8_t>> masks(series.slices.size());
  parallel_for(std::ptrdiff_t(masks.size()), [&](std::ptrdiff_t k) {
    masks[std::size_t(k)] = mask_on_slice(
        level_set, box, series.frame(series.slices[std::size_t(k)]), frames.columns, frames.rows);
  });
  for (std::size_t k = 0; k < masks.size(); ++k) {
    if (masks[k].empty()) continue;
    const detail::SliceReference& slice = series.slices[k];
    const detail::DicomHeader& header = series.headers[std::size_t(slice.header)];
    frames.planes.push_back({series.frame(slice).position,
                             {header.sop_class_uid, header.instance_uid},
                             header.multi_frame_object ? slice.frame : -1});
    frames.masks.push_back(std::move(masks[k]));
  }
  return frames;
}

/// The slices of a mask that hold some of it.
detail::SegmentationFrames slices_of(const Volume<std::uint8_t>& mask) {
  const VolumeGeometry& grid = mask.geometry;
  const auto axis = [&](int column) {
    const Vec3 unit{column == 0 ? 1.0 : 0.0, column == 1 ? 1.0 : 0.0, 0.0};
    return normalized(grid.lps_from_index(unit) - grid.lps_from_index({}));
  };
  detail::SegmentationFrames frames;
  frames.rows = grid.size[1];
  frames.columns = grid.size[0];
  frames.spacing_i = grid.spacing.x;
  frames.spacing_j = grid.spacing.y;
  frames.thickness = grid.spacing.z;
  frames.axis_i = axis(0);
  frames.axis_j = axis(1);
  const std::size_t pixel_count = std::size_t(frames.rows) * std::size_t(frames.columns);
  for (int k = 0; k < grid.size[2]; ++k) {
    const auto first = mask.values.begin() + std::ptrdiff_t(std::size_t(k) * pixel_count);
    const auto last = first + std::ptrdiff_t(pixel_count);
    if (std::find(first, last, std::uint8_t(1)) == last) continue;
    frames.planes.push_back({grid.lps_from_index({0.0, 0.0, double(k)}), {}, -1});
    frames.masks.emplace_back(first, last);
  }
  return frames;
}

/// Writes it so that it appears at once and only its owner can read it.
///
/// @param sources  files that `identity` reads
void write_object(const fs::path& path, const detail::SegmentationFrames& frames,
                  const std::vector<fs::path>& sources,
                  const std::function<dicom::StudyIdentity(const std::string& seed)>& identity) {
  write_atomically(path, [&](const fs::path& temporary) {
    const std::size_t frame_bytes = frames.masks.front().size() * frames.masks.size();
    detail::prepare_dcmtk();
    ChildLimits limits{(std::size_t(1) << 30) + 8 * frame_bytes, 600, 600};
    limits.reach.read = sources;
    limits.reach.write = {fs::absolute(temporary).parent_path()};
    limits.written_bytes = (std::uint64_t(256) << 20) + 2 * frame_bytes;
    const ChildResult result = run_guarded(
        limits,
        [&](ChildOutput&) {
          const std::string seed = detail::seed_of(frames);
          detail::write_segmentation_object(temporary, frames, identity(seed), seed);
        },
        [](ChildInput&) {});
    if (result.end == ChildEnd::refused) throw IoError(result.message);
    if (result.end != ChildEnd::done)
      throw IoError("could not write " + path.string() +
                    " (the source's headers are damaged, or memory is short). Is the disk full?");
    fs::permissions(temporary, fs::perms::owner_read | fs::perms::owner_write);
  });
}

/// @param options  of reading; a voxel size that the user gave is no place in the patient, so that
/// a
///                 source without one is refused
detail::DicomSeries source_series(const fs::path& source, ReadOptions options) {
  options.spacing_mm = {};
  if (detail::is_volume_file_name(source) && !fs::is_directory(source))
    throw InputError("a DICOM segmentation needs a DICOM source (" + source.filename().string() +
                     " has no UIDs to refer to). Take lumen_mask.nrrd instead");
  detail::FoundSeries found = detail::find_series(source, options);
  if (found.all.empty())
    throw InputError(
        "the source of the segmentation holds no DICOM. Give the folder of its series");
  return std::move(found.all[detail::choose_series(found.all, options)]);
}

}  // namespace

void write_dicom_segmentation(const fs::path& path, const Volume<float>& level_set,
                              const fs::path& source, const ReadOptions& source_options,
                              const DicomSegmentationOptions& options) {
  const detail::DicomSeries series = source_series(source, source_options);
  const detail::SegmentationFrames frames = resample_to(series, level_set);
  if (frames.masks.empty())
    throw InputError(
        "the lumen holds no pixel centre of the source (it lies elsewhere, or is thinner than a "
        "pixel). Check that the segmentation was made from this source");
  write_object(path, frames, {series.headers.front().source.path}, [&](const std::string& seed) {
    const dicom::StudyIdentity identity =
        detail::source_identity(series.headers.front().source, seed);
    return options.keep_patient ? identity : detail::without_patient(identity);
  });
}

void write_dicom_segmentation(const fs::path& path, const Volume<std::uint8_t>& mask,
                              const dicom::StudyIdentity& identity) {
  const detail::SegmentationFrames frames = slices_of(mask);
  if (frames.masks.empty())
    throw InputError("the mask holds no lumen, so that there is no segmentation to write");
  write_object(path, frames, {}, [&](const std::string&) { return identity; });
}

}  // namespace angio::segmentation
