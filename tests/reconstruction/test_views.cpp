#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/error.hpp"
#include "core/units.hpp"
#include "reconstruction/detail/tube_volume.hpp"
#include "reconstruction/detail/vessel_lines.hpp"
#include "reconstruction/detail/view_by_view.hpp"
#include "reconstruction/detail/view_shifts.hpp"
#include "reconstruction/detail/view_vessel.hpp"
#include "reconstruction/views.hpp"
#include "tests/reconstruction/tube_views.hpp"

namespace angio::reconstruction {
namespace {

using namespace detail;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

const Tube kNarrowed{{2.0, -1.0, -20.0}, {-3.0, 2.0, 20.0}, 1.5, 0.6};

/// @param moved  how far the C-arm of the second view stands from where it says
struct TwoViews {
  explicit TwoViews(const std::vector<Tube>& tubes, const Vec3& moved = {})
      : told{frame_at(-30.0, 10.0), frame_at(35.0, -5.0)},
        pictures(tubes, {told[0], shifted(told[1], moved)}) {
    run.frames = told;
    run.pictures = &pictures;
  }
  std::vector<angiogram::ConeBeamFrame> told;
  TubePictures pictures;
  RotationalRun run;
};

/// The first view of some pictures and the second one of others.
class ApartPictures : public FrameReader {
 public:
  ApartPictures(const FrameReader& first, const FrameReader& second)
      : first_(first), second_(second) {}
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    std::vector<float> pixels;
    for (int n = first; n < first + count; ++n) {
      const std::vector<float> one = (n == 0 ? first_ : second_).read(n, 1);
      pixels.insert(pixels.end(), one.begin(), one.end());
    }
    return pixels;
  }

 private:
  const FrameReader &first_, &second_;
};

double least_diameter(const TreeFit& fit) {
  double least = 1e9;
  for (const double radius : fit.tree.paths.front().equivalent_radius)
    least = std::min(least, 2.0 * radius);
  return least;
}

TEST(Views, OfANarrowedVesselGiveItsThroatAndItsWidth) {
  const TwoViews views({kNarrowed});
  const TreeOfViews found = reconstruct_views(views.run, {});
  ASSERT_EQ(found.fit.tree.paths.size(), 1U);
  EXPECT_NEAR(least_diameter(found.fit), 1.2, 0.1);
  const auto& radii = found.fit.tree.paths.front().equivalent_radius;
  std::vector<double> sorted(radii);
  std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2),
                   sorted.end());
  EXPECT_NEAR(sorted[sorted.size() / 2], 1.5, 0.05);
  // Beside its axis by the same everywhere (what all C-arms are moved by cannot be seen), little,
  // and as long as it is.
  const Vec3 along = normalized(kNarrowed.to - kNarrowed.from);
  std::vector<Vec3> off;
  Vec3 mean;
  for (const Vec3& point : found.fit.tree.paths.front().points) {
    off.push_back(point - kNarrowed.from - dot(point - kNarrowed.from, along) * along);
    mean += off.back() / double(found.fit.tree.paths.front().points.size());
  }
  EXPECT_LT(norm(mean), 1.0);
  for (const Vec3& one : off) EXPECT_LT(norm(one - mean), 0.15);
  EXPECT_NEAR(found.fit.tree.paths.front().abscissa.back(), norm(kNarrowed.to - kNarrowed.from),
              3.0);
  EXPECT_GT(found.agreement, 0.95);
}

TEST(Views, OfATableThatMovedTellByHowMuchAcrossTheirPlanes) {
  const Vec3 moved{0.0, 0.0, 6.0};
  const TwoViews views({kNarrowed}, moved);
  const TreeOfViews found = reconstruct_views(views.run, {});
  const Vec3 line = normalized(views.told[1].source - views.told[0].source);
  const Vec3 across = normalized(cross(line, views.told[0].source));
  EXPECT_NEAR(dot(found.shifts_mm[1], across), dot(moved, across), 0.6);
  EXPECT_NEAR(least_diameter(found.fit), 1.2, 0.15);
}

/// Options that name a vessel by its ends in each view.
ViewsOptions asked_for(const Tube& tube, const TwoViews& views) {
  ViewsOptions options;
  for (const auto& frame : views.told) {
    const angiogram::ConeBeamView view(frame);
    const auto first = view.see(tube.from), last = view.see(tube.to);
    options.ends.push_back({{first.column, first.row}, {last.column, last.row}});
  }
  return options;
}

