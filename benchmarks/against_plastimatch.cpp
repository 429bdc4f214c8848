// The volume of a phantom's rotational run against plastimatch's `fdk` on the same frames: a full
// turn (plastimatch has no weights for shorter arcs), voxels of a pixel's size.
// docs/accuracy.md explains it.
//
//     against_plastimatch FOLDER [--markdown FILE]      (FOLDER: for the files that it exchanges)
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "angiogram/cone_beam.hpp"
#include "benchmarks/phantom_pictures.hpp"
#include "core/error.hpp"
#include "core/volume.hpp"
#include "datasets/rotational_run.hpp"
#include "reconstruction/reconstruction.hpp"
#include "segmentation/read_volume.hpp"
#include "testing/result_table.hpp"

namespace angio {
namespace {

namespace fs = std::filesystem;
using angiogram::ConeBeamFrame;
constexpr int kMargin = 2;  // of air, in widths of a frame

/// A full turn in even steps, without body (no row is cut off by the detector) and without noise.
datasets::RotationalRunOfPhantom make_run(const std::string& name) {
  datasets::PhantomOptions phantom;
  phantom.name = name;
  datasets::RotationalRunOptions run;
  run.frames = 360;
  run.arc_degrees = 359.0;
  run.noise = 0.0;
  run.body = false;
  return datasets::make_rotational_run(phantom, run);
}

/// What plastimatch reads beside a frame: the middle, a matrix from (x, y, z, 1) to pixels from
/// there, distances, the beam's direction, and the same as a rotation and a scaling.
std::string geometry_text(const ConeBeamFrame& frame, const angiogram::CArmMount& mount) {
  const auto m = angiogram::ConeBeamView(frame).matrix();
  const Vec3 beam = -1.0 * normalized(frame.source);
  const Vec3 right = normalized(frame.column_step), down = normalized(frame.row_step);
  std::string text = fmt::format("{:.9g} {:.9g}\n", mount.central_column, mount.central_row);
  const double middle[2] = {mount.central_column, mount.central_row};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t k = 0; k < 4; ++k)
      text += fmt::format("{:.9g}{}", row < 2 ? m[row][k] - middle[row] * m[2][k] : m[2][k],
                          k < 3 ? ' ' : '\n');
  text +=
      fmt::format("{:.9g}\n{:.9g}\n{:.9g} {:.9g} {:.9g}\nExtrinsic\n", mount.source_to_isocentre_mm,
                  mount.source_to_detector_mm, beam.x, beam.y, beam.z);
  for (const Vec3& axis : {right, down})
    text += fmt::format("{:.9g} {:.9g} {:.9g} 0\n", axis.x, axis.y, axis.z);
  return text + fmt::format(
                    "{:.9g} {:.9g} {:.9g} {:.9g}\n0 0 0 1\nIntrinsic\n{:.9g} 0 0 0\n0 {:.9g} "
                    "0 0\n0 0 {:.9g} 0\n",
                    beam.x, beam.y, beam.z, mount.source_to_isocentre_mm,
                    1.0 / mount.column_spacing_mm, 1.0 / mount.row_spacing_mm,
                    1.0 / mount.source_to_detector_mm);
}

/// Each frame's line integrals as NNNN.pfm, and its place as NNNN.txt. plastimatch filters a row as
/// if it closed to a ring, and rounds its pixels to whole numbers: a row gets as much air on both
/// sides, and a million is one.
void write_frames(const fs::path& folder, const datasets::RotationalRunOfPhantom& run, double air) {
  constexpr double kOne = 1e6;
  fs::create_directories(folder);
  const int columns = run.mount.columns, rows = run.mount.rows, margin = kMargin * columns;
  angiogram::CArmMount wide = run.mount;
  wide.columns += 2 * margin;
  wide.central_column += margin;
  for (std::size_t f = 0; f < run.frames.size(); ++f) {
    const std::uint16_t* pixel = run.pictures.data() + f * std::size_t(columns) * std::size_t(rows);
    std::vector<float> integrals(std::size_t(wide.columns) * std::size_t(rows), 0.0F);
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column)
        integrals[std::size_t(row) * std::size_t(wide.columns) + std::size_t(margin + column)] =
            float(kOne * std::log(air / std::max(1.0, double(*pixel++))));
    std::ofstream picture(folder / fmt::format("{:04}.pfm", f), std::ios::binary);
    picture << "Pf\n" << wide.columns << ' ' << rows << "\n-1\n";
    picture.write(reinterpret_cast<const char*>(integrals.data()),
                  std::streamsize(integrals.size() * sizeof(float)));
    ConeBeamFrame frame = run.frames[f];
    frame.first_pixel -= double(margin) * frame.column_step;
    std::ofstream(folder / fmt::format("{:04}.txt", f)) << geometry_text(frame, wide);
  }
}

