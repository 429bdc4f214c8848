#include <gtest/gtest.h>

#include "simulation/backends/cuda_uploads.hpp"
#include "simulation/backends/step_solver.hpp"
#include "testing/simulation/candidate_cases.hpp"

/// The candidates that the GPU finds against those of the CPU; skipped where there is no GPU.
namespace angio::simulation::detail {
namespace {

// A search in the GPU's memory.
template <class Real>
class DeviceSearch {
 public:
  DeviceSearch(const testing::CandidateCase<Real>& c, int capacity) {
    StagingMemory staging;
    search_ = upload(make_candidate_search<Real>(c.scene, c.options, 4, staging), memory_);
    NearPairView<Real> near;
    candidates_.hold(capacity, search_, near);
    search_.x = sent(c.x);
    search_.velocity = sent(c.velocity);
    search_.x_before = sent(c.x_before);
    search_.status = sent(std::vector{c.status});
    scan_memory_ = memory_.allocate<char>(scan_bytes(search_.vertex_count + 1));
    check(cudaDeviceSynchronize(), "copying");
  }

  void run() {
    check(launch_search(search_, scan_memory_, stream_), "searching");
    stream_.wait("searching");
  }

  [[nodiscard]] testing::FoundCandidates found() const {
    const auto vertices = std::size_t(search_.vertex_count) + 1,
               count = std::size_t(brought(search_.found_count(), 1)[0]);
    return {{brought(search_.list, count), brought(search_.owned_begin, vertices), {}},
            brought(search_.ref_begin, vertices),
            brought(search_.refs, 4 * count)};
  }
  [[nodiscard]] SearchRadii<Real> radii() const { return brought(search_.radii, 1)[0]; }

  // As the GPU has rounded them they are those of its measures: in double precision.
  [[nodiscard]] SearchRadii<double> exact_radii() const {
    SearchMeasures measures = brought(search_.measures, 1)[0];
    CandidateSearch<Real> here = search_;
    here.measures = &measures;
    return radii_of(here);
  }

 private:
  template <class Value>
  const Value* sent(const std::vector<Value>& values) {
    Value* to = memory_.allocate<Value>(values.size());
    check(cudaMemcpy(to, values.data(), values.size() * sizeof(Value), cudaMemcpyHostToDevice),
          "copying");
    return to;
  }
  template <class Value>
  static std::vector<Value> brought(const Value* from, std::size_t count) {
    std::vector<Value> values(count);
    check(cudaMemcpy(values.data(), from, count * sizeof(Value), cudaMemcpyDeviceToHost),
          "copying");
    return values;
  }

  DeviceMemory memory_;
  Stream stream_;
  CandidateSearch<Real> search_;
  CandidateMemory<Real> candidates_;
  char* scan_memory_ = nullptr;
};

constexpr int kRoom = 100000;

template <class Real>
class CudaSearchIn : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_cuda_device()) GTEST_SKIP() << "no GPU";
  }
};
using Precisions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(CudaSearchIn, Precisions);

TYPED_TEST(CudaSearchIn, FindsAndOrdersWhatTheCpuDoes) {
  for (const auto& c : testing::candidate_cases<TypeParam>()) {
    SCOPED_TRACE(c.name);
    DeviceSearch<TypeParam> search(c, kRoom);
    search.run();
    const testing::FoundCandidates found = search.found();
    EXPECT_GT(found.set.candidates.size(), 100U);
    testing::expect_same(found, testing::ordered(c.scene, found.set.candidates));
    testing::expect_same_pairs(found.set.candidates,
                               testing::expected_candidates(c, search.exact_radii()));
  }
}

TYPED_TEST(CudaSearchIn, TwoSearchesGiveTheSameBits) {
  for (const auto& c : testing::candidate_cases<TypeParam>()) {
    SCOPED_TRACE(c.name);
    DeviceSearch<TypeParam> search(c, kRoom);
    search.run();
    const testing::FoundCandidates once = search.found();
    search.run();
    testing::expect_same(search.found(), once);
  }
}

TYPED_TEST(CudaSearchIn, WithoutRoomReachesNowhere) {
  DeviceSearch<TypeParam> search(testing::candidate_cases<TypeParam>().front(), 50);
  search.run();
  EXPECT_EQ(search.radii().search, TypeParam(0));
}

}  // namespace
}  // namespace angio::simulation::detail