TEST(Views, WithMuchThatTheTreeDoesNotExplainAreInDoubt) {
  const TwoViews clean({kNarrowed});
  EXPECT_EQ(reconstruct_views(clean.run, {}).doubt, "");
  // Of two more vessels, as long as the first one, each view shows one: as bones do.
  const Tube first{{16.0, 6.0, -20.0}, {14.0, 8.0, 20.0}, 1.2, 1.2},
      second{{-16.0, -8.0, -20.0}, {-12.0, -10.0, 20.0}, 1.2, 1.2};
  TwoViews views({kNarrowed});
  const TubePictures one({kNarrowed, first}, views.told), other({kNarrowed, second}, views.told);
  const ApartPictures pictures(one, other);
  views.run.pictures = &pictures;
  EXPECT_THAT(reconstruct_views(views.run, {}).doubt,
              AllOf(HasSubstr("not determined"), HasSubstr("--ends")));
  EXPECT_EQ(reconstruct_views(views.run, asked_for(kNarrowed, views)).doubt, "");
}

TEST(Views, OfNamedEndsThatShowDifferentThingsAreInDoubt) {
  // The second view's ends are those of a vessel narrowed elsewhere that no medium fills beyond.
  const Tube other{kNarrowed.from, kNarrowed.from + 0.5 * (kNarrowed.to - kNarrowed.from), 1.5,
                   0.3};
  TwoViews views({kNarrowed});
  const TubePictures one({kNarrowed}, views.told), second({other}, views.told);
  const ApartPictures pictures(one, second);
  views.run.pictures = &pictures;
  ViewsOptions options = asked_for(kNarrowed, views);
  options.ends[1] = asked_for(other, views).ends[1];
  EXPECT_THAT(reconstruct_views(views.run, options).doubt,
              AllOf(HasSubstr("not determined"), HasSubstr("medium agrees")));
}

TEST(Views, OfTwoVesselsGiveTheOneThatIsAskedFor) {
  const Tube other{{14.0, 3.0, -18.0}, {12.0, -4.0, 18.0}, 1.0, 1.0};
  const TwoViews views({kNarrowed, other});
  const ViewsOptions options = asked_for(kNarrowed, views);
  const TreeOfViews found = reconstruct_views(views.run, options);
  ASSERT_EQ(found.fit.tree.paths.size(), 1U);
  const auto& path = found.fit.tree.paths.front();
  EXPECT_LT(distance(path.points.front(), kNarrowed.from), 3.0);
  EXPECT_LT(distance(path.points.back(), kNarrowed.to), 3.0);
  EXPECT_NEAR(least_diameter(found.fit), 1.2, 0.12);
}

TEST(Views, OfAForkGiveOneBranchAsIfTheOtherWereNotThere) {
  // A sibling as wide leaves the vessel before its throat and runs beside it in both views.
  constexpr double kForkPart = 0.25;
  const Vec3 fork = kNarrowed.from + kForkPart * (kNarrowed.to - kNarrowed.from);
  const Tube sibling{fork, fork + Vec3{9.0, 7.0, 26.0}, 1.4, 1.4};
  const TwoViews views({kNarrowed, sibling});
  const ViewsOptions options = asked_for(kNarrowed, views);
  const TreeOfViews found = reconstruct_views(views.run, options);
  ASSERT_EQ(found.fit.tree.paths.size(), 1U);
  const auto& path = found.fit.tree.paths.front();
  const Vec3 axis = kNarrowed.to - kNarrowed.from;
  double squares = 0.0;
  std::size_t count = 0;
  for (std::size_t n = 0; n < path.points.size(); ++n) {
    const double part = dot(path.points[n] - kNarrowed.from, axis) / dot(axis, axis);
    // Beside the fork, where there is no section of the one vessel, and the ends.
    if (part < 0.05 || part > 0.95 || (part > 0.2 && part < 0.45)) continue;
    const double error = path.equivalent_radius[n] - kNarrowed.radius_at(part);
    squares += error * error;
    ++count;
  }
  ASSERT_GT(count, 20U);
  EXPECT_LT(std::sqrt(squares / double(count)), 0.04);
  EXPECT_NEAR(least_diameter(found.fit), 1.2, 0.1);
}

TEST(Views, FromOneSideAreRefused) {
  TwoViews views({kNarrowed});
  views.run.frames[1] = frame_at(-20.0, 10.0);
  EXPECT_THROW(reconstruct_views(views.run, {}), InputError);
}

TEST(Views, WithEndsOfOneViewAloneAreRefused) {
  const TwoViews views({kNarrowed});
  ViewsOptions options;
  options.ends.resize(1);
  EXPECT_THROW(reconstruct_views(views.run, options), OptionError);
}

