#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "core/units.hpp"
#include "reconstruction/detail/view_by_view.hpp"
#include "reconstruction/detail/view_poses.hpp"
#include "reconstruction/detail/view_tree.hpp"
#include "tests/reconstruction/tube_views.hpp"

namespace angio::reconstruction {
namespace {

using namespace detail;

constexpr double kDegree = units::kPi / 180.0;

/// Two vessels that lie askew, for one of them alone tells little.
const std::vector<Tube> kTubes{{{-16.0, -10.0, -18.0}, {14.0, 8.0, 16.0}},
                               {{-4.0, -2.8, -4.4}, {16.0, -12.0, 10.0}, 1.2, 1.2}};

CenterlineTree tree_of(const std::vector<Tube>& tubes) {
  CenterlineTree tree;
  for (const Tube& tube : tubes) {
    CenterlinePath& path = tree.paths.emplace_back();
    for (double part = 0.05; part < 0.96; part += 0.02)
      path.points.push_back(tube.from + part * (tube.to - tube.from));
  }
  return tree;
}

/// Views as their headers have them, of C-arms that stand elsewhere.
std::vector<ViewPicture> views_from(const std::vector<angiogram::ConeBeamFrame>& told,
                                    const std::vector<ViewPose>& true_poses) {
  std::vector<angiogram::ConeBeamFrame> stand;
  for (std::size_t v = 0; v < told.size(); ++v) stand.push_back(posed(told[v], true_poses[v]));
  const TubePictures pictures(kTubes, stand);
  std::vector<ViewPicture> views;
  for (std::size_t v = 0; v < told.size(); ++v) {
    std::vector<float> integrals = pictures.read(int(v), 1);
    for (float& value : integrals) value = float(std::log(40000.0 / double(value)));
    views.push_back(make_view_picture(told[v], integrals, {}, 12.0));
  }
  return views;
}

std::vector<ViewPicture> at(std::vector<ViewPicture> views, const std::vector<ViewPose>& poses) {
  for (std::size_t v = 0; v < views.size(); ++v) views[v].frame = posed(views[v].frame, poses[v]);
  return views;
}

const std::vector<ViewPose> kAside{{},
                                   {{0.0, 0.0, 1.0 * kDegree}, {0.0, 0.5, 1.5}},
                                   {{0.8 * kDegree, 0.0, 0.0}, {-1.0, 0.0, -1.2}},
                                   {{0.0, -0.8 * kDegree, 0.0}, {0.8, 0.6, 0.0}}};

std::vector<angiogram::ConeBeamFrame> four_frames() {
  return {frame_at(-30.0, 10.0), frame_at(35.0, -5.0), frame_at(0.0, 35.0), frame_at(-5.0, -30.0)};
}

TEST(ViewPoses, OfAFrameSeePosedPlacesWhereItSeesThem) {
  const ViewPose pose{{0.03, -0.02, 0.05}, {4.0, -3.0, 7.0}};
  const angiogram::ConeBeamFrame frame = frame_at(-30.0, 10.0);
  const Vec3 place{7.0, -11.0, 13.0};
  const auto seen = angiogram::ConeBeamView(frame).see(place),
             then = angiogram::ConeBeamView(posed(frame, pose)).see(posed(place, pose));
  EXPECT_NEAR(then.column, seen.column, 1e-9);
  EXPECT_NEAR(then.row, seen.row, 1e-9);
  EXPECT_NEAR(then.depth, seen.depth, 1e-12);
  // A turn keeps lengths.
  EXPECT_NEAR(norm(posed(place, {pose.turn, {}})), norm(place), 1e-12);
}

TEST(ViewPoses, OfFourViewsBringTheirRaysTogether) {
  const std::vector<ViewPicture> views = views_from(four_frames(), kAside);
  const CenterlineTree tree = tree_of(kTubes);
  const std::vector<ViewPose> poses =
      find_view_poses(views, tree, std::vector<ViewPose>(views.size()));
  const double pixel = finest_pixel(four_frames());
  EXPECT_GT(view_skew(views, tree), 1.5 * pixel);
  // Nearly as near as where the C-arms truly stand: lines are known to a pixel.
  EXPECT_LT(view_skew(at(views, poses), tree), 1.25 * view_skew(at(views, kAside), tree));
  EXPECT_EQ(norm(poses[0].turn) + norm(poses[0].shift), 0.0);
}

TEST(ViewPoses, OfTwoViewsAreNotTold) {
  const std::vector<ViewPicture> views =
      views_from({frame_at(-30.0, 10.0), frame_at(35.0, -5.0)}, {kAside[0], kAside[1]});
  for (const ViewPose& pose : find_view_poses(views, tree_of(kTubes), std::vector<ViewPose>(2)))
    EXPECT_EQ(norm(pose.turn) + norm(pose.shift), 0.0);
}

TEST(PosedTree, KeepsToHeadersThatItsViewsDoNotContradict) {
  const std::vector<ViewPicture> views = views_from(four_frames(), std::vector<ViewPose>(4));
  const PosedTree posed_tree = find_posed_tree(views, 1ULL << 32U, {});
  for (const ViewPose& pose : posed_tree.poses) EXPECT_EQ(norm(pose.turn) + norm(pose.shift), 0.0);
}

TEST(PosedTree, ExplainsMoreOfViewsWhoseCArmsStoodElsewhere) {
  const std::vector<ViewPicture> views = views_from(four_frames(), kAside);
  const ViewTree as_told = find_view_tree(views, 1ULL << 32U, {});
  const PosedTree posed_tree = find_posed_tree(views, 1ULL << 32U, {});
  const auto sum = [](const std::vector<double>& parts) {
    double all = 0.0;
    for (const double part : parts) all += part;
    return all;
  };
  EXPECT_GT(sum(posed_tree.found.explained_parts), sum(as_told.explained_parts) + 0.3);
}

}  // namespace
}  // namespace angio::reconstruction
