#include <algorithm>
#include <array>

#include "simulation/backends/cuda_uploads.hpp"
#include "simulation/backends/solver_base.hpp"

namespace angio::simulation::detail {
namespace {

// Frames in one launch: where nothing can touch, and where something can, and each launch begins
// with new candidates.
constexpr int kFreeFrames = 16, kContactFrames = 4;
// Launches that run or wait, so that the device goes on while frames are handed out. With the
// reference method's contact there is one, of one frame: the next frame projects the tets that it
// leaves.
constexpr int kLaunches = 3;
// Candidates there is room for at first, for each vertex.
constexpr int kCandidatesPerVertex = 48;

template <class Real>
class CudaSolver final : public SolverBase<Real> {
 public:
  CudaSolver(const Scene& scene, const SimulationOptions& options, Spread spread)
      : SolverBase<Real>(scene, options),
        device_(cuda::use_device()),
        is_projected_(projects_contact(scene, options)),
        frames_(is_projected_ ? 1
                : touches()   ? kContactFrames
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
    if (touches()) prepare_search(staging);
    for (int b = 0; b < launches(); ++b)
      batches_[std::size_t(b)].frames.reserve(frames_, state_view(program_.view), memory_);
    check(cudaDeviceSynchronize(), "copying the scene");
  }

  void run(const Control& control,
           const std::function<void(int frame, State&& state)>& on_state) override {
    CudaProgram<Real> program = program_;
    program.rules = control.rules;
    program.last_frame = control.inflator.frame_count() - 1;
    program.inflator = inflator_;
    status_.frame = 0;
    send_status();
    check(cudaMemcpyAsync(inflator_, &control.inflator, sizeof control.inflator,
                          cudaMemcpyHostToDevice, stream_),
          "working");
    if (!runs_ahead()) on_state(0, start_state(scene_, status_.pressure));
    for (int b = 0; b < launches(); ++b) submit(program, batches_[std::size_t(b)], frames_);
    if (runs_ahead()) on_state(0, start_state(scene_, status_.pressure));
    // While a launch runs and others wait for it, the one before them is handed out.
    int frame = 0, turn = 0;
    while (frame < program.last_frame) {
      Batch& batch = batches_[std::size_t(turn)];
      turn = (turn + 1) % launches();
      check(cudaEventSynchronize(batch.copied), "solving");
      const StepStatus& end = batch.frames.status(frames_);
      const int ended = end.stage == StepStage::begin ? end.frame : end.frame - 1;
      make_room(batch);
      std::vector<State> states;
      for (int k = 0; k < ended - frame; ++k)
        states.push_back(this->state_of(batch.frames.state(k), batch.frames.status(k)));
      if (runs_ahead() && ended < program.last_frame) submit(program, batch, frames_);
      for (State& state : states) on_state(++frame, std::move(state));
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
    do {
      submit(program, batches_[0], 1);
      copies_.wait("solving");
      make_room(batches_[0]);
    } while (batches_[0].frames.status(1).stage != StepStage::begin);
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
    if (touches()) {
      check(launch_search(search_, scan_memory_, stream_), "being given work");
      check(cudaMemcpyAsync(batch.frames.found(), search_.found_count(), sizeof(int),
                            cudaMemcpyDeviceToHost, stream_),
            "copying results");
    }
    check(launch(program, shape_, stream_), "being given work");
    check(cudaEventRecord(batch.computed, stream_), "working");
    check(cudaStreamWaitEvent(copies_, batch.computed, 0), "working");
    batch.frames.bring(frame_count, copies_);
    check(cudaEventRecord(batch.copied, copies_), "working");
  }

  void prepare_search(StagingMemory& staging) {
    search_ =
        upload(make_candidate_search<Real>(scene_, this->options_, frames_, staging), memory_);
    const MotionView<Real>& motion = program_.view.motion;
    search_.x = motion.x;
    search_.velocity = motion.velocity;
    search_.x_before = motion.x_before;
    search_.status = program_.status;
    scan_memory_ = memory_.allocate<char>(scan_bytes(search_.vertex_count + 1));
    hold_candidates(kCandidatesPerVertex * scene_.bodies.contact_count());
  }

  void hold_candidates(int capacity) {
    ContactView<Real>& contact = program_.view.contact;
    candidates_.hold(capacity, search_, contact.near);
    contact.candidates = shown(search_);
  }

  // A launch for whose candidates there was no room has done nothing; the next ones get more.
  void make_room(const Batch& batch) {
    if (!touches() || *batch.frames.found() <= search_.capacity) return;
    stream_.wait("solving");
    hold_candidates(2 * *batch.frames.found());
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
  CandidateSearch<Real> search_;
  CandidateMemory<Real> candidates_;
  char* scan_memory_ = nullptr;
  PbdUpload<Real> pbd_;
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

void wake_cuda_device() { cudaFree(nullptr); }

std::unique_ptr<StepSolver> make_cuda_solver(const Scene& scene, const SimulationOptions& options,
                                             Precision precision, Spread spread) {
  if (precision == Precision::automatic) precision = precision_for(scene, options);
  if (precision == Precision::single)
    return std::make_unique<CudaSolver<float>>(scene, options, spread);
  return std::make_unique<CudaSolver<double>>(scene, options, spread);
}

}  // namespace angio::simulation::detail
