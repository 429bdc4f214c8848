#include "pipeline/stages/segmentation.hpp"

#include <fmt/format.h>

#include "datasets/phantom.hpp"
#include "formats/case_file.hpp"
#include "formats/nrrd.hpp"
#include "pipeline/case/input_kind.hpp"
#include "pipeline/case/resolution.hpp"
#include "pipeline/stages/surface_input.hpp"
#include "segmentation/read_volume.hpp"
#include "segmentation/segmentation.hpp"

// From the input to the lumen.
namespace angio::pipeline {
namespace file = formats::case_file;
namespace {

Volume<float> load_volume(StageWork& work, const SegmentationSettings& settings) {
  if (work.run.input_kind == name(InputKind::run))
    return segmentation::read_volume_file(work.files.path(file::kReconstructed));
  if (work.input.empty()) return segmentation::read_volume_file(work.files.path(file::kScan));
  if (work.input.starts_with(kPhantomPrefix)) {
    const auto options = datasets::parse_phantom(work.input);
    work.input_description = fmt::format("phantom {}", options.name);
    return datasets::make_phantom_scan(options, part(work.progress, 0.0, 0.2)).volume;
  }
  segmentation::ReadOptions options = settings.get<&Config::input>();
  options.unit = settings.get<&Config::surface_unit>();
  segmentation::LoadedVolume loaded =
      segmentation::read_volume(work.input, options, part(work.progress, 0.0, 0.2));
  keep(work.warnings, loaded.warnings);
  work.input_description = loaded.source_description;
  return std::move(loaded.volume);
}

}  // namespace

void do_segmentation(StageWork& work, const SegmentationSettings& settings) {
  if (work.run.input_kind == name(InputKind::surface))
    return take_surface(work, settings.get<&Config::surface_unit>());
  const Volume<float> volume = load_volume(work, settings);
  const segmentation::Segmentation result = segmentation::segment_vessels(
      volume, settings.get<&Config::segmentation>(), part(work.progress, 0.2, 0.9));
  keep(work.warnings, result.warnings);
  work.progress.report(0.9, "writing");
  formats::write_nrrd(work.out / "volume.nrrd", volume);
  formats::write_nrrd(work.out / "lumen_mask.nrrd", result.mask);
  formats::write_nrrd(work.out / "lumen_level_set.nrrd", result.level_set);
  if (!result.narrow_lps_mm.empty())
    write_narrow_places(work.out / std::filesystem::path(file::kNarrowPlaces).filename(),
                        result.narrow_lps_mm);
}

}  // namespace angio::pipeline
