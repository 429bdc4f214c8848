#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <future>

#include "core/cuda/device_memory.hpp"
#include "core/parallel.hpp"
#include "reconstruction/detail/cuda/kernels.hpp"
#include "reconstruction/detail/ramp_filter.hpp"
#include "reconstruction/detail/ray_weights.hpp"
#include "reconstruction/detail/volume_task.hpp"

namespace angio::reconstruction::detail {
namespace {

using cuda::check;
using cuda::DeviceBlock;

/// What a buffer of pictures takes at most, so that the GPU's and the computer's memory hold some.
constexpr std::size_t kBufferBytes = std::size_t(64) << 20;
constexpr std::size_t kCopyBytes = std::size_t(32) << 20;

template <class Value>
DeviceBlock to_device(const std::vector<Value>& values) {
  DeviceBlock block(values.size() * sizeof(Value));
  check(cudaMemcpy(block.as<Value>(), values.data(), values.size() * sizeof(Value),
                   cudaMemcpyHostToDevice),
        "copying the frames' places");
  return block;
}

/// Filtered frames as the GPU looks them up: a layer a frame, linear between samples.
class FrameLayers {
 public:
  FrameLayers(const PlaneGrid& plane, int count) {
    const cudaChannelFormatDesc format =
        cudaCreateChannelDesc(8 * int(sizeof(float)), 0, 0, 0, cudaChannelFormatKindFloat);
    const cudaExtent extent{std::size_t(plane.u_count), std::size_t(plane.v_count),
                            std::size_t(count)};
    check(cudaMalloc3DArray(&array_, &format, extent, cudaArrayLayered | cudaArraySurfaceLoadStore),
          "taking its memory");
    cudaResourceDesc resource{};
    resource.resType = cudaResourceTypeArray;
    resource.res.array.array = array_;
    cudaTextureDesc look{};
    look.addressMode[0] = look.addressMode[1] = cudaAddressModeClamp;
    look.filterMode = cudaFilterModeLinear;
    look.readMode = cudaReadModeElementType;
    cudaError_t error = cudaCreateTextureObject(&texture_, &resource, &look, nullptr);
    if (error == cudaSuccess) error = cudaCreateSurfaceObject(&surface_, &resource);
    if (error == cudaSuccess) return;
    release();
    cuda::fail(error, "taking its memory");
  }
  FrameLayers(const FrameLayers&) = delete;
  FrameLayers& operator=(const FrameLayers&) = delete;
  ~FrameLayers() { release(); }

  [[nodiscard]] cudaTextureObject_t texture() const { return texture_; }
  [[nodiscard]] cudaSurfaceObject_t surface() const { return surface_; }

 private:
  void release() {
    cudaDestroySurfaceObject(surface_);
    cudaDestroyTextureObject(texture_);
    cudaFreeArray(array_);
  }
  cudaArray_t array_ = nullptr;
  cudaTextureObject_t texture_ = 0;
  cudaSurfaceObject_t surface_ = 0;
};

class TimedEvent {
 public:
  TimedEvent() { check(cudaEventCreate(&event_), "starting"); }
  TimedEvent(const TimedEvent&) = delete;
  TimedEvent& operator=(const TimedEvent&) = delete;
  ~TimedEvent() { cudaEventDestroy(event_); }
  operator cudaEvent_t() const { return event_; }

 private:
  cudaEvent_t event_ = nullptr;
};

/// For how long a stream works on something.
class GpuClock {
 public:
  void start(cudaStream_t stream) {
    check(cudaEventRecord(laps_.emplace_back()[0], stream), "working");
  }
  void stop(cudaStream_t stream) { check(cudaEventRecord(laps_.back()[1], stream), "working"); }
  /// Once the work is done.
  [[nodiscard]] double seconds() const {
    double sum = 0.0;
    for (const auto& [first, last] : laps_) {
      float milliseconds = 0.0F;
      check(cudaEventElapsedTime(&milliseconds, first, last), "working");
      sum += double(milliseconds) * 1e-3;
    }
    return sum;
  }

