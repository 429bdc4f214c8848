#include <algorithm>
#include <array>
#include <cstring>

#include "core/error.hpp"
#include "simulation/detail/step_cuda.hpp"
#include "simulation/detail/step_view.hpp"

namespace angio::simulation::detail {
namespace {

// Frames in one launch of a scene that needs no contact detection.
constexpr int kFramesPerLaunch = 16;
constexpr int kLeastCapability = 75;

[[noreturn]] void fail(cudaError_t error, const char* doing) {
  std::string text =
      "the GPU failed while " + std::string(doing) + " (" + cudaGetErrorString(error) + "). ";
  text += error == cudaErrorMemoryAllocation
              ? "Close other programs that use it, take a smaller model, or use --backend cpu"
              : "Check the driver with nvidia-smi, or use --backend cpu";
  throw Error(ExitCode::unavailable, text);
}

void check(cudaError_t error, const char* doing) {
  if (error != cudaSuccess) fail(error, doing);
}

/// A block of the device's memory.
class DeviceBlock {
 public:
  DeviceBlock() = default;
  explicit DeviceBlock(std::size_t bytes) {
    check(cudaMalloc(&data_, std::max<std::size_t>(bytes, 16)), "taking its memory");
    const cudaError_t cleared = cudaMemset(data_, 0, std::max<std::size_t>(bytes, 16));
    if (cleared != cudaSuccess) {
      cudaFree(data_);
      fail(cleared, "clearing its memory");
    }
  }
  DeviceBlock(DeviceBlock&& other) noexcept : data_(std::exchange(other.data_, nullptr)) {}
  DeviceBlock& operator=(DeviceBlock&& other) noexcept {
    std::swap(data_, other.data_);
    return *this;
  }
  ~DeviceBlock() { cudaFree(data_); }

  template <class Value>
  Value* as() const {
    return static_cast<Value*>(data_);
  }

 private:
  void* data_ = nullptr;
};

/// Memory of the computer that the GPU copies from and to by itself.
class PinnedBlock {
 public:
  PinnedBlock() = default;
  explicit PinnedBlock(std::size_t bytes) {
    check(cudaMallocHost(&data_, std::max<std::size_t>(bytes, 16)), "taking pinned memory");
  }
  PinnedBlock(PinnedBlock&& other) noexcept : data_(std::exchange(other.data_, nullptr)) {}
  PinnedBlock& operator=(PinnedBlock&& other) noexcept {
    std::swap(data_, other.data_);
    return *this;
  }
  ~PinnedBlock() { cudaFreeHost(data_); }

  template <class Value>
  Value* as() const {
    return static_cast<Value*>(data_);
  }

 private:
  void* data_ = nullptr;
};

/// As HostMemory, on the device: taken once, when the solver is made.
class DeviceMemory {
 public:
  template <class Value>
  Value* store(const std::vector<Value>& values) {
    Value* data = allocate<Value>(values.size());
    if (!values.empty())
      check(cudaMemcpy(data, values.data(), values.size() * sizeof(Value), cudaMemcpyHostToDevice),
            "copying the scene");
    return data;
  }
  template <class Value>
  Value* allocate(std::size_t count) {
    blocks_.emplace_back(count * sizeof(Value));
    return blocks_.back().as<Value>();
  }

 private:
  std::vector<DeviceBlock> blocks_;
};

class Stream {
 public:
  Stream() { check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "starting"); }
  Stream(const Stream&) = delete;
  ~Stream() { cudaStreamDestroy(stream_); }
  operator cudaStream_t() const { return stream_; }
  void wait(const char* doing) const { check(cudaStreamSynchronize(stream_), doing); }

 private:
  cudaStream_t stream_ = nullptr;
};

class Event {
 public:
  Event() { check(cudaEventCreateWithFlags(&event_, cudaEventDisableTiming), "starting"); }
  Event(const Event&) = delete;
  ~Event() { cudaEventDestroy(event_); }
  operator cudaEvent_t() const { return event_; }

 private:
  cudaEvent_t event_ = nullptr;
};

/// An array that is sent to the device now and then, and may grow.
template <class Value>
class Upload {
 public:
  Value* send(const std::vector<Value>& values, cudaStream_t stream) {
    if (values.size() > capacity_) {
      check(cudaStreamSynchronize(stream), "working");
      capacity_ = values.size() + values.size() / 2;
      device_ = DeviceBlock(capacity_ * sizeof(Value));
      host_ = PinnedBlock(capacity_ * sizeof(Value));
    }
    const std::size_t bytes = values.size() * sizeof(Value);
    if (bytes == 0) return device_.as<Value>();
    std::memcpy(host_.as<Value>(), values.data(), bytes);
    check(cudaMemcpyAsync(device_.as<Value>(), host_.as<Value>(), bytes, cudaMemcpyHostToDevice,
                          stream),
          "copying contacts");
    return device_.as<Value>();
  }