/// On a grid of the same voxels, along the patient's axes.
Volume<float> run_plastimatch(const fs::path& folder, const VolumeGeometry& ours) {
  const int across = std::max(ours.size[0], ours.size[1]), high = ours.size[2];
  const double voxel = ours.spacing.x;
  const fs::path out = folder / "plastimatch.mha";
  const std::string command = fmt::format(
      "plastimatch fdk -f ramp -r '{0} {0} {1}' -z '{2:.9g} {2:.9g} {3:.9g}' -I '{4}' -O '{5}' "
      ">'{6}' 2>&1",
      across, high, across * voxel, high * voxel, (folder / "frames").string(), out.string(),
      (folder / "plastimatch.log").string());
  if (std::system(command.c_str()) != 0 || !fs::exists(out))
    throw Error(ExitCode::unavailable,
                "plastimatch did not end well (see plastimatch.log). Install it: apt-get install "
                "plastimatch");
  return segmentation::read_volume_file(out);
}

struct Comparison {
  double scale = 0.0;  ///< theirs times it are nearest to ours
  double rmse = 0.0, mean = 0.0, largest = 0.0;
  std::size_t voxels = 0;
};

/// Within 95 % of the field's radius, and of the height, where both see everything.
Comparison compare(const Volume<float>& ours, const Volume<float>& theirs, double radius) {
  constexpr double kInside = 0.95;
  std::vector<double> a, b;
  const auto& n = ours.geometry.size;
  for (int k = int((1.0 - kInside) * n[2]); k < int(kInside * n[2]); ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        const Vec3 place = ours.geometry.lps_from_index({double(i), double(j), double(k)});
        if (std::hypot(place.x, place.y) > kInside * radius) continue;
        a.push_back(double(ours.at(i, j, k)));
        b.push_back(interpolate(theirs, place));
      }
  double ab = 0.0, bb = 0.0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    ab += a[v] * b[v];
    bb += b[v] * b[v];
  }
  Comparison result;
  result.scale = ab / bb;
  result.voxels = a.size();
  for (std::size_t v = 0; v < a.size(); ++v) {
    const double off = a[v] - result.scale * b[v];
    result.mean += off / double(a.size());
    result.rmse += off * off / double(a.size());
    result.largest = std::max(result.largest, std::abs(off));
  }
  result.rmse = std::sqrt(result.rmse);
  return result;
}

void measure(const std::string& name, const fs::path& folder, benchmarks::ResultTable& table) {
  const datasets::RotationalRunOfPhantom made = make_run(name);
  const std::size_t per_frame = std::size_t(made.mount.columns) * std::size_t(made.mount.rows);
  const benchmarks::PhantomPictures pictures(made.pictures, per_frame);
  reconstruction::RotationalRun run;
  run.frames = made.frames;
  run.pictures = &pictures;
  reconstruction::ReconstructionOptions options;
  options.calibrate = false;
  Volume<float> theirs;
  for (const auto window :
       {reconstruction::FilterWindow::ram_lak, reconstruction::FilterWindow::shepp_logan,
        reconstruction::FilterWindow::hann}) {
    options.window = window;
    const reconstruction::Reconstruction ours = reconstruction::reconstruct_volume(run, options);
    if (theirs.values.empty()) {
      write_frames(folder / "frames", made, ours.quality.unattenuated);
      theirs = run_plastimatch(folder, ours.volume.geometry);
    }
    const Comparison result = compare(ours.volume, theirs, ours.quality.field_radius_mm);
    const double percent = 100.0 / made.options.contrast_per_mm;
    table.row({name, reconstruction::kFilterWindowNames[int(window)], std::to_string(result.voxels),
               benchmarks::formatted("%.2f", percent * result.rmse),
               benchmarks::formatted("%+.2f", percent * result.mean),
               benchmarks::formatted("%.1f", percent * result.largest)});
  }
}

}  // namespace
}  // namespace angio

int main(int argc, char** argv) try {
  angio::benchmarks::ResultTable table("Volumes against plastimatch's fdk", argc, argv);
  if (argc != 2) {
    fmt::print(stderr, "usage: against_plastimatch FOLDER [--markdown FILE]\n");
    return EXIT_FAILURE;
  }
  table.paragraph(
      "The same 360 frames of a full turn, no body, no noise; pixels and voxels of 0.3 mm. "
      "plastimatch's values have a scale of their own, which is fitted first: the absolute scale "
      "is "
      "not compared. It has one filter, a ramp; the windows are all told, because which of them is "
      "like it is not known. Voxels within 95 % of the field. In percent of the contrast of "
      "0.1/mm.");
  table.columns(
      {"phantom", "our window", "voxels", "RMSE [%]", "mean, ours - theirs [%]", "largest [%]"});
  for (const char* name : {"straight", "tandem", "helix", "ytype"})
    angio::measure(name, std::filesystem::path(argv[1]) / name, table);
  table.write();
  return EXIT_SUCCESS;
} catch (const std::exception& error) {
  fmt::print(stderr, "against_plastimatch: {}\n", error.what());
  return EXIT_FAILURE;
}
