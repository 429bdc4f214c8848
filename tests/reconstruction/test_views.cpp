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

namespace angio::reconstruction {
namespace {

using namespace detail;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A tube of round section around a straight line, narrowed in its middle.
struct Tube {
  Vec3 from, to;
  double radius = 1.5, throat = 1.5;
  [[nodiscard]] double radius_at(double part) const {
    const double away = std::abs(part - 0.5) / 0.1;
    return away < 1.0 ? throat + (radius - throat) * 0.5 * (1.0 - std::cos(units::kPi * away))
                      : radius;
  }
};

/// A ray, and where it is nearest to a tube's axis.
struct TubeRay {
  Vec3 source, ray;
  double nearest = 0.0;
};

TubeRay ray_at(const Tube& tube, const Vec3& source, const Vec3& pixel) {
  const Vec3 ray = normalized(pixel - source), along = normalized(tube.to - tube.from),
             between = tube.from - source;
  const double b = dot(ray, along), d = dot(ray, between), e = dot(along, between);
  return {source, ray, (d - b * e) / std::max(1e-12, 1.0 - b * b)};
}

bool is_within(const Tube& tube, const Vec3& place) {
  const Vec3 axis = tube.to - tube.from;
  const double part = dot(place - tube.from, axis) / dot(axis, axis);
  return part >= 0.0 && part <= 1.0 && norm(place - tube.from - part * axis) < tube.radius_at(part);
}

/// How much of a ray lies within the tubes [mm], where they meet once: by steps along the ray.
double way_through(const std::vector<Tube>& tubes, const Vec3& source, const Vec3& pixel) {
  constexpr double kStep = 0.05, kReach = 8.0;
  double way = 0.0;
  for (std::size_t n = 0; n < tubes.size(); ++n) {
    const TubeRay ray = ray_at(tubes[n], source, pixel);
    for (double t = ray.nearest - kReach; t < ray.nearest + kReach; t += kStep) {
      const Vec3 place = source + t * ray.ray;
      const auto holds = [&](const Tube& tube) { return is_within(tube, place); };
      if (holds(tubes[n]) && std::none_of(tubes.begin(), tubes.begin() + std::ptrdiff_t(n), holds))
        way += kStep;
    }
  }
  return way;
}

angiogram::ConeBeamFrame frame_at(double primary, double secondary) {
  angiogram::CArmMount mount;
  mount.columns = mount.rows = 140;
  mount.column_spacing_mm = mount.row_spacing_mm = 0.6;
  mount.central_column = mount.central_row = 69.5;
  return angiogram::c_arm_frame({primary, secondary}, mount);
}

/// Pictures of tubes, linear in the beam, with a noise of a hundredth that is the same each time.
class TubePictures : public FrameReader {
 public:
  TubePictures(const std::vector<Tube>& tubes,
               const std::vector<angiogram::ConeBeamFrame>& frames) {
    unsigned state = 1;
    for (const auto& frame : frames)
      for (int row = 0; row < frame.rows; ++row)
        for (int column = 0; column < frame.columns; ++column) {
          const double way = way_through(tubes, frame.source, frame.place(column, row));
          state = state * 1664525U + 1013904223U;
          const double noise = 1.0 + 0.017 * (double(state >> 8U) / double(1U << 24U) - 0.5) * 2.0;
          pixels_.push_back(float(40000.0 * noise * std::exp(-0.08 * way)));
        }
    per_frame_ = pixels_.size() / frames.size();
  }
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    const auto begin = pixels_.begin() + std::ptrdiff_t(std::size_t(first) * per_frame_);
    return {begin, begin + std::ptrdiff_t(std::size_t(count) * per_frame_)};
  }

 private:
  std::vector<float> pixels_;
  std::size_t per_frame_ = 0;
};

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
              ThrowsMessage<InputError>(HasSubstr("places")));
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

/// Lines of a picture: columns that run down it from a first to a last row, with their radius.
struct Upright {
  int column = 0, first = 0, last = 0;
  float radius = 0.0F;
};

VesselLines upright_lines(const std::vector<Upright>& all) {
  constexpr int kSide = 100;
  VesselLines lines{kSide, kSide, std::vector<float>(std::size_t(kSide * kSide), 0.0F)};
  for (const Upright& one : all)
    for (int row = one.first; row <= one.last; ++row)
      lines.radius[std::size_t(row * kSide + one.column)] = one.radius;
  return lines;
}

constexpr Upright kKept{40, 5, 95, 4.0F};

