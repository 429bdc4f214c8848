#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
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

/// How much of a ray lies within balls along a tube [mm]: by steps along the ray, each within the
/// section at its own place.
double way_through(const Tube& tube, const Vec3& source, const Vec3& pixel) {
  constexpr double kStep = 0.05;
  const Vec3 ray = normalized(pixel - source), axis = tube.to - tube.from;
  const double length = norm(axis);
  const Vec3 along = axis / length;
  // The ray is nearest to the axis here.
  const Vec3 between = tube.from - source;
  const double b = dot(ray, along), d = dot(ray, between), e = dot(along, between);
  const double nearest = (d - b * e) / std::max(1e-12, 1.0 - b * b);
  double way = 0.0;
  for (double t = nearest - 8.0; t < nearest + 8.0; t += kStep) {
    const Vec3 place = source + t * ray;
    const double part = dot(place - tube.from, along) / length;
    if (part < 0.0 || part > 1.0) continue;
    const Vec3 off = place - tube.from - part * length * along;
    if (norm(off) < tube.radius_at(part)) way += kStep;
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
          double way = 0.0;
          for (const Tube& tube : tubes)
            way += way_through(tube, frame.source, frame.place(column, row));
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

TEST(Views, OfTwoVesselsGiveTheOneThatIsAskedFor) {
  const Tube other{{14.0, 3.0, -18.0}, {12.0, -4.0, 18.0}, 1.0, 1.0};
  const TwoViews views({kNarrowed, other});
  ViewsOptions options;
  for (const auto& frame : views.told) {
    const angiogram::ConeBeamView view(frame);
    const auto first = view.see(kNarrowed.from), last = view.see(kNarrowed.to);
    options.ends.push_back({{first.column, first.row}, {last.column, last.row}});
  }
  const TreeOfViews found = reconstruct_views(views.run, options);
  ASSERT_EQ(found.fit.tree.paths.size(), 1U);
  const auto& path = found.fit.tree.paths.front();
  EXPECT_LT(distance(path.points.front(), kNarrowed.from), 3.0);
  EXPECT_LT(distance(path.points.back(), kNarrowed.to), 3.0);
  EXPECT_NEAR(least_diameter(found.fit), 1.2, 0.12);
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
    views.push_back(make_view_picture(frames[std::size_t(v)], integrals, {0, 139, 0, 139}, 12.0));
  }
  EXPECT_NEAR(view_skew(views, tree), 2.0, 0.3);
}

}  // namespace
}  // namespace angio::reconstruction
