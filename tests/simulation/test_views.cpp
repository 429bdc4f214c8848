#include <gtest/gtest.h>

#include <map>

#include "simulation/backends/host_memory.hpp"
#include "simulation/step/make_views.hpp"
#include "testing/simulation/layered.hpp"

namespace angio::simulation::detail {
namespace {

// Knows the size of each array that it has given.
class RecordingMemory {
 public:
  template <class Value>
  Value* store(std::vector<Value> values) {
    const std::size_t size = values.size();
    Value* data = memory_.store(std::move(values));
    if (size > 0) sizes_[data] = size;
    return data;
  }
  template <class Value>
  Value* allocate(std::size_t count) {
    return store(std::vector<Value>(count));
  }
  // Takes an array that a view lists. Returns whether it was given with this size.
  bool take(const void* data, std::size_t size) {
    const auto found = sizes_.find(data);
    if (found == sizes_.end() || found->second != size) return false;
    sizes_.erase(found);
    return true;
  }
  [[nodiscard]] std::size_t left() const { return sizes_.size(); }

 private:
  HostMemory memory_;
  std::map<const void*, std::size_t> sizes_;
};

// What copies views goes by their lists: each array of a model is in one, once, with its size.
void expect_all_listed(const SimulationModel& model, const SimulationOptions& options) {
  const Scene scene = make_scene(model, options);
  RecordingMemory memory;
  StepView<double> view = make_view<double>(scene, options, memory);
  view.for_each_array([&](ArrayRole, int count, auto&... arrays) {
    const auto expect_listed = [&](const auto* array) {
      if (array == nullptr || count == 0) return;
      EXPECT_TRUE(memory.take(array, std::size_t(count)));
    };
    (expect_listed(arrays), ...);
  });
  EXPECT_EQ(memory.left(), 0U);
}

TEST(StepViews, ListEveryArrayOfSlabsOnceWithItsSize) {
  const SimulationModel model = testing::make_model({});
  SimulationOptions options;
  expect_all_listed(model, options);
  options.wall.shape = WallShape::quadratic;
  expect_all_listed(model, options);
}

TEST(StepViews, ListEveryArrayOfALayeredWallOnceWithItsSize) {
  expect_all_listed(testing::layered_model(), testing::layered_options());
}

TEST(StepViews, ListEveryArrayOfAGuidewireOnceWithItsSize) {
  SimulationOptions options;
  options.guidewire.model = GuidewireModel::rod;
  SimulationModel model = testing::make_model({});
  model.guidewire.clear();
  for (int i = 0; i < 9; ++i) model.guidewire.push_back({0.0, 0.0, 0.5 * (i - 4)});
  expect_all_listed(model, options);
}

TEST(BodyRanges, TellWhoseAVertexIs) {
  BodyRanges bodies;
  bodies[Body::balloon] = {0, 4};
  bodies[Body::wall] = {4, 3};
  bodies[Body::guidewire] = {13, 2};  // behind two copies of the wall
  const Body expected[] = {Body::balloon, Body::wall, Body::wall, Body::guidewire};
  const int vertices[] = {3, 4, 12, 13};
  for (int i = 0; i < 4; ++i) EXPECT_EQ(bodies.of(vertices[i]), expected[i]);
  EXPECT_EQ(bodies.contact_count(), 9);
  EXPECT_EQ(bodies.contact_vertex(3), 3);
  EXPECT_EQ(bodies.contact_vertex(6), 6);
  EXPECT_EQ(bodies.contact_vertex(7), 13);
}

}  // namespace
}  // namespace angio::simulation::detail
