#include <algorithm>
#include <array>

#include "simulation/backends/cuda_uploads.hpp"
#include "simulation/backends/solver_base.hpp"
#include "simulation/step/bounded_motion.hpp"

namespace angio::simulation::detail {
namespace {

// Frames in one launch: where nothing can touch, and where something can, and new candidates come
// between launches.
constexpr int kFreeFrames = 16, kWallFrames = 2;
// Launches that run or wait, so that the device goes on while new candidates are found. With the
// reference method's contact there is one, of one frame: the next frame projects the tets that it
// leaves.
constexpr int kLaunches = 3;
// New candidates are found once bodies have used this share of the free move that the last
// ones leave.
constexpr double kUsed = 0.65;

template <class Real>
class CudaSolver final : public SolverBase<Real> {
 public:
  CudaSolver(const Scene& scene, const SimulationOptions& options, Spread spread)
      : SolverBase<Real>(scene, options, (kLaunches + 2) * kWallFrames, true),
        device_(cuda::use_device()),
        is_projected_(projects_contact(scene, options)),
        frames_(is_projected_ ? 1
                : touches()   ? kWallFrames
                              : kFreeFrames) {
    StagingMemory staging;
    program_.view = upload(make_view<Real>(scene, options, staging), memory_);
    program_.plasticity = this->plasticity_;
    program_.status = memory_.allocate<StepStatus>(1);
    program_.sums = memory_.allocate<char>(kCudaSumBytes);
    inflator_ = memory_.allocate<Inflator>(1);
    shape_ = spread == Spread::automatic
                 ? cuda_shape(program_.view, device_)
                 : cuda_shape(program_.view, device_, spread == Spread::grid);
    for (int b = 0; b < launches(); ++b)
      batches_[std::size_t(b)].frames.reserve(frames_, state_view(program_.view), memory_);
    check(cudaDeviceSynchronize(), "copying the scene");
  }

  void run(const Control& control,
           const std::function<void(int frame, const State& state)>& on_state) override {
    CudaProgram<Real> program = program_;
    program.rules = control.rules;
    program.last_frame = control.inflator.frame_count() - 1;
    program.inflator = inflator_;
    status_.frame = 0;
    send_status();
    check(cudaMemcpyAsync(inflator_, &control.inflator, sizeof control.inflator,
                          cudaMemcpyHostToDevice, stream_),
          "working");
    if (touches()) renew_candidates(this->start_.data(), 0);
    if (!runs_ahead()) on_state(0, start_state(scene_, status_.pressure));
    for (int b = 0; b < launches(); ++b) submit(program, batches_[std::size_t(b)], frames_);
    if (runs_ahead()) on_state(0, start_state(scene_, status_.pressure));
    // While a launch runs and others wait for it, the one before them is handed out.
    int frame = 0, turn = 0, begun_with_set = 0;
    while (frame < program.last_frame) {
      Batch& batch = batches_[std::size_t(turn)];
      turn = (turn + 1) % launches();
      check(cudaEventSynchronize(batch.copied), "solving");
      const StepStatus& end = batch.frames.status(frames_);
      const int ended = end.stage == StepStage::begin ? end.frame : end.frame - 1;
      begun_with_set += ended - frame;
      if (touches() && ((end.halted && batch.set == set_count_) || used_up(batch))) {
        renew_candidates(batch.frames.end_x(), begun_with_set);
        begun_with_set = 0;
      }
      std::vector<State> states;
      for (int k = 0; k < ended - frame; ++k)
        states.push_back(this->state_of(batch.frames.state(k), batch.frames.status(k)));
      if (runs_ahead() && ended < program.last_frame) submit(program, batch, frames_);
      for (const State& state : states) on_state(++frame, state);
      if (!runs_ahead() && ended < program.last_frame) submit(program, batch, frames_);
    }
    stream_.wait("solving");
    copies_.wait("solving");
  }

  [[nodiscard]] std::string device() const override { return cuda::name_of(device_); }

 private:
  using SolverBase<Real>::scene_;
  using SolverBase<Real>::status_;

  struct Batch {
    FrameMemory<Real> frames;
    Event computed, copied;
    int set = 0;  // of candidates that it uses
  };

  // Are frames computed before the last ones are handed out?
  [[nodiscard]] bool runs_ahead() const { return !is_projected_; }
  [[nodiscard]] int launches() const { return is_projected_ ? 1 : kLaunches; }
  [[nodiscard]] bool touches() const {
    return (scene_.bodies.wall().count > 0 && !is_projected_) || scene_.rod.count > 0 ||
           scene_.self_distance > 0.0;
  }

