#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "core/error.hpp"
#include "datasets/rotational_run.hpp"
#include "segmentation/read_views.hpp"
#include "testing/temporary_folder.hpp"

namespace angio::segmentation {
namespace {

/// Views of a short tube on disk.
std::filesystem::path write_views(const std::filesystem::path& folder,
                                  const std::vector<angiogram::CArmAngles>& angles) {
  datasets::PhantomOptions phantom;
  phantom.name = "straight";
  phantom.length_mm = 10.0;
  datasets::RotationalRunOptions run;
  run.views = angles;
  run.frames = 2;
  run.body = false;
  return datasets::write_rotational_run(datasets::make_rotational_run(phantom, run), phantom,
                                        folder);
}

class StandingViews : public testing::Test {
 protected:
  angio::test::TemporaryFolder folder_;
};

TEST_F(StandingViews, AreReadWithTheirAnglesAndPictures) {
  const auto path = write_views(folder_.path() / "a", {{-30.0, 20.0}, {40.0, -15.0}});
  ASSERT_TRUE(are_views(path, {}));
  const auto loaded = read_views(path, {});
  ASSERT_TRUE(loaded);
  ASSERT_EQ(loaded->views.size(), 2U);
  const auto listed = list_views(path, {});
  for (std::size_t v = 0; v < 2; ++v) {
    const LoadedRun& view = loaded->views[v];
    EXPECT_EQ(view.frame_count, 2);
    const ViewSummary& line = listed[std::size_t(loaded->numbers[v] - 1)];
    EXPECT_NEAR(view.run.primary_angles_degrees.front(), line.primary_degrees, 1e-6);
    EXPECT_NEAR(view.run.secondary_angles_degrees.front(), line.secondary_degrees, 1e-6);
    const std::vector<float> pixels = view.pictures->read(1, 1);
    EXPECT_LT(*std::min_element(pixels.begin(), pixels.end()), 50000.0F);  // behind the vessel
  }
}

TEST_F(StandingViews, OfOneSideAreNone) {
  const auto path = write_views(folder_.path() / "a", {{0.0, 0.0}, {20.0, 0.0}});
  EXPECT_FALSE(are_views(path, {}));
  EXPECT_FALSE(read_views(path, {}));
}

TEST_F(StandingViews, FromTheSameSideCountOnceAndTheOtherIsTold) {
  const auto path = write_views(folder_.path() / "a", {{0.0, 0.0}, {60.0, 0.0}, {3.0, 0.0}});
  const auto loaded = read_views(path, {});
  ASSERT_TRUE(loaded);
  EXPECT_EQ(loaded->views.size(), 2U);
  EXPECT_TRUE(std::is_sorted(loaded->numbers.begin(), loaded->numbers.end()));
  EXPECT_TRUE(std::any_of(
      loaded->warnings.begin(), loaded->warnings.end(),
      [](const std::string& text) { return text.find("same side") != std::string::npos; }));
}

TEST_F(StandingViews, AreTakenInTheOrderThatIsAskedFor) {
  const auto path = write_views(folder_.path() / "a", {{0.0, 0.0}, {60.0, 0.0}, {0.0, 40.0}});
  ReadOptions options;
  options.views = "3,1";
  const auto loaded = read_views(path, options);
  ASSERT_TRUE(loaded);
  EXPECT_EQ(loaded->numbers, (std::vector<int>{3, 1}));
}

TEST_F(StandingViews, ThatAreNotThereAreRefused) {
  const auto path = write_views(folder_.path() / "a", {{0.0, 0.0}, {60.0, 0.0}});
  ReadOptions options;
  options.views = "1,7";
  EXPECT_THROW(read_views(path, options), InputError);
  options.views = "one";
  EXPECT_THROW(read_views(path, options), OptionError);
  options.views = "1";
  EXPECT_THROW(read_views(path, options), OptionError);  // no depth
}

TEST(ViewNumbers, AreThoseOfTheTextEachOnceInItsOrder) {
  const auto numbers = [](const char* text) { return ReadOptions{.views = text}.view_numbers(); };
  EXPECT_EQ(numbers(""), std::vector<int>{});
  EXPECT_EQ(numbers("3,1"), (std::vector<int>{3, 1}));
  EXPECT_EQ(numbers("12,2,12"), (std::vector<int>{12, 2}));
  for (const char* text :
       {"one", "1", "1,1", "0,1", "-1,2", "1,", ",1", "1,,2", "1 2", "1,99999999999"})
    EXPECT_THROW(ReadOptions{.views = text}.validate(), OptionError) << text;
}

TEST_F(StandingViews, ThatNeedMoreMemoryThanIsAllowedAreRefused) {
  const auto path = write_views(folder_.path() / "a", {{0.0, 0.0}, {60.0, 0.0}});
  ReadOptions options;
  options.max_memory_gib = 1e-5;
  EXPECT_THROW(read_views(path, options), InputError);
  options.max_memory_gib = 1.0;
  EXPECT_TRUE(read_views(path, options));
}

TEST_F(StandingViews, MoreThanSixMustBeNamed) {
  const auto path = write_views(folder_.path() / "a", {{-90.0, 0.0},
                                                       {-60.0, 0.0},
                                                       {-30.0, 0.0},
                                                       {0.0, 0.0},
                                                       {30.0, 0.0},
                                                       {60.0, 0.0},
                                                       {0.0, 40.0},
                                                       {0.0, -40.0}});
  EXPECT_THROW(read_views(path, {}), InputError);
}

}  // namespace
}  // namespace angio::segmentation
