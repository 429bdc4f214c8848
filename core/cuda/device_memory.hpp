#pragma once

#include <cuda_runtime_api.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"

/// The GPU, its memory, streams and errors. Only the sources of a CUDA backend include this.
namespace angio::cuda {

[[noreturn]] inline void fail(cudaError_t error, const char* doing) {
  std::string text =
      "the GPU failed while " + std::string(doing) + " (" + cudaGetErrorString(error) + "). ";
  text += error == cudaErrorMemoryAllocation
              ? "Close other programs that use it, take a smaller model, or use --backend cpu"
              : "Check the driver with nvidia-smi, or use --backend cpu";
  throw Error(ExitCode::unavailable, text);
}

inline void check(cudaError_t error, const char* doing) {
  if (error != cudaSuccess) fail(error, doing);
}

inline constexpr int kLeastCapability = 75;

/// The GPU that is used.
/// @throws Error  there is none, or it is too old
inline int use_device() {
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

inline std::string name_of(int device) {
  cudaDeviceProp properties;
  if (cudaGetDeviceProperties(&properties, device) != cudaSuccess) return "GPU";
  return properties.name;
}

/// A block of the device's memory.
class DeviceBlock {
 public:
  DeviceBlock() = default;
  explicit DeviceBlock(std::size_t bytes) {
    check(cudaMalloc(&data_, std::max<std::size_t>(bytes, 16)), "taking its memory");
    cudaError_t cleared = cudaMemset(data_, 0, std::max<std::size_t>(bytes, 16));
    // Streams that do not wait for the one that clears would overtake it.
    if (cleared == cudaSuccess) cleared = cudaStreamSynchronize(nullptr);
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

/// Memory on the device: taken once, when the solver is made, and given back with it.
class DeviceMemory {
 public:
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

/// An array on the device that may grow, and what is sent to it.
template <class Value>
class Upload {
 public:
  /// The caller sees to it that the device no longer reads what was sent before.
  Value* send(const std::vector<Value>& values, cudaStream_t stream) {
    Value* sent = hold(values.size());
    if (host_size_ < values.size()) {
      host_ = PinnedBlock(capacity_ * sizeof(Value));
      host_size_ = capacity_;
    }
    const std::size_t bytes = values.size() * sizeof(Value);
    if (bytes == 0) return sent;
    std::memcpy(host_.as<Value>(), values.data(), bytes);
    check(cudaMemcpyAsync(sent, host_.as<Value>(), bytes, cudaMemcpyHostToDevice, stream),
          "copying contacts");
    return sent;
  }
  /// Has it at least this size. @return the array
  Value* hold(std::size_t size) {
    if (size > capacity_) {
      capacity_ = 2 * size;
      device_ = DeviceBlock(capacity_ * sizeof(Value));
    }
    return device_.as<Value>();
  }

 private:
  std::size_t capacity_ = 0, host_size_ = 0;
  DeviceBlock device_;
  PinnedBlock host_;
};

}  // namespace angio::cuda
