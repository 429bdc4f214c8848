#include <algorithm>
#include <array>

#include "simulation/backends/cuda_launch.hpp"
#include "simulation/backends/device_memory.hpp"
#include "simulation/step/make_views.hpp"

namespace angio::simulation::detail {
namespace {

// Frames in one launch: where nothing can touch, and where something can, and new candidates come
// between launches.
constexpr int kFreeFrames = 16, kWallFrames = 2;
// Launches that run or wait, so that the device goes on while new candidates are found. With the
// paper's contact there is one, of one frame: the next frame projects the tets that it leaves.
constexpr int kLaunches = 5;
// New candidates are found once balloon and wall have used this share of the room that the last
// ones leave.
constexpr double kUsed = 0.65;
constexpr int kLeastCapability = 75;

int use_device() {
  int count = 0;
  const cudaError_t error = cudaGetDeviceCount(&count);
  if (error != cudaSuccess || count == 0)
    throw Error(ExitCode::unavailable,
                std::string("the CUDA backend was asked for, but there is no usable GPU (") +
                    (error != cudaSuccess ? cudaGetErrorString(error) : "none found") +
                    "). Check the driver with nvidia-smi, or use --backend cpu");
  int device = 0, major = 0, minor = 0;
  check(cudaGetDevice(&device), "starting");
  cudaDeviceGetAttribute(&major, cudaDevAttrComputeCapabilityMajor, device);
  cudaDeviceGetAttribute(&minor, cudaDevAttrComputeCapabilityMinor, device);
  if (10 * major + minor < kLeastCapability)
    throw Error(ExitCode::unavailable, "the GPU is too old (compute capability " +
                                           std::to_string(major) + "." + std::to_string(minor) +
                                           "; 7.5 is needed). Use --backend cpu");
  return device;
}

std::string name_of(int device) {
  cudaDeviceProp properties;
  if (cudaGetDeviceProperties(&properties, device) != cudaSuccess) return "GPU";
  return properties.name;
}

/// A set of candidates on the device.
template <class Real>
class CandidateUpload {
 public:
  CandidateView<Real> send(const CandidateSet& set, const std::vector<Vec3T<Real>>& x,
                           cudaStream_t stream) {
    return {candidates_.send(set.candidates, stream),
            owned_begin_.send(set.owned_begin, stream),
            ref_begin_.send(set.ref_begin, stream),
            refs_.send(set.refs, stream),
            x_.send(x, stream),
            Real(set.reach),
            int(set.candidates.size()),
            Real(set.skin_reach)};
  }

 private:
  Upload<Candidate> candidates_;
  Upload<int> owned_begin_, ref_begin_;
  Upload<ContactRef> refs_;
  Upload<Vec3T<Real>> x_;
};

/// What a step makes of its candidates.
template <class Real>
struct PairMemory {
  Upload<NearPair<Real>> pairs;
  Upload<int> pair_of;
  Upload<ContactRef> refs;
  Upload<MotionBound<Real>> bounds;

  void hold(const CandidateSet& set, cudaStream_t stream, StepView<Real>& view) {
    if (set.candidates.size() > size_) {
      check(cudaStreamSynchronize(stream), "working");  // the old arrays are in use until then
      size_ = set.candidates.size();
    }
    pairs.reserve(size_);
    pair_of.reserve(size_);
    refs.reserve(4 * size_);
    bounds.reserve(4 * size_);
    view.pairs = pairs.data();
    view.pair_of = pair_of.data();
    view.refs = refs.data();
    view.bounds = bounds.data();
  }

 private:
  std::size_t size_ = 0;
};

/// The tets of the paper's contact, and whose viscous item has been set.
template <class Real>
class PaperUpload {
 public:
  void send(PaperTets tets, cudaStream_t stream, PaperContact<Real>& paper) {
    const std::vector<char> kept = kept_items(tets_, items_of(paper), tets);
    tets_ = std::move(tets);
    paper.colors = int(tets_.color_begin.size()) - 1;
    paper.color_begin = color_begin_.send(tets_.color_begin, stream);
    paper.tets = vertices_.send(tets_.vertices, stream);
    paper.balloon_corners = corners_.send(tets_.balloon_corners, stream);
    paper.triggered = triggered_.send(kept, stream);
  }

