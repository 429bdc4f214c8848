#include "pipeline/stages/stage_table.hpp"

#include "formats/case_file.hpp"
#include "pipeline/case/flow.hpp"
#include "pipeline/case/input_kind.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/case/resolution.hpp"
#include "pipeline/case/working_view.hpp"
#include "pipeline/stages/centerline.hpp"
#include "pipeline/stages/meshing.hpp"
#include "pipeline/stages/reconstruction.hpp"
#include "pipeline/stages/report.hpp"
#include "pipeline/stages/segmentation.hpp"
#include "pipeline/stages/simulation.hpp"

namespace angio::pipeline {
namespace file = formats::case_file;
namespace {

std::vector<StageDefinition> vessel_stages() {
  std::vector<StageDefinition> table = {
      define_stage(Stage::reconstruction, {}, see_input, do_reconstruction),
      define_stage(Stage::segmentation, {file::kReconstructed}, see_input, do_segmentation),
      define_stage(Stage::centerline, together({file::kLevelSet}, resolution_files()), see_nothing,
                   do_centerline, centerline_settings),
      define_stage(
          Stage::meshing,
          together({file::kLevelSet, file::kCenterlines, file::kNarrowedLumen}, resolution_files()),
          see_nothing, do_meshing),
      define_stage(
          Stage::simulation,
          {file::kCenterlines, file::kLesions, file::kLumen, file::kBalloon, file::kGuidewire,
           file::kRegion, file::kAir, file::kLayeredWall, file::kPlacement},
          see_backend, do_simulation),
      define_stage(
          Stage::report,
          together({file::kShownFrames, file::kShownPlaces, file::kLevelSet, file::kLumen,
                    file::kGuidewire, file::kLesions, file::kFrameList, file::kTimeSeries,
                    file::kProfile, file::kFrames, file::kLumenAfter},
                   together(metrics_files(), together(flow_files(), working_view_files()))),
          see_run, do_report)};
  table[0].input_kind = name(InputKind::run);
  table[1].own_inputs = {file::kScan, file::kGivenLumen};
  table.back().tells_of_failure = true;
  return table;
}

}  // namespace

const Workflow& vessel_workflow() {
  static const Workflow kVessel{
      vessel_stages(), together(metrics_files(), together(flow_files(), working_view_files())),
      [](const StageFiles& files, const Config& config, const RunRecord& record) {
        return collect_metrics(
            files, config.lesion,
            {{"flow", case_flow(files, config.flow, config.flow_vessel, record).metrics},
             {"working_view", case_working_view(files, config.view, record).metrics}},
            record);
      }};
  return kVessel;
}

}  // namespace angio::pipeline