TEST(Views, WithoutAVesselAreRefused) {
  const TwoViews views({});
  EXPECT_THROW(reconstruct_views(views.run, {}), InputError);
}

TEST(Views, WithoutMemoryForTheirVolumeAreRefused) {
  const TwoViews views({kNarrowed});
  ViewsOptions options;
  options.voxel_mm = 0.05;
  options.max_memory_gib = 0.01;  // 2.7 million voxels
  EXPECT_THAT([&] { reconstruct_views(views.run, options); },
              ThrowsMessage<InputError>(HasSubstr("volume")));
  options.max_memory_gib = 1.0;
  EXPECT_NO_THROW(reconstruct_views(views.run, options));
}

TEST(Views, WithoutMemoryForThePlacesThatMayBeVesselAreRefused) {
  const TwoViews views({kNarrowed});
  ViewsOptions options;
  options.max_memory_gib = 1e-4;
  EXPECT_THAT([&] { reconstruct_views(views.run, options); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("places"), HasSubstr("--ends"))));
  // Who has named them is not advised to.
  options.ends = asked_for(kNarrowed, views).ends;
  EXPECT_THAT([&] { reconstruct_views(views.run, options); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("places"), Not(HasSubstr("--ends")))));
}

TEST(Views, BehindTheCornerOfAShutterAreNotFitted) {
  // The rectangle around what is open is the whole frame.
  TwoViews views({kNarrowed});
  const angiogram::ConeBeamView view(views.told[0]);
  const auto end = view.see(kNarrowed.to);
  const double sign = end.row > 70.0 ? 1.0 : -1.0;
  const auto into_corner = [&](double column, double row) { return column + sign * row; };
  const auto cut = view.see(kNarrowed.from + 0.8 * (kNarrowed.to - kNarrowed.from));
  const double edge = into_corner(cut.column, cut.row);
  ViewsOptions options;
  options.covered = {std::vector<char>(std::size_t{140 * 140}, 0), {}};
  for (int row = 0; row < 140; ++row)
    for (int c = 0; c < 140; ++c)
      if (into_corner(c, row) > edge) options.covered[0][std::size_t(row * 140 + c)] = 1;
  const OpenField around = around_open(options.covered[0], 140, 140);
  EXPECT_EQ(around.last_column - around.first_column + around.last_row - around.first_row, 278);
  const TreeOfViews found = reconstruct_views(views.run, options);
  for (const Vec3& point : found.fit.tree.paths.front().points) {
    const auto seen = view.see(point);
    EXPECT_LT(into_corner(seen.column, seen.row), edge + 6.0);
  }
}

TEST(Views, AreFittedToNoPixelThatIsCovered) {
  // Whatever lies there: here another vessel, beside the wanted one in both views.
  const Vec3 beside{3.4, 0.0, 0.0};
  const Tube other{kNarrowed.from + beside, kNarrowed.to + beside, 1.2, 1.2};
  const TwoViews views({kNarrowed, other});
  ViewsOptions options = asked_for(kNarrowed, views);
  for (const auto& frame : views.told) {
    std::vector<char>& covered = options.covered.emplace_back();
    for (int row = 0; row < frame.rows; ++row)
      for (int c = 0; c < frame.columns; ++c)
        covered.push_back(way_through({other}, frame.source, frame.place(c, row)) > 0.0 ? 1 : 0);
  }
  const TreeOfViews found = reconstruct_views(views.run, options);
  const Vec3 axis = kNarrowed.to - kNarrowed.from;
  const auto& path = found.fit.tree.paths.front();
  for (std::size_t n = 0; n < path.points.size(); ++n) {
    const double part = dot(path.points[n] - kNarrowed.from, axis) / dot(axis, axis);
    if (part > 0.1 && part < 0.9) {
      EXPECT_NEAR(path.equivalent_radius[n], kNarrowed.radius_at(part), 0.12) << part;
    }
  }
}

TEST(Views, BehindAShutterAreNotFitted) {
  // A shutter covers a view from the vessel's quarter on, over what lies about its edge.
  TwoViews views({kNarrowed});
  const angiogram::ConeBeamView view(views.told[0]);
  const double edge = view.see(kNarrowed.from + 0.8 * (kNarrowed.to - kNarrowed.from)).row;
  const OpenField open = view.see(kNarrowed.to).row > edge ? OpenField{0, 139, 0, int(edge)}
                                                           : OpenField{0, 139, int(edge), 139};
  ViewsOptions options;
  options.covered = {std::vector<char>(std::size_t{140 * 140}, 0), {}};
  for (int row = 0; row < 140; ++row)
    for (int c = 0; c < 140; ++c)
      if (row < open.first_row || row > open.last_row)
        options.covered[0][std::size_t(row * 140 + c)] = 1;
  const TreeOfViews found = reconstruct_views(views.run, options);
  const auto& path = found.fit.tree.paths.front();
  for (const Vec3& point : path.points) {
    const double row = view.see(point).row;
    EXPECT_GT(row, open.first_row - 4.0);
    EXPECT_LT(row, open.last_row + 4.0);
  }
  EXPECT_NEAR(least_diameter(found.fit), 1.2, 0.1);
}

