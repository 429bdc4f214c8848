#pragma once

#include <type_traits>
#include <vector>

#include "core/cuda/device_memory.hpp"
#include "simulation/backends/cuda_launch.hpp"
#include "simulation/backends/cuda_search.hpp"
#include "simulation/backends/host_memory.hpp"
#include "simulation/contact/make_candidate_search.hpp"
#include "simulation/pbd/tets.hpp"

/// What goes to the GPU and comes back, array by array. Only cuda_solver.cpp includes this.
namespace angio::simulation::detail {

using cuda::check;
using cuda::DeviceMemory;
using cuda::Event;
using cuda::PinnedBlock;
using cuda::Stream;
using cuda::Upload;

/// Room for candidates on the device, and for what a step makes of them.
template <class Real>
class CandidateMemory {
 public:
  /// The caller sees to it that nothing runs that uses the room there was.
  void hold(int capacity, CandidateSearch<Real>& search, NearPairView<Real>& near) {
    const auto size = std::size_t(capacity);
    memory_ = {};
    search.capacity = capacity;
    search.found = memory_.allocate<Candidate>(size);
    search.owned = memory_.allocate<FoundEntry>(size);
    search.entries = memory_.allocate<FoundEntry>(4 * size);
    search.list = memory_.allocate<Candidate>(size);
    search.refs = memory_.allocate<ContactRef>(4 * size);
    near.pairs = memory_.allocate<NearPair<Real>>(size);
    near.pair_of = memory_.allocate<int>(size);
    near.refs = memory_.allocate<ContactRef>(4 * size);
    near.bounds = memory_.allocate<MotionBound<Real>>(4 * size);
  }

 private:
  DeviceMemory memory_;
};

/// The tets of the reference method's contact, and whose viscous item has been set.
template <class Real>
class PbdUpload {
 public:
  void send(const PbdTets& tets, const std::vector<char>& viscous_items, cudaStream_t stream,
            PbdContact<Real>& contact) {
    contact.tet_count = int(tets.balloon_corners.size());
    contact.colors = int(tets.color_begin.size()) - 1;
    contact.color_begin = color_begin_.send(tets.color_begin, stream);
    contact.tets = vertices_.send(tets.vertices, stream);
    contact.balloon_corners = corners_.send(tets.balloon_corners, stream);
    contact.triggered = triggered_.send(viscous_items, stream);
  }

 private:
  Upload<int> color_begin_, vertices_, corners_;
  Upload<char> triggered_;
};

/// The step's arrays in the computer's memory, on their way to the device. A type of its own: the
/// linker would take what is compiled for it for what is compiled for the CPU's solver, which may
/// be for another processor.
class StagingMemory : public HostMemory {};

/// Copies a view to the device, what is only work space without its values.
template <class View>
View upload(View view, DeviceMemory& memory) {
  view.for_each_array([&](ArrayRole role, int count, auto&... arrays) {
    const auto move = [&](auto& array) {
      using Value = std::remove_const_t<std::remove_reference_t<decltype(*array)>>;
      if (array == nullptr) return;
      const auto size = std::size_t(count);
      Value* to = memory.allocate<Value>(size);
      if (role != ArrayRole::work && size > 0)
        check(cudaMemcpy(to, array, size * sizeof(Value), cudaMemcpyHostToDevice),
              "copying the scene");
      array = to;
    };
    (move(arrays), ...);
  });
  view.link();
  return view;
}

/// Where the frames of a launch end up, on the device and in the computer's memory.
template <class Real>
class FrameMemory {
 public:
  /// @param state  of the step, on the device
  void reserve(int frames, const StateView<Real>& state, DeviceMemory& memory) {
    for_each_state_array(
        [&](const auto& of_step, auto& device, auto& host) {
          using Value = std::remove_pointer_t<decltype(of_step.data)>;
          const std::size_t size = std::size_t(frames) * std::size_t(of_step.count);
          device = {memory.allocate<Value>(size), of_step.count};
          host = {blocks_.emplace_back(size * sizeof(Value)).template as<Value>(), of_step.count};
        },
        state, device_.state, host_.state);
    const std::size_t places = std::size_t(frames) + 1;
    device_.status = memory.allocate<StepStatus>(places);
    host_.status = blocks_.emplace_back(places * sizeof(StepStatus)).as<StepStatus>();
    found_ = blocks_.emplace_back(sizeof(int)).template as<int>();
  }

  /// Brings the frames of a launch here.
  void bring(int frames, cudaStream_t stream) {
    const auto copy = [&](auto* to, const auto* from, std::size_t count) {
      if (count == 0) return;
      check(cudaMemcpyAsync(to, from, count * sizeof *to, cudaMemcpyDeviceToHost, stream),
            "copying results");
    };
    copy(host_.status, device_.status, std::size_t(frames) + 1);
    for_each_state_array(
        [&](const auto& from, auto& to) {
          copy(to.data, from.data, std::size_t(frames) * std::size_t(from.count));
        },
        device_.state, host_.state);
  }

  [[nodiscard]] const CudaFrames<Real>& device() const { return device_; }
  [[nodiscard]] const StepStatus& status(int k) const { return host_.status[k]; }
  /// The candidates that the launch began with.
  [[nodiscard]] int* found() const { return found_; }
  /// Of the launch's frame k.
  [[nodiscard]] StateView<Real> state(int k) const {
    StateView<Real> frame = host_.state;
    for_each_state_array([&](auto& array) { array.data += std::ptrdiff_t(k) * array.count; },
                         frame);
    return frame;
  }

 private:
  CudaFrames<Real> device_, host_;
  int* found_ = nullptr;
  std::vector<PinnedBlock> blocks_;
};

}  // namespace angio::simulation::detail