 private:
  std::size_t capacity_ = 0;
  DeviceBlock device_;
  PinnedBlock host_;
};

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

template <class Real>
class CudaSolver final : public StepSolver {
 public:
  CudaSolver(const Scene& scene, const SimulationOptions& options, Spread spread)
      : scene_(scene),
        device_(use_device()),
        finder_(scene, options),
        start_(local<Real>(scene, scene.start)),
        frames_(scene.wall_count > 0 ? 1 : kFramesPerLaunch) {
    program_.view = make_view<Real>(scene, options, memory_);
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
    const std::size_t count = scene.start.size();
    for (Batch& batch : batches_) {
      batch.device_x = memory_.allocate<Vec>(std::size_t(frames_) * count);
      batch.device_status = memory_.allocate<StepStatus>(std::size_t(frames_));
      batch.x = PinnedBlock(std::size_t(frames_) * count * sizeof(Vec));
      batch.status = PinnedBlock(std::size_t(frames_) * sizeof(StepStatus));
    }
    x_detected_ = memory_.allocate<Vec>(count);
    program_.view.x_detected = x_detected_;
    plastic_ = PinnedBlock(std::size_t(scene.clusters.count()) * sizeof(Mat));
    if (program_.view.entry_modes)
      plastic_modes_ = PinnedBlock(std::size_t(scene.clusters.count()) * kShapeModes * sizeof(Vec));
    contact_force_ = PinnedBlock(std::size_t(scene.wall_count) * sizeof(Real));
  }

  void run(const Inflator& inflator,
           const std::function<void(int frame, const State& state)>& on_state) override {
    if (scene_.wall_count > 0)
      run_with_wall(inflator, on_state);
    else
      run_free(inflator, on_state);
  }

  State settle(const GasLaw<double>& law, double tolerance, int most_sweeps) override {
    CudaProgram<Real> program = program_;
    program.rules.tolerance = program.rules.residual = tolerance;
    program.rules.rest = 0.0;
    program.rules.most_sweeps = most_sweeps;
    program.rules.still = true;
    status_.law = law;
    send_status();
    submit(program, batches_[0], 0, 1);
    copies_.wait("solving");
    status_ = batches_[0].status.template as<StepStatus>()[0];
    return state_of(batches_[0], 0);
  }

  [[nodiscard]] std::string device() const override {
    cudaDeviceProp properties;
    if (cudaGetDeviceProperties(&properties, device_) != cudaSuccess) return "GPU";
    return properties.name;
  }

 private:
  using Vec = Vec3T<Real>;
  using Mat = Mat3T<Real>;

  // Where the frames of a launch end up.
  struct Batch {
    Vec* device_x = nullptr;
    StepStatus* device_status = nullptr;
    PinnedBlock x, status;
    Event computed, copied;
    int first_frame = 0, frame_count = 0;
  };

  void send_status() {
    check(
        cudaMemcpyAsync(program_.status, &status_, sizeof status_, cudaMemcpyHostToDevice, stream_),
        "working");
  }

  // Launches frames and, once they are computed, their way back.
  void submit(CudaProgram<Real> program, Batch& batch, int first_frame, int frame_count) {
    program.first_frame = batch.first_frame = first_frame;
    program.frame_count = batch.frame_count = frame_count;
    program.frame_x = batch.device_x;
    program.frame_status = batch.device_status;
    check(launch(program, shape_, stream_), "being given work");
    check(cudaEventRecord(batch.computed, stream_), "working");
    check(cudaStreamWaitEvent(copies_, batch.computed, 0), "working");
    const std::size_t count = std::size_t(frame_count);
    check(
        cudaMemcpyAsync(batch.x.template as<Vec>(), batch.device_x,
                        count * scene_.start.size() * sizeof(Vec), cudaMemcpyDeviceToHost, copies_),
        "copying results");
    check(cudaMemcpyAsync(batch.status.template as<StepStatus>(), batch.device_status,
                          count * sizeof(StepStatus), cudaMemcpyDeviceToHost, copies_),
          "copying results");
    check(cudaEventRecord(batch.copied, copies_), "working");
  }

  // All frames stay on the device; while a launch runs, the one before it is handed out.
  void run_free(const Inflator& inflator,
                const std::function<void(int frame, const State& state)>& on_state) {
    send_status();
    check(cudaMemcpyAsync(inflator_, &inflator, sizeof inflator, cudaMemcpyHostToDevice, stream_),
          "working");
    CudaProgram<Real> program = program_;
    program.inflator = inflator_;
    int next = 1, turn = 0;
    const auto submit_next = [&] {
      const int count = std::min(frames_, inflator.frame_count() - next);
      batches_[std::size_t(turn)].frame_count = 0;
      if (count <= 0) return;
      submit(program, batches_[std::size_t(turn)], next, count);
      next += count;
    };
    submit_next();
    on_state(0, start_state(scene_, status_.pressure));
    for (;;) {
      Batch& batch = batches_[std::size_t(turn)];
      turn = 1 - turn;
      submit_next();
      if (batch.frame_count == 0) break;
      check(cudaEventSynchronize(batch.copied), "solving");
      for (int k = 0; k < batch.frame_count; ++k)
        on_state(batch.first_frame + k, state_of(batch, k));
    }
    stream_.wait("solving");
  }