 private:
  [[nodiscard]] std::vector<char> items_of(const PaperContact<Real>& paper) const {
    std::vector<char> items(tets_.balloon_corners.size());
    if (!items.empty())
      check(cudaMemcpy(items.data(), paper.triggered, items.size(), cudaMemcpyDeviceToHost),
            "copying results");
    return items;
  }

  PaperTets tets_;
  Upload<int> color_begin_, vertices_, corners_;
  Upload<char> triggered_;
};

template <class Real>
class CudaSolver final : public StepSolver {
 public:
  CudaSolver(const Scene& scene, const SimulationOptions& options, Spread spread)
      : scene_(scene),
        options_(options),
        device_(use_device()),
        finder_(scene, options, (kLaunches + 2) * kWallFrames),
        start_(local<Real>(scene, scene.start)),
        frames_(is_projected() ? 1
                : touches()    ? kWallFrames
                               : kFreeFrames) {
    program_.view = make_view<Real>(scene, options, memory_);
    if (program_.view.paper_gas.is_on) gas_ = paper_gas_tets(scene);
    program_.rules = make_rules(scene, options);
    program_.plasticity = plastic_flow<Real>(options.wall);
    program_.status = memory_.allocate<StepStatus>(1);
    program_.sums = memory_.allocate<char>(kCudaSumBytes);
    inflator_ = memory_.allocate<Inflator>(1);
    status_.pressure = outside_pressure(options);
    status_.volume = balloon_volume(scene, scene.start);
    shape_ = spread == Spread::automatic
                 ? cuda_shape(program_.view, device_)
                 : cuda_shape(program_.view, device_, spread == Spread::grid);
    for (int b = 0; b < launches(); ++b) make_batch(batches_[std::size_t(b)]);
    check(cudaDeviceSynchronize(), "copying the scene");
  }

  void run(const Inflator& inflator,
           const std::function<void(int frame, const State& state)>& on_state) override {
    CudaProgram<Real> program = program_;
    program.last_frame = inflator.frame_count() - 1;
    program.inflator = inflator_;
    status_.frame = 0;
    send_status();
    check(cudaMemcpyAsync(inflator_, &inflator, sizeof inflator, cudaMemcpyHostToDevice, stream_),
          "working");
    if (touches()) renew_candidates(start_, 0);
    if (!runs_ahead()) on_state(0, start_state(scene_, status_.pressure));
    for (int b = 0; b < launches(); ++b) submit(program, batches_[std::size_t(b)], frames_);
    if (runs_ahead()) on_state(0, start_state(scene_, status_.pressure));
    // While a launch runs and others wait for it, the one before them is handed out.
    int frame = 0, turn = 0, begun_with_set = 0;
    while (frame < program.last_frame) {
      Batch& batch = batches_[std::size_t(turn)];
      turn = (turn + 1) % launches();
      check(cudaEventSynchronize(batch.copied), "solving");
      const StepStatus& end = status_of(batch, frames_);
      const int ended = end.stage == StepStage::begin ? end.frame : end.frame - 1;
      begun_with_set += ended - frame;
      if (touches() && ((end.halted && batch.set == set_count_) || used_up(batch))) {
        renew_candidates(positions_of(batch, frames_), begun_with_set);
        begun_with_set = 0;
      }
      std::vector<State> states;
      for (int k = 0; k < ended - frame; ++k) states.push_back(state_of(batch, k));
      if (runs_ahead() && ended < program.last_frame) submit(program, batch, frames_);
      for (const State& state : states) on_state(++frame, state);
      if (!runs_ahead() && ended < program.last_frame) submit(program, batch, frames_);
    }
    stream_.wait("solving");
    copies_.wait("solving");
  }

  State settle(const GasLaw<double>& law, double tolerance, int most_sweeps) override {
    CudaProgram<Real> program = program_;
    program.rules.tolerance = program.rules.residual = tolerance;
    program.rules.rest = 0.0;
    program.rules.most_sweeps = program.rules.later_sweeps = most_sweeps;
    program.rules.still = true;
    program.last_frame = 1;
    status_.law = law;
    status_.frame = 0;
    send_status();
    submit(program, batches_[0], 1);
    copies_.wait("solving");
    status_ = status_of(batches_[0], 0);
    return state_of(batches_[0], 0);
  }

