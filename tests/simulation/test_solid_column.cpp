#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>

#include "simulation/bodies/layered_wall.hpp"
#include "simulation/step/team.hpp"

/// The columns' rows of a small tube of three layers against the sum of its wedges' energies.
namespace angio::simulation::detail {
namespace {

class Columns : public ::testing::Test {
 protected:
  Columns() {
    TubeWall tube;
    tube.around = 8;
    tube.along = 3;
    tube.inner_radius_mm = [](double angle, double z) { return 1.0 + 0.1 * std::cos(angle) * z; };
    tube.outer_radius_mm = [](double, double) { return 1.6; };
    wall_ = make_tube_wall(tube);
    model_ = make_solid_model(wall_, {});
    columns_ = 8 * 4;
    lists_ = list_columns(model_, columns_);
    levels_ = int(wall_.vertices.size()) / columns_;
    std::mt19937 random(7u);
    std::normal_distribution<double> noise(0.0, 0.01);
    x_ = wall_.vertices;
    for (Vec3& p : x_) p += Vec3{noise(random), noise(random), noise(random)};
    make_rows();
    renew();
  }

  [[nodiscard]] SolidColumns columns() const {
    return {levels_,
            columns_,
            wall_.layer.data(),
            lists_.patch_begin.data(),
            lists_.patches.data(),
            lists_.wedge_begin.data(),
            lists_.wedges.data(),
            lists_.link_begin.data(),
            lists_.links.data()};
  }
  void make_rows() {
    const auto rows = std::size_t(levels_ * columns_);
    places_.resize(wall_.wedges.size());
    tangents_.resize(wall_.wedges.size());
    renewed_.resize(wall_.wedges.size());
    wedge_volume_.resize(wall_.wedges.size());
    patch_volume_.resize(std::size_t(model_.patch_count()));
    constant_.resize(rows);
    for (auto* blocks : {&pivot_, &upper_, &above_}) blocks->resize(rows);
    beside_.resize(lists_.links.size() * std::size_t(3 * levels_));
    low_.resize(lists_.patches.size());
    high_.resize(lists_.patches.size());
    steepness_.resize(std::size_t(columns_));
    forces_.resize(wall_.wedges.size());
    rows_ = {places_.data(),       tangents_.data(),     forces_.data(),   renewed_.data(),
             wedge_volume_.data(), patch_volume_.data(), constant_.data(), pivot_.data(),
             upper_.data(),        above_.data(),        beside_.data(),   low_.data(),
             high_.data(),         steepness_.data()};
  }
  void renew() {
    const SolidView<double> view = model_.view(x_.data());
    for (int w = 0; w < model_.wedge_count(); ++w) renew_wedge(view, rows_, oldest_slopes(1), w);
    for (int p = 0; p < model_.patch_count(); ++p) renew_patch(view, rows_, p);
    for (int i = 0; i < columns_; ++i) {
      gather_forces(i);
      gather_links(columns(), rows_, i, OneLane{});
      for (int l = 0; l < levels_; ++l) gather_level(view, columns(), rows_, i, l);
      steepness_[std::size_t(i)] = column_steepness(columns(), rows_, i);
    }
  }
  // Where no slopes have been renewed.
  void renew_forces() {
    const SolidView<double> view = model_.view(x_.data());
    for (int w = 0; w < model_.wedge_count(); ++w) renew_wedge(view, rows_, oldest_slopes(1), w);
    for (const Renewed renewed : renewed_) ASSERT_EQ(renewed, Renewed::force);
    for (int p = 0; p < model_.patch_count(); ++p) renew_patch(view, rows_, p);
    for (int i = 0; i < columns_; ++i) gather_forces(i);
  }
  // After strains so small that no line is renewed.
  void follow_volumes() {
    const SolidView<double> view = model_.view(x_.data());
    for (int w = 0; w < model_.wedge_count(); ++w) renew_wedge(view, rows_, oldest_slopes(1), w);
    for (const Renewed renewed : renewed_) EXPECT_EQ(renewed, Renewed::nothing);
    for (int p = 0; p < model_.patch_count(); ++p) renew_patch(view, rows_, p);
  }
  void gather_forces(int i) {
    gather_constants(columns(), rows_, i, OneLane{});
    for (int e = lists_.patch_begin[std::size_t(i)]; e < lists_.patch_begin[std::size_t(i) + 1];
         ++e)
      gather_patch(model_.view(x_.data()), columns(), rows_, i, e);
  }
  std::vector<Vec3> gradient(int column) const {
    Vec3 g[kMostColumnLevels];
    add_column_gradient(model_.view(x_.data()), columns(), rows_, column, OneLane{}, g);
    return {g, g + levels_};
  }
  // By the wedges' and patches' own energies.
  std::vector<Vec3> exact_gradient() const {
    struct Sum {
      std::vector<Vec3> gradient;
      void add_gradient(int v, const Vec3& slope) { gradient[std::size_t(v)] += slope; }
      void add_block(int, int, const Mat3&) {}
    } sum{std::vector<Vec3>(x_.size())};
    const SolidView<double> view = model_.view(x_.data());
    for (int p = 0; p < model_.patch_count(); ++p) add_patch(view, p, sum, [](Mat3(*)[6]) {});
    return sum.gradient;
  }
  // The largest difference of a column's forces over the largest force.
  double error() const {
    const std::vector<Vec3> exact = exact_gradient();
    double most = 0.0, size = 0.0;
    for (int i = 0; i < columns_; ++i) {
      const std::vector<Vec3> row = gradient(i);
      for (int l = 0; l < levels_; ++l) {
        const Vec3& e = exact[std::size_t(l * columns_ + i)];
        most = std::max(most, norm(row[std::size_t(l)] - e));
        size = std::max(size, norm(e));
      }
    }
    return most / size;
  }
  void strain(double by, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> u(-by, by);
    for (Vec3& p : x_) p += Vec3{u(random), u(random), u(random)};
  }