TEST(VesselLines, RunAlongTheMiddleAndTellTheRadius) {
  constexpr int kSide = 300;
  unsigned state = 1;
  for (const double radius : {2.5, 4.0, 7.0}) {
    std::vector<float> picture;
    for (int row = 0; row < kSide; ++row)
      for (int column = 0; column < kSide; ++column) {
        const double away = column - 150.3;
        state = state * 1664525U + 1013904223U;
        picture.push_back(float(2.0 * std::sqrt(std::max(0.0, radius * radius - away * away)) +
                                0.2 * double(state >> 8U) / double(1U << 24U)));
      }
    const VesselLines lines = find_vessel_lines(picture, kSide, kSide, 30.0);
    for (int row = 40; row < 260; ++row) {
      int on_line = 0;
      for (int column = 0; column < kSide; ++column) {
        const float found = lines.radius[std::size_t(row * kSide + column)];
        if (found <= 0.0F) continue;
        ++on_line;
        EXPECT_EQ(column, 150);
        EXPECT_NEAR(double(found), radius, 0.15 * radius + 0.3);
      }
      EXPECT_EQ(on_line, 1) << "radius " << radius << ", row " << row;
    }
  }
}

TEST(VesselLines, AreNotInAnEvenPicture) {
  EXPECT_TRUE(find_vessel_lines(std::vector<float>(64 * 64, 1.0F), 64, 64, 20.0).empty());
}

TEST(RadiiWithoutSd, AreThoseWhoseSdIsNoNumber) {
  TreeFit fit;
  fit.radius_sd = {{0.1, std::numeric_limits<double>::quiet_NaN()},
                   {std::numeric_limits<double>::infinity(), 0.0}};
  EXPECT_EQ(radii_without_sd(fit), 2U);
}

TEST(TubeVolume, HoldsAsMuchAsTheTube) {
  CenterlineTree tree;
  CenterlinePath& path = tree.paths.emplace_back();
  for (int n = 0; n <= 40; ++n) {
    path.points.push_back({0.5 * n, 0.1 * n, 0.2 * n});
    path.equivalent_radius.push_back(1.0 + 0.02 * n);
  }
  const Volume<float> volume = tube_volume(tree, 0.05, 0.2, 512);
  double sum = 0.0;
  for (const float value : volume.values) sum += double(value);
  const double height = distance(path.points.front(), path.points.back());
  const double cone = units::kPi * height * (1.0 * 1.0 + 1.0 * 1.8 + 1.8 * 1.8) / 3.0;
  EXPECT_NEAR(sum / 0.05 * std::pow(0.2, 3), cone, 0.02 * cone);
}

TEST(ViewByView, SkewIsHowFarTheViewsRaysPass) {
  // The same straight tube, and a second view that sees it 2 mm away across the planes.
  const std::vector<angiogram::ConeBeamFrame> frames{frame_at(-30.0, 0.0), frame_at(35.0, 0.0)};
  const Tube lying{{-15.0, 0.0, 1.0}, {15.0, 4.0, 1.0}, 1.5, 1.5};
  const TubePictures pictures({lying}, {frames[0], shifted(frames[1], {0.0, 0.0, 2.0})});
  RotationalRun run;
  run.frames = frames;
  run.pictures = &pictures;
  CenterlineTree tree;
  for (int n = 0; n <= 20; ++n)
    (n == 0 ? tree.paths.emplace_back() : tree.paths.front())
        .points.push_back(lying.from + (0.1 + 0.04 * n) * (lying.to - lying.from));
  std::vector<ViewPicture> views;
  for (int v = 0; v < 2; ++v) {
    std::vector<float> integrals = pictures.read(v, 1);
    for (float& value : integrals) value = float(std::log(40000.0 / double(value)));
    views.push_back(make_view_picture(frames[std::size_t(v)], integrals, {}, 12.0));
  }
  EXPECT_NEAR(view_skew(views, tree), 2.0, 0.3);
}

}  // namespace
}  // namespace angio::reconstruction