  // Are frames computed before the last ones are handed out?
  [[nodiscard]] bool runs_ahead() const { return !is_projected(); }

  // Between two launches: nothing runs.
  void set_air(const std::vector<Tet>& air) override {
    if (!program_.view.paper.is_on || air.empty()) return;
    paper_.send(paper_tets(scene_, options_, air), stream_, program_.view.paper);
  }

  [[nodiscard]] std::string device() const override { return name_of(device_); }

 private:
  using Vec = Vec3T<Real>;
  using Mat = Mat3T<Real>;

  // Where the frames of a launch end up, on the device and here.
  struct Batch {
    CudaFrames<Real> device;
    PinnedBlock status, x, contact_pressure, plastic, plastic_modes, points, strain;
    Event computed, copied;
    int set = 0;  // of candidates that it uses
  };

  [[nodiscard]] bool is_projected() const {
    return options_.contact_model == ContactModel::paper && scene_.wall_count > 0;
  }
  [[nodiscard]] int launches() const { return is_projected() ? 1 : kLaunches; }
  [[nodiscard]] bool touches() const {
    return (scene_.wall_count > 0 && !is_projected()) || scene_.rod.count > 0 ||
           scene_.self_distance > 0.0;
  }
  [[nodiscard]] std::size_t clusters() const { return std::size_t(program_.view.cluster_count); }
  [[nodiscard]] std::size_t modes() const {
    return program_.view.entry_modes ? clusters() * kShapeModes : 0;
  }
  [[nodiscard]] std::size_t points() const { return scene_.solid.model.points.size(); }

  template <class Value>
  void make_place(std::size_t count, Value*& device, PinnedBlock& host) {
    const std::size_t size = std::size_t(frames_ + 1) * count;
    device = memory_.allocate<Value>(size);
    host = PinnedBlock(size * sizeof(Value));
  }

  void make_batch(Batch& batch) {
    make_place(1, batch.device.status, batch.status);
    make_place(scene_.start.size(), batch.device.x, batch.x);
    make_place(std::size_t(scene_.wall_count), batch.device.contact_pressure,
               batch.contact_pressure);
    make_place(clusters(), batch.device.plastic, batch.plastic);
    make_place(modes(), batch.device.plastic_modes, batch.plastic_modes);
    make_place(points(), batch.device.solid_points, batch.points);
    make_place(points(), batch.device.solid_plastic_strain, batch.strain);
  }

  void send_status() {
    check(
        cudaMemcpyAsync(program_.status, &status_, sizeof status_, cudaMemcpyHostToDevice, stream_),
        "working");
  }

  template <class Value>
  void bring(const PinnedBlock& to, const Value* from, std::size_t count) {
    if (count == 0) return;
    check(cudaMemcpyAsync(to.as<Value>(), from, count * sizeof(Value), cudaMemcpyDeviceToHost,
                          copies_),
          "copying results");
  }

  // Launches frames and, once they are computed, their way back.
  void submit(CudaProgram<Real> program, Batch& batch, int frame_count) {
    program.view = program_.view;
    program.frame_count = frame_count;
    program.frames = batch.device;
    batch.set = set_count_;
    check(launch(program, shape_, stream_), "being given work");
    check(cudaEventRecord(batch.computed, stream_), "working");
    check(cudaStreamWaitEvent(copies_, batch.computed, 0), "working");
    const std::size_t count = std::size_t(frame_count);
    bring(batch.status, batch.device.status, count + 1);
    bring(batch.x, batch.device.x, (count + 1) * scene_.start.size());
    bring(batch.contact_pressure, batch.device.contact_pressure,
          count * std::size_t(scene_.wall_count));
    bring(batch.plastic, batch.device.plastic, count * clusters());
    bring(batch.plastic_modes, batch.device.plastic_modes, count * modes());
    bring(batch.points, batch.device.solid_points, count * points());
    bring(batch.strain, batch.device.solid_plastic_strain, count * points());
    check(cudaEventRecord(batch.copied, copies_), "working");
  }