  LayeredWall wall_;
  SolidModel model_;
  ColumnLists lists_;
  int columns_ = 0, levels_ = 0;
  std::vector<Vec3> x_;
  std::vector<WedgePlace<double>> places_;
  std::vector<WedgeTangent<double>> tangents_;
  std::vector<WedgeForce<double>> forces_;
  std::vector<Renewed> renewed_;
  std::vector<double> steepness_;
  std::vector<double> wedge_volume_, patch_volume_;
  std::vector<Vec3> constant_, low_, high_;
  std::vector<Mat3> pivot_, upper_, above_;
  std::vector<Slope> beside_;
  ColumnRows<double> rows_;
};

// What slopes in single precision leave: 6e-8 of a slope times an edge, over the largest force.
constexpr double kOfSlopes = 5e-7;

TEST_F(Columns, HaveTheForcesOfTheSolidWhereTheTangentsWereTaken) { EXPECT_LT(error(), kOfSlopes); }

TEST_F(Columns, ErrOfSecondOrderInTheStrainSinceThen) {
  const std::vector<Vec3> place = x_;
  std::vector<double> errors;
  for (const double by : {1e-4, 7e-5, 5e-5}) {
    x_ = place;
    strain(by, 3u);
    follow_volumes();
    errors.push_back(error() / (by * by));
  }
  EXPECT_GT(errors[0], 0.0);
  EXPECT_NEAR(errors[0] / errors[1], 1.0, 0.1);
  EXPECT_NEAR(errors[1] / errors[2], 1.0, 0.1);
}

TEST_F(Columns, TakeTheTangentsAgainWhereTheWallIsStrained) {
  strain(0.01, 4u);
  const double before = error();
  renew();
  EXPECT_LT(error(), kOfSlopes);
  EXPECT_GT(before, 1e-3);
}

// Forces are exact at the places where they were taken, whatever the age of the slopes; around them
// old slopes leave an error of first order, small by the strain since the slopes were taken.
TEST_F(Columns, TakeTheForcesAgainWithTheirOldSlopes) {
  x_ = wall_.vertices;
  for (Vec3& p : x_) p = {1.1 * p.x, 1.1 * p.y, 1.05 * p.z};  // all fibres are taut
  const std::vector<Vec3> place = x_;
  std::vector<double> errors;
  for (const double since : {4e-3, 2.5e-3}) {
    x_ = place;
    renew();
    for (Vec3& p : x_) p = {(1.0 + since) * p.x, (1.0 - since) * p.y, (1.0 + since) * p.z};
    renew_forces();
    EXPECT_LT(error(), kOfSlopes);
    strain(1e-5, 5u);
    follow_volumes();
    errors.push_back(error());
    EXPECT_GT(errors.back(), kOfSlopes);
  }
  EXPECT_NEAR(errors[0] / errors[1], 1.6, 0.3);
}

TEST_F(Columns, TakeTheSlopesAgainWhereTheLawHasChanged) {
  for (Vec3& p : x_) p.z *= 1.2;
  renew();
  for (const Renewed renewed : renewed_) EXPECT_EQ(renewed, Renewed::slopes);
}

// Only the sums that have a new slope in them are taken again: to the last bit as if all were.
TEST_F(Columns, AddUpTheSlopesAroundFewNewOnesAsAroundMany) {
  for (const int vertex : {2, columns_ + 5, 2 * columns_ + 1}) {
    ASSERT_LT(vertex, int(x_.size()));
    x_[std::size_t(vertex)] += Vec3{0.03, -0.02, 0.01};
    renew();
    const auto few = std::count(renewed_.begin(), renewed_.end(), Renewed::slopes);
    ASSERT_GT(few, 0);
    ASSERT_LT(few, int(renewed_.size()));
    const std::vector<Slope> own = beside_;
    std::fill(renewed_.begin(), renewed_.end(), Renewed::slopes);
    for (int i = 0; i < columns_; ++i) gather_links(columns(), rows_, i, OneLane{});
    for (std::size_t k = 0; k < own.size(); ++k)
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) ASSERT_EQ(own[k](r, c), beside_[k](r, c));
  }
}

// Fibres that become taut stiffen at a strain that is otherwise too small for new slopes.
TEST_F(Columns, TakeTheSlopesAgainWhereFibersBecomeTaut) {
  x_ = wall_.vertices;
  renew();
  const double since = 8e-3;
  ASSERT_LT(since, oldest_slopes(1).strain);
  for (Vec3& p : x_) p = (1.0 + since) * p;
  renew();
  EXPECT_GT(std::count(renewed_.begin(), renewed_.end(), Renewed::slopes), 0);
  EXPECT_LT(error(), kOfSlopes);
}

// A column that moves tells its patches: their volumes stay those of the tangents.
TEST_F(Columns, KeepThePatchesVolumes) {
  const SolidView<double> view = model_.view(x_.data());
  const int column = 9;
  std::vector<Vec3> move;
  for (int l = 0; l < levels_; ++l) move.push_back({1e-5 * l, -2e-5, 1e-5});
  for (int l = 0; l < levels_; ++l)
    x_[std::size_t(l * columns_ + column)] += 0.5 * move[std::size_t(l)];
  move_patches(view, columns(), rows_, column, 0.5, move.data(), OneLane{});
  const std::vector<double> told = patch_volume_;
  for (int w = 0; w < model_.wedge_count(); ++w) renew_wedge(view, rows_, oldest_slopes(1), w);
  for (int p = 0; p < model_.patch_count(); ++p) {
    renew_patch(view, rows_, p);
    EXPECT_NEAR(told[std::size_t(p)], patch_volume_[std::size_t(p)], 1e-14);
  }
}

// Against a dense factorisation of the blocks that it eliminates.
TEST_F(Columns, StepSolvesTheColumnsOwnBlock) {
  const int column = 12, n = 3 * levels_;
  const double hold = 200.0;
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(n, n);
  const auto set = [&](int l, int m, const Mat3& block) {
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) h(3 * l + a, 3 * m + b) += block(a, b);
  };
  Mat3 contact;
  for (int a = 0; a < 3; ++a) contact(a, a) = 300.0 + 100.0 * a;
  set(0, 0, contact);
  for (int l = 0; l < levels_; ++l) {
    const auto row = std::size_t(column * levels_ + l);
    set(l, l, pivot_[row] + hold * Mat3::identity());
    if (l + 1 == levels_) break;
    set(l, l + 1, upper_[row]);
    set(l + 1, l, transpose(upper_[row]));
  }
  eliminate(columns(), rows_, column, [&](int) { return hold; });
  std::vector<Vec3> g, move(std::size_t(levels_), Vec3{});
  Eigen::VectorXd right(n);
  for (int l = 0; l < levels_; ++l) {
    g.push_back({1.0 + l, -2.0, 0.5 * l});
    for (int a = 0; a < 3; ++a) right[3 * l + a] = -g.back()[a];
  }
  solve_column(columns(), rows_, column, contact, g.data(), move.data());
  const Eigen::VectorXd exact = h.ldlt().solve(right);
  for (int l = 0; l < levels_; ++l)
    for (int a = 0; a < 3; ++a)
      EXPECT_NEAR(move[std::size_t(l)][a], exact[3 * l + a], 1e-9 * exact.norm());
}

