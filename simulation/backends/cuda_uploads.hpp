#pragma once

#include <type_traits>
#include <vector>

#include "core/cuda/device_memory.hpp"
#include "simulation/backends/cuda_launch.hpp"
#include "simulation/backends/host_memory.hpp"
#include "simulation/contact/candidate_set.hpp"
#include "simulation/pbd/tets.hpp"

/// What goes to the GPU and comes back, array by array. Only cuda_solver.cpp includes this.
namespace angio::simulation::detail {

using cuda::check;
using cuda::DeviceMemory;
using cuda::Event;
using cuda::PinnedBlock;
using cuda::Stream;
using cuda::Upload;

/// A set of candidates on the device.
template <class Real>
class CandidateUpload {
 public:
  CandidateView<Real> send(const CandidateSet& set, const std::vector<Vec3T<Real>>& x,
                           cudaStream_t stream) {
    return {int(set.candidates.size()),
            candidates_.send(set.candidates, stream),
            owned_begin_.send(set.owned_begin, stream),
            ref_begin_.send(set.ref_begin, stream),
            refs_.send(set.refs, stream),
            x_.send(x, stream),
            Real(set.search_radius),
            Real(set.self_radius)};
  }

 private:
  Upload<Candidate> candidates_;
  Upload<int> owned_begin_, ref_begin_;
  Upload<ContactRef> refs_;
  Upload<Vec3T<Real>> x_;
};

/// What a step makes of its candidates.
template <class Real>
class PairMemory {
 public:
  void hold(const CandidateSet& set, cudaStream_t stream, NearPairView<Real>& near) {
    if (set.candidates.size() > size_) {
      check(cudaStreamSynchronize(stream), "working");  // the old arrays are in use until then
      size_ = set.candidates.size();
    }
    near.pairs = pairs_.hold(size_);
    near.pair_of = pair_of_.hold(size_);
    near.refs = refs_.hold(4 * size_);
    near.bounds = bounds_.hold(4 * size_);
  }

 private:
  Upload<NearPair<Real>> pairs_;
  Upload<int> pair_of_;
  Upload<ContactRef> refs_;
  Upload<MotionBound<Real>> bounds_;
  std::size_t size_ = 0;
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
    const std::size_t places = std::size_t(frames) + 1, vertices = std::size_t(state.x.count);
    device_.status = memory.allocate<StepStatus>(places);
    host_.status = blocks_.emplace_back(places * sizeof(StepStatus)).as<StepStatus>();
    device_.end_x = memory.allocate<Vec3T<Real>>(vertices);
    host_.end_x = blocks_.emplace_back(vertices * sizeof(Vec3T<Real>)).template as<Vec3T<Real>>();
  }

  /// Brings the frames of a launch here.
  void bring(int frames, cudaStream_t stream) {
    const auto copy = [&](auto* to, const auto* from, std::size_t count) {
      if (count == 0) return;
      check(cudaMemcpyAsync(to, from, count * sizeof *to, cudaMemcpyDeviceToHost, stream),
            "copying results");
    };
    copy(host_.status, device_.status, std::size_t(frames) + 1);
    copy(host_.end_x, device_.end_x, std::size_t(device_.state.x.count));
    for_each_state_array(
        [&](const auto& from, auto& to) {
          copy(to.data, from.data, std::size_t(frames) * std::size_t(from.count));
        },
        device_.state, host_.state);
  }

  [[nodiscard]] const CudaFrames<Real>& device() const { return device_; }
  [[nodiscard]] const StepStatus& status(int k) const { return host_.status[k]; }
  /// Where the launch ended.
  [[nodiscard]] const Vec3T<Real>* end_x() const { return host_.end_x; }
  /// Of the launch's frame k.
  [[nodiscard]] StateView<Real> state(int k) const {
    StateView<Real> frame = host_.state;
    for_each_state_array([&](auto& array) { array.data += std::ptrdiff_t(k) * array.count; },
                         frame);
    return frame;
  }

 private:
  CudaFrames<Real> device_, host_;
  std::vector<PinnedBlock> blocks_;
};

}  // namespace angio::simulation::detail