  // Candidates at positions that the device has left behind by some launches. The sets that the
  // waiting launches use stay as they are.
  void renew_candidates(const std::vector<Vec>& x, int lasted) {
    std::vector<Vec3> points(x.size());
    for (std::size_t v = 0; v < x.size(); ++v) points[v] = converted<double>(x[v]);
    const CandidateSet set = finder_.find(points, lasted);
    pairs_.hold(set, stream_, program_.view);
    use(sets_[std::size_t(set_count_) % sets_.size()].send(set, x, stream_), program_.view);
    ++set_count_;
    x_candidates_ = x;
    const double travel = most_travel(scene_) * double(program_.view.contact_distance);
    room_ = set.reach - double(program_.view.contact_range) - 2.0 * travel;
    skin_room_ = set.skin_reach - scene_.self_distance - 2.0 * travel;
  }

  // Have balloon and wall together gone far since the last candidates were found?
  bool used_up(const Batch& batch) const {
    const Vec* x = x_of(batch, frames_);
    double gone[2] = {0.0, 0.0};
    for (std::size_t v = 0; v < x_candidates_.size(); ++v) {
      double& side = gone[int(v) < scene_.balloon_count ? 0 : 1];
      side = std::max(side, double(distance(x[v], x_candidates_[v])));
    }
    return gone[0] + gone[1] > kUsed * room_ ||
           (scene_.self_distance > 0.0 && 2.0 * std::max(gone[0], gone[1]) > kUsed * skin_room_);
  }

  static const StepStatus& status_of(const Batch& batch, int k) {
    return batch.status.template as<StepStatus>()[k];
  }

  const Vec* x_of(const Batch& batch, int k) const {
    return batch.x.template as<Vec>() + std::size_t(k) * scene_.start.size();
  }

  std::vector<Vec> positions_of(const Batch& batch, int k) const {
    return {x_of(batch, k), x_of(batch, k) + scene_.start.size()};
  }

  State state_of(const Batch& batch, int k) const {
    const StepStatus& status = status_of(batch, k);
    State state;
    state.x = global(scene_, start_.data(), x_of(batch, k));
    state.pressure =
        program_.view.paper_gas.is_on
            ? mean_tet_pressure(gas_, status.tet_growth, outside_pressure(options_), state.x)
            : status.pressure;
    state.volume = status.volume;
    state.report = status.report;
    const Mat* plastic = batch.plastic.template as<Mat>() + std::size_t(k) * clusters();
    for (std::size_t c = 0; c < clusters(); ++c)
      state.plastic.push_back(converted<double>(plastic[c]));
    const Vec* mode = batch.plastic_modes.template as<Vec>() + std::size_t(k) * modes();
    for (std::size_t m = 0; m < modes(); ++m)
      state.plastic_modes.push_back(converted<double>(mode[m]));
    const Real* pressure = batch.contact_pressure.template as<Real>() +
                           std::size_t(k) * std::size_t(scene_.wall_count);
    state.contact_pressure.assign(pressure, pressure + scene_.wall_count);
    const auto* point = batch.points.template as<SolidPoint<Real>>() + std::size_t(k) * points();
    for (std::size_t p = 0; p < points(); ++p)
      state.solid_points.push_back(converted<double>(point[p]));
    const Real* strain = batch.strain.template as<Real>() + std::size_t(k) * points();
    state.solid_plastic_strain.assign(strain, strain + points());
    return state;
  }

  const Scene& scene_;
  const SimulationOptions options_;
  int device_;
  DeviceMemory memory_;
  CandidateFinder finder_;
  std::vector<Vec> start_, x_candidates_;
  int frames_;
  CudaProgram<Real> program_;
  CudaShape shape_;
  StepStatus status_;
  Inflator* inflator_ = nullptr;
  Stream stream_, copies_;
  std::array<Batch, kLaunches> batches_;
  std::array<CandidateUpload<Real>, kLaunches + 1> sets_;
  PairMemory<Real> pairs_;
  PaperUpload<Real> paper_;
  PaperGasTets gas_;
  int set_count_ = 0;
  double room_ = 0.0, skin_room_ = 0.0;
};

}  // namespace

bool has_cuda_device() { return !cuda_device_name().empty(); }

std::string cuda_device_name() {
  try {
    return name_of(use_device());
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