// A column sent through its own outside, from the wall as it is and pressed to 0.72 of its height.
TEST_F(Columns, AreNotMovedThroughAnyPoint) {
  const int column = 12;
  const auto place = [&](int l) -> Vec3& { return x_[std::size_t(l * columns_ + column)]; };
  const auto least = [&] {
    const SolidView<double> view = model_.view(x_.data());
    double out = 10.0;
    for (int n = lists_.wedge_begin[column]; n < lists_.wedge_begin[column + 1]; ++n) {
      const int w = lists_.wedges[std::size_t(n)].wedge;
      Vec3 x[6];
      view.gather(w, x);
      double at[kWedgePoints];
      point_dilatations(view.wedge(w).points, x, at);
      for (const double j : at) out = std::min(out, j);
    }
    return out;
  };
  for (const double height : {1.0, 0.72}) {
    for (int l = 0; l < levels_; ++l)
      for (int i = 0; i < columns_; ++i) {
        const Vec3 in = wall_.vertices[std::size_t(i)];
        x_[std::size_t(l * columns_ + i)] =
            in + height * (wall_.vertices[std::size_t(l * columns_ + i)] - in);
      }
    renew();
    const double before = least();
    ASSERT_GT(before, 0.5);
    std::vector<Vec3> move(std::size_t(levels_), Vec3{});
    move[0] = 3.0 * (place(levels_ - 1) - place(0));
    const SolidView<double> view = model_.view(x_.data());
    const double share = borne_share(view, columns(), rows_, column, move.data(), 1.0);
    EXPECT_GT(share, 0.0);
    const Vec3 start = place(0);
    place(0) = start + move[0];
    EXPECT_LT(least(), 0.0);
    place(0) = start + share * move[0];
    EXPECT_GE(least(), kKeptInMove * before);
    EXPECT_LE(least(), before);
    // Newton's step from a point that is far too stiff: it is not refused, but begun.
    for (Vec3& m : move) m = 1e3 * m;
    EXPECT_GT(borne_share(view, columns(), rows_, column, move.data(), 1.0), 0.0);
    for (Vec3& m : move) m = 1e-3 * m;
    // A small move is taken whole.
    EXPECT_EQ(borne_share(view, columns(), rows_, column, move.data(), 1e-4), 1e-4);
  }
}