  State take_step(const StepRules& rules) override {
    CudaProgram<Real> program = program_;
    program.rules = rules;
    program.last_frame = 1;
    status_.frame = 0;
    send_status();
    submit(program, batches_[0], 1);
    copies_.wait("solving");
    status_ = batches_[0].frames.status(0);
    return this->state_of(batches_[0].frames.state(0), status_);
  }

  // Between two launches: nothing runs.
  std::vector<char> viscous_items(std::size_t count) override {
    std::vector<char> items(count);
    if (count > 0)
      check(cudaMemcpy(items.data(), program_.view.pbd.contact.triggered, count,
                       cudaMemcpyDeviceToHost),
            "copying results");
    return items;
  }
  void use_tets(const PbdTets& tets, std::vector<char> viscous_items) override {
    pbd_.send(tets, viscous_items, stream_, program_.view.pbd.contact);
  }

  void send_status() {
    check(
        cudaMemcpyAsync(program_.status, &status_, sizeof status_, cudaMemcpyHostToDevice, stream_),
        "working");
  }

  // Launches frames and, once they are computed, their way back.
  void submit(CudaProgram<Real> program, Batch& batch, int frame_count) {
    program.view = program_.view;
    program.frame_count = frame_count;
    program.frames = batch.frames.device();
    batch.set = set_count_;
    check(launch(program, shape_, stream_), "being given work");
    check(cudaEventRecord(batch.computed, stream_), "working");
    check(cudaStreamWaitEvent(copies_, batch.computed, 0), "working");
    batch.frames.bring(frame_count, copies_);
    check(cudaEventRecord(batch.copied, copies_), "working");
  }

  // Candidates at positions that the device has left behind by some launches. The sets that the
  // waiting launches use stay as they are.
  void renew_candidates(const Vec3T<Real>* x, int lasted) {
    const CandidateSet set = this->find_candidates(x, lasted);
    ContactView<Real>& contact = program_.view.contact;
    pairs_.hold(set, stream_, contact.near);
    contact.candidates =
        sets_[std::size_t(set_count_) % sets_.size()].send(set, this->x_candidates_, stream_);
    ++set_count_;
    const double move =
        most_move(scene_.balloon.has_folds, scene_.self_distance) * double(contact.law.distance);
    free_move_ = set.search_radius - double(contact.law.range) - 2.0 * move;
    free_self_move_ = set.self_radius - scene_.self_distance - 2.0 * move;
  }

  // Have bodies that may touch moved far since the last candidates were found?
  bool used_up(const Batch& batch) const {
    const Vec3T<Real>* x = batch.frames.end_x();
    double moved[kBodyCount] = {};
    for (std::size_t v = 0; v < this->x_candidates_.size(); ++v) {
      double& body = moved[int(scene_.bodies.of(int(v)))];
      body = std::max(body, double(distance(x[v], this->x_candidates_[v])));
    }
    return most_of_pairs(moved) > kUsed * free_move_ ||
           (scene_.self_distance > 0.0 && 2.0 * most_of(moved) > kUsed * free_self_move_);
  }

  int device_;
  DeviceMemory memory_;
  bool is_projected_;  // by the reference method's contact
  int frames_;
  CudaProgram<Real> program_;
  CudaShape shape_;
  Inflator* inflator_ = nullptr;
  Stream stream_, copies_;
  std::array<Batch, kLaunches> batches_;
  std::array<CandidateUpload<Real>, kLaunches + 1> sets_;
  PairMemory<Real> pairs_;
  PbdUpload<Real> pbd_;
  int set_count_ = 0;
  double free_move_ = 0.0, free_self_move_ = 0.0;  // till new candidates are needed [mm]
};

}  // namespace

bool has_cuda_device() { return !cuda_device_name().empty(); }

std::string cuda_device_name() {
  try {
    return cuda::name_of(cuda::use_device());
  } catch (const Error&) {
    return {};
  }
}

std::unique_ptr<StepSolver> make_cuda_solver(const Scene& scene, const SimulationOptions& options,
                                             Precision precision, Spread spread) {
  if (precision == Precision::automatic) precision = precision_for(scene, options);
  if (precision == Precision::single)
    return std::make_unique<CudaSolver<float>>(scene, options, spread);
  return std::make_unique<CudaSolver<double>>(scene, options, spread);
}

}  // namespace angio::simulation::detail