 private:
  std::deque<std::array<TimedEvent, 2>> laps_;
};

/// Frames on their way to the GPU: two such buffers take turns, so that one is read into while the
/// other's frames are worked on.
struct Slot {
  Slot(std::size_t bytes, bool has_masks)
      : pictures(bytes),
        masks(has_masks ? bytes : 0),
        pictures_on_gpu(bytes),
        masks_on_gpu(has_masks ? bytes : 0) {}

  cuda::PinnedBlock pictures, masks;
  DeviceBlock pictures_on_gpu, masks_on_gpu;
  cuda::Event copied, done;  ///< onto the GPU; with what was copied
};

class GpuProjector {
 public:
  explicit GpuProjector(const VolumeTask& task);

  ProjectedBack run(const Progress& progress);

 private:
  [[nodiscard]] int frame_count() const { return int(task_.run.frames.size()); }
  void send(Slot& slot, int first, int count);
  void filter(Slot& slot, int first, int count);
  void project_back();
  void bring_back(std::vector<float>& values);
  void place_frames();

  const VolumeTask& task_;
  int columns_, rows_;
  std::size_t pixels_;
  int at_a_time_;
  cuda::Stream copies_, stream_;
  std::array<Slot, 2> slots_;
  FrameLayers layers_;
  int layers_begin_ = 0, layers_end_ = 0;  ///< the frames that stand in the layers
  DeviceBlock integrals_, volume_, truncated_;
  DeviceBlock frames_, weights_, response_, roots_;
  RowFilter filter_;
  std::vector<PlaneFrame> places_;
  GpuClock filtering_, projecting_;
};

void check_row_length(int device, int columns) {
  int bytes = 0;
  check(cudaDeviceGetAttribute(&bytes, cudaDevAttrMaxSharedMemoryPerBlockOptin, device),
        "starting");
  const std::size_t needed = std::size_t(fourier_length(3 * columns)) * sizeof(Complex);
  if (needed + sizeof(RowPairEnds) <= std::size_t(bytes)) return;
  throw Error(ExitCode::unavailable,
              "the frames' rows of " + std::to_string(columns) +
                  " pixels are longer than this GPU can filter. Use --backend cpu");
}

int frames_together(std::size_t pixels, std::size_t frames) {
  const std::size_t fit = kBufferBytes / (pixels * sizeof(float));
  return int(std::clamp<std::size_t>(fit, 1, std::min<std::size_t>(kMostFrames, frames)));
}

std::size_t voxel_count(const ColumnGrid& grid) {
  return std::size_t(grid.i_count) * std::size_t(grid.j_count) * std::size_t(grid.k_count);
}

GpuProjector::GpuProjector(const VolumeTask& task)
    : task_(task),
      columns_(task.run.frames.front().columns),
      rows_(task.run.frames.front().rows),
      pixels_(std::size_t(columns_) * std::size_t(rows_)),
      at_a_time_(frames_together(pixels_, task.run.frames.size())),
      slots_{Slot(std::size_t(at_a_time_) * pixels_ * sizeof(float), task.run.masks != nullptr),
             Slot(std::size_t(at_a_time_) * pixels_ * sizeof(float), task.run.masks != nullptr)},
      layers_(task.plane, std::min(kMostFrames, frame_count())),
      integrals_(std::size_t(at_a_time_) * pixels_ * sizeof(float)),
      volume_(voxel_count(task.columns) * sizeof(float)),
      truncated_(sizeof(unsigned)) {
  place_frames();
  filter_.columns = task.plane.u_count;
  filter_.beyond = task.plane.u_count / 2;
  filter_.length = fourier_length(3 * task.plane.u_count);
  filter_.spacing_mm = task.plane.sample_mm;
  const std::vector<float> response =
      ramp_response(filter_.length, task.plane.sample_mm, task.window);
  std::vector<float> in_place(std::size_t(filter_.length));
  for (int place = 0; place < filter_.length; ++place) {
    const int frequency = frequency_at(place, filter_.length);
    in_place[std::size_t(place)] =
        response[std::size_t(std::min(frequency, filter_.length - frequency))];
  }
  response_ = to_device(in_place);
  roots_ = to_device(fourier_roots(filter_.length));
  filter_.response = response_.as<float>();
  filter_.roots = roots_.as<Complex>();
}

void GpuProjector::place_frames() {
  const std::size_t count = task_.run.frames.size(), width = std::size_t(task_.plane.u_count);
  std::vector<FrameOnGpu> frames(count);
  std::vector<float> weights(count * width);
  places_.resize(count);
  parallel_for(std::ptrdiff_t(count), [&](std::ptrdiff_t n) {
    const std::size_t f = std::size_t(n);
    const angiogram::ConeBeamFrame& frame = task_.run.frames[f];
    places_[f] = place_on_plane(frame, task_.orbit, f, task_.plane);
    frames[f] = {plane_map(frame, task_.orbit, f, task_.plane), places_[f],
                 float(task_.orbit.step[f])};
    const std::vector<float> own = ray_weights(task_.orbit, f, across_mm(places_[f], task_.plane));
    std::copy(own.begin(), own.end(), weights.begin() + n * std::ptrdiff_t(width));
  });
  frames_ = to_device(frames);
  weights_ = to_device(weights);
}

/// Reads frames, and sets their copy going.
void GpuProjector::send(Slot& slot, int first, int count) {
  const std::size_t bytes = std::size_t(count) * pixels_ * sizeof(float);
  const auto copy = [&](const FrameReader& reader, const cuda::PinnedBlock& from,
                        const DeviceBlock& to) {
    reader.read_into(first, count, from.as<float>());
    check(cudaMemcpyAsync(to.as<float>(), from.as<float>(), bytes, cudaMemcpyHostToDevice, copies_),
          "copying frames");
  };
  copy(*task_.run.pictures, slot.pictures, slot.pictures_on_gpu);
  if (task_.run.masks) copy(*task_.run.masks, slot.masks, slot.masks_on_gpu);
  check(cudaEventRecord(slot.copied, copies_), "copying frames");
}

/// Brings frames that were sent into the layers, where there is room for them.
void GpuProjector::filter(Slot& slot, int first, int count) {
  if (first + count - layers_begin_ > kMostFrames) project_back();
  check(cudaStreamWaitEvent(stream_, slot.copied, 0), "working");
  filtering_.start(stream_);
  IntegralsTask integrals;
  integrals.pictures = slot.pictures_on_gpu.as<float>();
  integrals.masks = task_.run.masks ? slot.masks_on_gpu.as<float>() : nullptr;
  integrals.integrals = integrals_.as<float>();
  integrals.frame_count = count;
  integrals.columns = columns_;
  integrals.rows = rows_;
  integrals.open_field = task_.run.open_field.value_or(OpenField{0, columns_ - 1, 0, rows_ - 1});
  integrals.rule = beam_rule(task_.run.relation, task_.air);
  check(launch_integrals(integrals, stream_), "taking logarithms");
  FilterTask filter;
  filter.integrals = integrals_.as<float>();
  filter.frames = frames_.as<FrameOnGpu>() + first;
  filter.weights = weights_.as<float>() + std::size_t(first) * std::size_t(task_.plane.u_count);
  filter.frame_count = count;
  filter.first_layer = first - layers_begin_;
  filter.v_count = task_.plane.v_count;
  filter.filter = filter_;
  filter.filtered = layers_.surface();
  filter.truncated_rows = truncated_.as<unsigned>();
  check(launch_filter(filter, stream_), "filtering frames");
  filtering_.stop(stream_);
  check(cudaEventRecord(slot.done, stream_), "working");
  layers_end_ = first + count;
}

/// Adds the frames of the layers to the volume. Many at once, as it is read and written for it.
void GpuProjector::project_back() {
  projecting_.start(stream_);
  VoxelTask voxels;
  voxels.filtered = layers_.texture();
  voxels.u_count = task_.plane.u_count;
  voxels.frame_count = layers_end_ - layers_begin_;
  voxels.grid = task_.columns;
  voxels.values = volume_.as<float>();
  std::copy(places_.begin() + layers_begin_, places_.begin() + layers_end_, voxels.frames);
  check(launch_voxels(voxels, stream_), "projecting back");
  projecting_.stop(stream_);
  layers_begin_ = layers_end_;
}

/// The volume, by way of memory that the GPU writes to by itself: one part is copied on while the
/// next comes.
void GpuProjector::bring_back(std::vector<float>& values) {
  constexpr std::size_t kPart = kCopyBytes / sizeof(float);
  const std::array<cuda::PinnedBlock, 2> parts{cuda::PinnedBlock(kCopyBytes),
                                               cuda::PinnedBlock(kCopyBytes)};
  const std::array<cuda::Event, 2> came;
  const std::size_t count = (values.size() + kPart - 1) / kPart;
  const auto size = [&](std::size_t n) { return std::min(kPart, values.size() - n * kPart); };
  const auto ask = [&](std::size_t n) {
    check(cudaMemcpyAsync(parts[n % 2].as<float>(), volume_.as<float>() + n * kPart,
                          size(n) * sizeof(float), cudaMemcpyDeviceToHost, stream_),
          "copying the volume");
    check(cudaEventRecord(came[n % 2], stream_), "copying the volume");
  };
  ask(0);
  for (std::size_t n = 0; n < count; ++n) {
    if (n + 1 < count) ask(n + 1);
    check(cudaEventSynchronize(came[n % 2]), "copying the volume");
    constexpr std::size_t kPiece = std::size_t(1) << 18;
    const std::size_t pieces = (size(n) + kPiece - 1) / kPiece;
    parallel_for(std::ptrdiff_t(pieces), [&](std::ptrdiff_t p) {
      const std::size_t from = std::size_t(p) * kPiece;
      std::memcpy(values.data() + n * kPart + from, parts[n % 2].as<float>() + from,
                  std::min(kPiece, size(n) - from) * sizeof(float));
    });
  }
}

ProjectedBack GpuProjector::run(const Progress& progress) {
  ProjectedBack back;
  // Memory that is new to the program takes as long as reading into it.
  std::future<std::vector<float>> room = std::async(
      std::launch::async, [this] { return std::vector<float>(voxel_count(task_.columns)); });
  const int count = frame_count();
  for (int first = 0, n = 0; first < count; first += at_a_time_, ++n) {
    const int number = std::min(at_a_time_, count - first);
    report_frame(progress, first, count);
    Slot& slot = slots_[std::size_t(n % 2)];
    check(cudaEventSynchronize(slot.done), "projecting back");  // at once, the first time
    send(slot, first, number);
    filter(slot, first, number);
  }
  project_back();
  stream_.wait("projecting back");
  back.values = room.get();
  bring_back(back.values);
  unsigned truncated = 0;
  check(cudaMemcpy(&truncated, truncated_.as<unsigned>(), sizeof truncated, cudaMemcpyDeviceToHost),
        "copying the volume");
  back.truncated_percent =
      100.0 * double(truncated) / (double(count) * double(task_.plane.v_count));
  back.gpu = {filtering_.seconds(), projecting_.seconds()};
  return back;
}

}  // namespace

std::string require_gpu() { return cuda::name_of(cuda::use_device()); }

std::string gpu_name() {
  try {
    return require_gpu();
  } catch (const Error&) {
    return {};
  }
}

ProjectedBack project_back_on_gpu(const VolumeTask& task, const Progress& progress) {
  check_row_length(cuda::use_device(), task.plane.u_count);
  return GpuProjector(task).run(progress);
}

}  // namespace angio::reconstruction::detail