// A column drawn along the tube: its fibres stiffen long before its points lose their volumes.
TEST_F(Columns, AreNotStiffenedBeyondAMove) {
  const int column = 12;
  const auto most = [&](double& least_volume) {
    const SolidView<double> view = model_.view(x_.data());
    double out = 0.0;
    least_volume = 10.0;
    for (int n = lists_.wedge_begin[column]; n < lists_.wedge_begin[column + 1]; ++n) {
      const SolidWedge<double> wedge = view.wedge(lists_.wedges[std::size_t(n)].wedge);
      Vec3 x[6];
      view.gather(lists_.wedges[std::size_t(n)].wedge, x);
      for (int q = 0; q < kWedgePoints; ++q) {
        const Mat3 f = solid::deformation(wedge.points[q], x);
        least_volume = std::min(least_volume, determinant(f));
        out = std::max(out, greatest_exponent(wedge.law, wedge.fiber, f));
      }
    }
    return out;
  };
  const std::vector<Vec3> move(std::size_t(levels_), Vec3{0.0, 0.0, 0.3});
  double volume = 0.0;
  const double before = most(volume);
  ASSERT_LT(before, 1.0);
  const double share =
      borne_share(model_.view(x_.data()), columns(), rows_, column, move.data(), 1.0);
  const std::vector<Vec3> start = x_;
  const auto go = [&](double by) {
    for (int l = 0; l < levels_; ++l)
      x_[std::size_t(l * columns_ + column)] =
          start[std::size_t(l * columns_ + column)] + by * move[std::size_t(l)];
  };
  go(share);
  EXPECT_GT(share, 0.0);
  EXPECT_LE(most(volume), before + kStiffenedInMove);
  go(2.0 * share);  // the halving before: volumes would bear it
  EXPECT_GT(most(volume), before + kStiffenedInMove);
  EXPECT_GT(volume, kKeptInMove);
}

}  // namespace
}  // namespace angio::simulation::detail