  // Contacts are found on the host, from the positions at a frame's start and wherever a vertex has
  // met its bound. While the GPU sweeps, the frame before is handed out.
  void run_with_wall(const Inflator& inflator,
                     const std::function<void(int frame, const State& state)>& on_state) {
    Inflator schedule = inflator;
    State last = start_state(scene_, status_.pressure);
    std::vector<Vec3> x(start_.size());
    for (std::size_t v = 0; v < x.size(); ++v) x[v] = converted<double>(start_[v]);
    for (int frame = 1; frame < schedule.frame_count(); ++frame) {
      status_.law = schedule.law(frame, status_.pressure * status_.volume, status_.volume);
      CudaProgram<Real> program = program_;
      finder_.begin(x);
      int detections = 0;
      do {
        detect(finder_.find(x), program.view);
        status_.since_detection = 0;
        send_status();
        submit(program, batches_[0], frame, 1);
        if (detections++ == 0) on_state(frame - 1, last);
        check(cudaEventSynchronize(batches_[0].copied), "solving");
        status_ = *batches_[0].status.template as<StepStatus>();
        const Vec* reached = batches_[0].x.template as<Vec>();
        for (std::size_t v = 0; v < x.size(); ++v) x[v] = converted<double>(reached[v]);
        program.parts = kSweeps | kEnd;
      } while (status_.wants_detection);
      status_.report.detections = detections;
      last = wall_state();
    }
    on_state(schedule.frame_count() - 1, last);
  }

  void detect(ContactSet&& set, StepView<Real>& view) {
    const ContactArrays<Real> contacts = converted<Real>(std::move(set));
    view.pair_count = int(contacts.pairs.size());
    view.pairs = pairs_.send(contacts.pairs, stream_);
    view.ref_begin = ref_begin_.send(contacts.ref_begin, stream_);
    view.refs = refs_.send(contacts.refs, stream_);
    view.bound_begin = bound_begin_.send(contacts.bound_begin, stream_);
    view.bounds = bounds_.send(contacts.bounds, stream_);
    view.travel = contacts.travel;
    check(cudaMemcpyAsync(x_detected_, view.x, scene_.start.size() * sizeof(Vec),
                          cudaMemcpyDeviceToDevice, stream_),
          "working");
  }

  template <class Value>
  void bring(Value* to, const Value* from, std::size_t count) {
    if (count == 0) return;
    check(cudaMemcpyAsync(to, from, count * sizeof(Value), cudaMemcpyDeviceToHost, stream_),
          "copying results");
  }

  State wall_state() {
    const auto clusters = std::size_t(scene_.clusters.count());
    const std::size_t modes = program_.view.entry_modes ? clusters * kShapeModes : 0;
    bring(plastic_.as<Mat>(), program_.view.cluster_plastic, clusters);
    bring(plastic_modes_.as<Vec>(), program_.view.cluster_plastic_modes, modes);
    bring(contact_force_.as<Real>(), program_.view.contact_force, std::size_t(scene_.wall_count));
    stream_.wait("copying results");
    State state = state_of(batches_[0], 0);
    state.report = status_.report;
    for (std::size_t c = 0; c < clusters; ++c)
      state.plastic.push_back(converted<double>(plastic_.as<Mat>()[c]));
    for (std::size_t k = 0; k < modes; ++k)
      state.plastic_modes.push_back(converted<double>(plastic_modes_.as<Vec>()[k]));
    for (int i = 0; i < scene_.wall_count; ++i)
      state.contact_pressure.push_back(double(contact_force_.as<Real>()[i]) /
                                       finder_.area(scene_.balloon_count + i));
    return state;
  }

  State state_of(const Batch& batch, int k) const {
    const StepStatus& status = batch.status.template as<StepStatus>()[k];
    State state;
    state.x = global(scene_, start_.data(),
                     batch.x.template as<Vec>() + std::size_t(k) * scene_.start.size());
    state.pressure = status.pressure;
    state.volume = status.volume;
    state.report = status.report;
    return state;
  }

  const Scene& scene_;
  int device_;
  DeviceMemory memory_;
  ContactFinder finder_;
  std::vector<Vec> start_;
  int frames_;
  CudaProgram<Real> program_;
  CudaShape shape_;
  StepStatus status_;
  Inflator* inflator_ = nullptr;
  Vec* x_detected_ = nullptr;
  Stream stream_, copies_;
  std::array<Batch, 2> batches_;
  PinnedBlock plastic_, plastic_modes_, contact_force_;
  Upload<NearPair<Real>> pairs_;
  Upload<int> ref_begin_, bound_begin_;
  Upload<ContactRef> refs_;
  Upload<MotionBound<Real>> bounds_;
};

}  // namespace

bool has_cuda_device() {
  try {
    use_device();
    return true;
  } catch (const Error&) {
    return false;
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