/// What is left out beside a kept vessel, where each line is a tube's but `edges`: bone, which
/// begins a radius before them and reaches to the picture's right.
OtherPixels other_pixels_beside(const std::vector<Upright>& tubes,
                                const std::vector<Upright>& edges = {}) {
  constexpr int kSide = 100;
  std::vector<Upright> all(tubes);
  all.push_back(kKept);
  ViewPicture kept;
  kept.lines = upright_lines({kKept});
  find_nearest(kept);
  kept.vessels.assign(std::size_t(kSide * kSide), 0.0F);
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column) {
      float& value = kept.vessels[std::size_t(row * kSide + column)];
      for (const Upright& tube : all) {
        const float away = float(column - tube.column);
        if (row >= tube.first && row <= tube.last)
          value += 2.0F * std::sqrt(std::max(0.0F, tube.radius * tube.radius - away * away));
      }
      for (const Upright& edge : edges)
        if (float(column) >= float(edge.column) - edge.radius) value += 10.0F;
    }
  all.insert(all.end(), edges.begin(), edges.end());
  return pixels_of_others(upright_lines(all), kept);
}

std::vector<char> others_beside(const std::vector<Upright>& tubes,
                                const std::vector<Upright>& edges = {}) {
  return other_pixels_beside(tubes, edges).covered;
}

TEST(PixelsOfOthers, AreThoseThatAnotherVesselCoversAndNoneBeyond) {
  const std::vector<char> covered = others_beside({{60, 5, 95, 4.0F}});
  for (int row = 10; row <= 90; ++row) {
    const auto at = [&](int column) { return covered[std::size_t(row * 100 + column)]; };
    for (int column = 56; column <= 64; ++column) EXPECT_EQ(at(column), 1) << column;
    // The kept vessel, and its background on both sides.
    for (int column = 30; column <= 50; ++column) EXPECT_EQ(at(column), 0) << column;
    EXPECT_EQ(at(70), 0);
  }
}

TEST(PixelsOfOthers, BehindWhichBoneBeginsAreLeftOutAsBeforeNone) {
  const std::vector<char> covered = others_beside({{60, 5, 95, 4.0F}}, {{75, 5, 95, 4.0F}});
  for (int row = 10; row <= 90; ++row)
    for (int column = 56; column <= 64; ++column)
      EXPECT_EQ(covered[std::size_t(row * 100 + column)], 1) << column;
}

TEST(PixelsOfOthers, AreNoneOfTheBackgroundNextToTheVesselWhereBoneBegins) {
  // To 1.6 radii and two pixels; a vessel's there are left out.
  constexpr Upright kBeside{54, 5, 95, 4.0F};
  const std::vector<char> of_edge = others_beside({}, {kBeside}),
                          of_vessel = others_beside({kBeside});
  for (int row = 10; row <= 90; ++row) {
    const auto at = [row](const std::vector<char>& covered, int column) {
      return covered[std::size_t(row * 100 + column)];
    };
    EXPECT_EQ(at(of_edge, 48), 0);
    EXPECT_EQ(at(of_vessel, 48), 1);
    EXPECT_EQ(at(of_edge, 50), 1);
  }
}

TEST(PixelsOfOthers, AreABranchsFromWhereItLeavesTheVessel) {
  std::vector<Upright> branch;
  for (int row = 18; row <= 80; ++row) branch.push_back({43 + (row - 18) / 2, row, row, 4.0F});
  const std::vector<char> covered = others_beside(branch);
  EXPECT_EQ(covered[std::size_t(20 * 100 + 40)], 1);
  EXPECT_EQ(covered[std::size_t(8 * 100 + 40)], 0);
  EXPECT_EQ(covered[std::size_t(50 * 100 + 40)], 0);
}

TEST(PixelsOfOthers, AreNoneNextToTheVesselWhereItHidesWhatALineIs) {
  const std::vector<char> covered = others_beside({{48, 5, 95, 4.0F}});
  for (int row = 10; row <= 90; ++row) EXPECT_EQ(covered[std::size_t(row * 100 + 46)], 0);
}

TEST(PixelsOfOthers, AreNotTheVesselsOwnWhereItIsSeenTwice) {
  // Broader, 1.25 of its radii away; a stub; and its own line alone.
  for (const std::vector<Upright>& others :
       {std::vector<Upright>{{48, 30, 60, 6.4F}}, {{60, 40, 46, 3.0F}}, {}}) {
    const std::vector<char> covered = others_beside(others);
    EXPECT_EQ(std::count(covered.begin(), covered.end(), 1), 0);
  }
}

TEST(PixelsOfOthers, AreNoneWhereTheyHideMoreThanHalfOfTheVessel) {
  // A broad one lies along the vessel, over its right half and more, and then leaves it.
  const auto along = [](int last) {
    std::vector<Upright> broad{{50, 5, last, 7.0F}};
    for (int column = 51; column < 90; ++column) broad.push_back({column, last, last, 7.0F});
    return other_pixels_beside(broad);
  };
  const OtherPixels short_one = along(40), long_one = along(90);
  EXPECT_GT(short_one.hidden_part, 0.1);
  EXPECT_LT(short_one.hidden_part, 0.5);
  EXPECT_FALSE(short_one.covered.empty());
  EXPECT_GT(long_one.hidden_part, 0.5);
  EXPECT_TRUE(long_one.covered.empty());
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
