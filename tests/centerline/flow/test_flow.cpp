#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "../straight_lines.hpp"
#include "centerline/flow/branch_losses.hpp"
#include "centerline/flow/flow.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace angio::centerline {
namespace {

using units::kPi;
constexpr double kPascalPerMmhg = 133.322387415;
constexpr double kMlPerMin = 1000.0 / 60.0;  // [mm^3/s]

/// A branch whose healthy radius is the greatest there is.
FlowBranch branch_of(std::vector<double> abscissa, std::vector<double> radius, int parent = -1) {
  FlowBranch branch{parent, std::move(abscissa), std::move(radius), {}};
  branch.healthy.assign(branch.radius.size(),
                        *std::max_element(branch.radius.begin(), branch.radius.end()));
  return branch;
}

FlowTree tree_of(std::vector<FlowBranch> branches) { return {std::move(branches), {}}; }

/// A vessel of 3 mm that is narrower over 10 mm, with sharp edges.
FlowTree plug(double diameter_mm) {
  const double r = 0.5 * diameter_mm;
  return tree_of({branch_of({0, 0, 10, 10}, {1.5, r, r, 1.5})});
}

/// A fork whose daughters have throats; widths and lengths are not round.
FlowTree fork() {
  return tree_of({branch_of({0, 7, 11}, {2.1, 1.9, 1.85}),
                  branch_of({11, 15, 17, 19, 30}, {1.6, 1.5, 0.6, 1.45, 1.4}, 0),
                  branch_of({11, 18, 25, 29}, {1.2, 0.7, 1.1, 1.0}, 0)});
}

double last(const FlowSolution& solution, std::size_t branch) {
  return solution.pressure_mmhg[branch].back();
}

TEST(FlowOptions, DefaultsAreValid) { EXPECT_NO_THROW(FlowOptions().validate()); }

TEST(FlowOptions, NameWhatIsOutOfRange) {
  FlowOptions options;
  options.venous_pressure_mmhg = 31.0;
  EXPECT_THROW(options.validate(), OptionError);
  options = {};
  options.diameter_error_mm = std::nan("");
  EXPECT_THROW(options.validate(), OptionError);
}

TEST(Flow, OfATubeIsPoiseuilles) {
  FlowOptions options;
  options.inlet_flow_ml_min = 150.0;
  const FlowTree tube = tree_of({branch_of({0, 20, 80}, {1.1, 1.1, 1.1})});
  const FlowSolution found = solve_flow(tube, options, 0.0).best;
  const double resistance = 8.0 * 3.5e-3 * 80.0 / (kPi * std::pow(1.1, 4));
  const double behind = 88.0 * kPascalPerMmhg / (150.0 * kMlPerMin);
  const double flow = 88.0 * kPascalPerMmhg / (resistance + behind);
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.flow_ml_min[0], flow / kMlPerMin, 1e-9 * found.flow_ml_min[0]);
  EXPECT_NEAR(last(found, 0), 93.0 - resistance * flow / kPascalPerMmhg, 1e-9);
  EXPECT_NEAR(found.pressure_mmhg[0][1], 93.0 - 0.25 * (93.0 - last(found, 0)), 1e-9);
}

// The table's cells have three figures or one decimal: half of the last digit is theirs.
TEST(Flow, OfAPlugIsThePublishedQuadraticsRoot) {
  struct Row {
    double diameter, flow, drop, ffr;
  };
  // A quadratic by hand: Kt 1.52, mu 3.5 mPa s, rho 1060, Pa 93, Pv 5 mmHg, 180 mL/min.
  const Row rows[] = {{0.6, 34.7, 71.0, 0.236},  {0.9, 83.9, 47.0, 0.495},
                      {1.2, 127.1, 25.9, 0.722}, {1.5, 154.2, 12.6, 0.864},
                      {1.8, 168.0, 5.9, 0.937},  {2.0, 172.9, 3.5, 0.962},
                      {2.4, 177.4, 1.3, 0.986}};
  FlowOptions options;
  options.inlet_flow_ml_min = 180.0;
  for (const Row& row : rows) {
    const FlowSolution found = solve_flow(plug(row.diameter), options, 0.0).best;
    EXPECT_NEAR(found.flow_ml_min[0], row.flow, 0.01 * row.flow) << row.diameter;
    EXPECT_NEAR(93.0 - last(found, 0), row.drop, 0.01 * row.drop + 0.05) << row.diameter;
    EXPECT_NEAR(last(found, 0) / 93.0, row.ffr, 0.01 * row.ffr) << row.diameter;
  }
}

TEST(Flow, LosesAtASharpWideningWhatBordaAndCarnotSay) {
  FlowOptions options;
  options.expansion_coefficient = 1.0;
  options.inlet_flow_ml_min = 200.0;
  const FlowTree step = tree_of({branch_of({0, 0, 0}, {1.0, 1.0, 2.0})});
  const FlowSolution found = solve_flow(step, options, 0.0).best;
  const double flow = found.flow_ml_min[0] * kMlPerMin;
  const double jet = flow / kPi * (1.0 - 0.25);
  EXPECT_NEAR((93.0 - last(found, 0)) * kPascalPerMmhg, 0.5 * 1.06e-3 * jet * jet, 1e-9);
}

TEST(Flow, IsKeptAtForksAndSplitByMurray) {
  FlowOptions options;
  options.inlet_flow_ml_min = 240.0;
  const FlowSolution found = solve_flow(fork(), options, 0.0).best;
  EXPECT_NEAR(found.flow_ml_min[0], found.flow_ml_min[1] + found.flow_ml_min[2],
              1e-9 * found.flow_ml_min[0]);
  EXPECT_EQ(found.pressure_mmhg[0].back(), found.pressure_mmhg[1].front());
  // Vessels so wide that they take no pressure: the shares are the small vessels' alone.
  FlowTree wide = tree_of({branch_of({0, 1}, {20, 20}), branch_of({1, 2}, {16, 16}, 0),
                           branch_of({1, 2}, {10, 10}, 0)});
  wide.branches[1].healthy = {16, 9};  // it is the mouth's that counts
  const FlowSolution split = solve_flow(wide, options, 0.0).best;
  EXPECT_NEAR(split.flow_ml_min[0], 240.0, 0.01);
  EXPECT_NEAR(split.flow_ml_min[1] / split.flow_ml_min[2], std::pow(1.6, 3), 1e-4);
}

/// What each branch and each outlet's bed takes, by hand.
TEST(Flow, ObeysTheLawOfEveryBranch) {
  FlowOptions options;
  options.inlet_flow_ml_min = 240.0;
  const FlowTree tree = fork();
  const FlowSolution found = solve_flow(tree, options, 0.0).best;
  ASSERT_TRUE(found.converged);
  for (std::size_t b = 0; b < 3; ++b) {
    const BranchLosses losses = branch_losses(tree.branches[b].abscissa, tree.branches[b].radius,
                                              b == 0 ? tree.branches[0].healthy.back() : 0.0);
    const double flow = found.flow_ml_min[b] * kMlPerMin;
    const double drop = 3.5e-3 * losses.friction.back() * flow +
                        1.52 * 0.53e-3 * losses.expansion.back() * flow * flow;
    EXPECT_NEAR((found.pressure_mmhg[b].front() - last(found, b)) * kPascalPerMmhg, drop,
                1e-9 * drop);
  }
  const double shares[] = {std::pow(1.6, 3), std::pow(1.2, 3)};
  for (std::size_t d = 0; d < 2; ++d) {
    const double behind = 88.0 / (240.0 * shares[d] / (shares[0] + shares[1]));  // [mmHg min/mL]
    EXPECT_NEAR((last(found, d + 1) - 5.0) / found.flow_ml_min[d + 1], behind, 1e-9 * behind);
  }
}

TEST(Flow, PressureNeverRisesAlongTheVessel) {
  for (const auto& pressure : solve_flow(fork(), {}, 0.0).best.pressure_mmhg)
    for (std::size_t i = 1; i < pressure.size(); ++i) EXPECT_LE(pressure[i], pressure[i - 1]);
}

TEST(Flow, DoesNotDependOnTheSampling) {
  // Radii are linear between points, so points between them change nothing.
  FlowTree fine = fork();
  for (FlowBranch& branch : fine.branches) {
    FlowBranch cut{branch.parent, {}, {}, {}};
    for (std::size_t i = 0; i + 1 < branch.abscissa.size(); ++i)
      for (int k = 0; k < 10; ++k) {
        const double t = 0.1 * k;
        const auto between = [&](const std::vector<double>& v) {
          return (1.0 - t) * v[i] + t * v[i + 1];
        };
        cut.abscissa.push_back(between(branch.abscissa));
        cut.radius.push_back(between(branch.radius));
        cut.healthy.push_back(between(branch.healthy));
      }
    cut.abscissa.push_back(branch.abscissa.back());
    cut.radius.push_back(branch.radius.back());
    cut.healthy.push_back(branch.healthy.back());
    branch = cut;
  }
  const FlowSolution a = solve_flow(fork(), {}, 0.0).best, b = solve_flow(fine, {}, 0.0).best;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(last(a, i), last(b, i), 1e-8);
    EXPECT_NEAR(a.flow_ml_min[i], b.flow_ml_min[i], 1e-8);
  }
}

TEST(Flow, OfASmoothThroatComesToALimitOfSecondOrder) {
  const auto drop = [](int cells) {
    std::vector<double> s, r;
    for (int i = 0; i <= cells; ++i) {
      s.push_back(12.0 * i / cells);
      r.push_back(1.5 - 0.45 * (1.0 - std::cos(2.0 * kPi * i / cells)));
    }
    return 93.0 - last(solve_flow(tree_of({branch_of(s, r)}), {}, 0.0).best, 0);
  };
  const double limit = drop(4096);
  EXPECT_NEAR(drop(64), limit, 0.005 * limit);
  EXPECT_NEAR((drop(32) - limit) / (drop(64) - limit), 4.0, 0.5);
}

// Lengths twice as long, flows four times, Reynolds' number kept: pressure over rho v^2 is, too.
TEST(Flow, ScalesAsTheEquationsDo) {
  FlowTree large = fork();
  for (FlowBranch& branch : large.branches)
    for (auto* lengths : {&branch.abscissa, &branch.radius, &branch.healthy})
      for (double& x : *lengths) x *= 2.0;
  FlowOptions options, other;
  options.inlet_flow_ml_min = 240.0;
  other.inlet_flow_ml_min = 960.0;  // the velocity stays
  other.viscosity_mpa_s = 2.0 * options.viscosity_mpa_s;
  const FlowSolution a = solve_flow(fork(), options, 0.0).best,
                     b = solve_flow(large, other, 0.0).best;
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(last(a, i), last(b, i), 1e-9);
}

TEST(Flow, DoesNotDependOnTheOrderOfDaughters) {
  FlowTree turned = fork();
  std::swap(turned.branches[1], turned.branches[2]);
  const FlowSolution a = solve_flow(fork(), {}, 0.0).best, b = solve_flow(turned, {}, 0.0).best;
  EXPECT_NEAR(last(a, 1), last(b, 2), 1e-12);
  EXPECT_NEAR(last(a, 2), last(b, 1), 1e-12);
}

TEST(Flow, WiderThroatsNeverLowerThePressure) {
  double before = 0.0;
  for (double diameter = 0.2; diameter < 3.0; diameter += 0.1) {
    const double now = last(solve_flow(plug(diameter), {}, 0.0).best, 0);
    EXPECT_GT(now, before);
    before = now;
  }
  EXPECT_LT(before, 93.0);
}

TEST(Flow, ATreatmentDoesNotChangeTheSmallVessels) {
  const auto behind = [](double diameter) {
    const FlowSolution found = solve_flow(plug(diameter), {}, 0.0).best;
    return (last(found, 0) - 5.0) / found.flow_ml_min[0];
  };
  EXPECT_NEAR(behind(0.8), behind(2.4), 1e-9 * behind(2.4));
}

TEST(Flow, ConvergesInTheTightestAndTheWidestVessels) {
  for (const double r : {1e-3, 0.05, 30.0}) {
    FlowTree tree = fork();
    tree.branches[1].radius[2] = r;
    const FlowResult found = solve_flow(tree, {}, 0.1);
    EXPECT_TRUE(found.best.converged) << r;
    for (const auto& varied : found.varied) EXPECT_TRUE(varied.converged) << r;
    for (const double q : found.best.flow_ml_min) EXPECT_GT(q, 0.0) << r;
    EXPECT_GE(last(found.best, 1), 5.0) << r;
    EXPECT_LE(last(found.varied[0], 1), last(found.best, 1)) << r;
  }
}

TEST(BranchLosses, OfNoiseAddUpToNearlyNothing) {
  std::vector<double> s, smooth, noisy;
  for (int i = 0; i <= 400; ++i) {
    s.push_back(0.1 * i);
    smooth.push_back(1.5 - 0.9 * std::exp(-std::pow((0.1 * i - 20.0) / 3.0, 2)));
    noisy.push_back(smooth.back() * (1.0 + (i % 3 - 1) * 0.02));
  }
  const double clean = branch_losses(s, smooth, 0.0).expansion.back();
  // The throat is read at most 2 % too narrow: 4 % of its area, twice that of the loss, and some.
  EXPECT_NEAR(branch_losses(s, noisy, 0.0).expansion.back(), clean, 0.12 * clean);
}

TEST(BranchLosses, OfTwoThroatsAreBothOnes) {
  const std::vector<double> s{0, 1, 2, 3, 4};
  const double one = branch_losses({0, 1, 2}, {2, 1, 2}, 0.0).expansion.back();
  EXPECT_NEAR(branch_losses(s, {2, 1, 2, 1, 2}, 0.0).expansion.back(), 2.0 * one, 1e-12);
  // A dip of 10 % behind it is one of its own; one of 3 % within it changes nothing.
  const double dip = branch_losses({0, 1}, {1.8, 2}, 0.0).expansion.back();
  EXPECT_GT(dip, 0.0);
  EXPECT_NEAR(branch_losses(s, {2, 1, 2, 1.8, 2}, 0.0).expansion.back(), one + dip, 1e-12);
  EXPECT_NEAR(branch_losses(s, {2, 1, 1.5, 1.45, 2}, 0.0).expansion.back(), one, 1e-12);
}

TEST(BranchLosses, AThroatAtAForkOpensIntoTheHealthyVessel) {
  const double inside = branch_losses({0, 1, 2}, {2, 1, 2}, 0.0).expansion.back();
  EXPECT_NEAR(branch_losses({0, 1}, {2, 1}, 2.0).expansion.back(), inside, 1e-12);
  EXPECT_EQ(branch_losses({0, 1}, {2, 1}, 0.0).expansion.back(), 0.0);
}

TEST(FilledRadii, AreLinearBetweenMeasuredOnesAndHealthyWithoutAny) {
  FlowBranch branch{-1, {0, 1, 2, 4, 5}, {0, 1.0, 0, 2.0, 0}, {3, 3, 3, 3, 3}};
  const std::vector<double> filled = filled_radii(branch), expected{1.0, 1.0, 4.0 / 3.0, 2.0, 2.0};
  ASSERT_EQ(filled.size(), expected.size());
  for (std::size_t i = 0; i < filled.size(); ++i) EXPECT_DOUBLE_EQ(filled[i], expected[i]);
  branch.radius.assign(5, 0.0);
  EXPECT_EQ(filled_radii(branch), branch.healthy);
}

TEST(FlowEstimate, GrowsWithBothErrorsAndIsExactWithoutThem) {
  FlowOptions options;
  const auto range = [&](double error, double percent) {
    options.diameter_error_mm = error;
    options.flow_error_percent = percent;
    return estimate(solve_flow(plug(1.2), options, 9.0),
                    [](const FlowSolution& s) { return last(s, 0) / 93.0; });
  };
  const Estimate none = range(0.0, 0.0), radii = range(0.1, 0.0), flow = range(0.0, 25.0),
                 both = range(0.1, 25.0);
  EXPECT_EQ(none.low, none.value);
  EXPECT_EQ(none.high, none.value);
  EXPECT_LT(both.low, std::min(radii.low, flow.low));
  EXPECT_GT(both.high, std::max(radii.high, flow.high));
  EXPECT_NEAR(std::pow(both.value - both.low, 2),
              std::pow(radii.value - radii.low, 2) + std::pow(flow.value - flow.low, 2), 1e-12);
  const FlowResult wrong = solve_flow(plug(1.2), options, 0.0);
  EXPECT_LT(last(wrong.varied[0], 0), last(wrong.best, 0));  // thinner, wider
  EXPECT_GT(last(wrong.varied[1], 0), last(wrong.best, 0));
  EXPECT_GT(last(wrong.varied[2], 0), last(wrong.best, 0));  // less flow, more
  EXPECT_LT(last(wrong.varied[3], 0), last(wrong.best, 0));
  // Both are the derivative's, for small errors: here of the throat's diameter.
  const auto ffr = [](double d) { return last(solve_flow(plug(d), {}, 0.0).best, 0) / 93.0; };
  const Estimate small = range(0.002, 0.0);
  EXPECT_NEAR(small.high - small.value, 0.5 * (ffr(1.201) - ffr(1.199)) * 2.0, 2e-4);
}

TEST(Flow, RefusesWhatIsNoTree) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  EXPECT_THROW(solve_flow({}, {}, 0.0), InputError);
  EXPECT_THROW(solve_flow(plug(1.0), {}, nan), InputError);
  const auto refused = [](auto change) {
    FlowTree tree = fork();
    change(tree.branches[1]);
    EXPECT_THROW(solve_flow(tree, {}, 0.0), InputError);
  };
  for (const double bad : {nan, inf, -1.0}) {
    refused([&](FlowBranch& b) { b.radius[1] = bad; });
    refused([&](FlowBranch& b) { b.healthy[1] = bad; });
  }
  refused([](FlowBranch& b) { b.healthy[0] = 0.0; });
  refused([](FlowBranch& b) { b.abscissa[2] = 0.0; });
  refused([](FlowBranch& b) { b.radius.pop_back(); });
  refused([](FlowBranch& b) { b.parent = 1; });
  refused([](FlowBranch& b) { b.parent = -1; });
}

TEST(FlowTree, OfALineHasItsRadii) {
  const CenterlineTree tree = test::tree_of(
      {test::line_of([](double s) { return 3.0 * test::narrowed(s, 30.0, 5.0, 0.5); }, 60.0)});
  const FlowTree flow = make_flow_tree(tree, 0.0);
  ASSERT_EQ(flow.branches.size(), 1U);
  ASSERT_EQ(flow.paths[0].size(), tree.paths[0].points.size());
  for (std::size_t i = 0; i < flow.paths[0].size(); ++i) {
    const FlowPlace place = flow.paths[0][i];
    EXPECT_EQ(flow.branches[0].abscissa[place.point], tree.paths[0].abscissa[i]);
    EXPECT_NEAR(flow.branches[0].healthy[place.point], 1.5, 0.05);
    const double r = flow.branches[0].radius[place.point];
    if (r > 0.0) {
      EXPECT_NEAR(r, tree.paths[0].equivalent_radius[i], 0.02);
    }
  }
  EXPECT_THROW(make_flow_tree({}, 0.0), InputError);
}

TEST(FlowTree, TakesTheLumenOfAProfileWhereThereIsOne) {
  const CenterlineTree tree = test::tree_of({test::line_of([](double) { return 3.0; }, 60.0)});
  FlowTree before = make_flow_tree(tree, 0.0);
  const std::size_t hidden = 70;  // at 26 mm
  ASSERT_NEAR(tree.paths[0].abscissa[hidden], 26.25, 0.1);
  before.branches[0].radius[before.paths[0][hidden].point] = 0.0;
  // The last section takes in a neighbour: it counts 1.5 times its ball.
  const LumenProfile profile{{20.0, 25.0, 35.0}, {1.0, 1.0, 1.0}, {1.44 * kPi, 1.44 * kPi, 99.0}};
  const FlowTree after = with_lumen(before, tree.paths[0], 0, profile);
  for (std::size_t i = 0; i < tree.paths[0].points.size(); ++i) {
    const double s = tree.paths[0].abscissa[i];
    const auto radius = [&](const FlowTree& flow) {
      return flow.branches[0].radius[flow.paths[0][i].point];
    };
    if (s > 20.0 && s < 35.0 && i != hidden) {
      EXPECT_NEAR(radius(after), 1.2 + 0.03 * std::max(s - 25.0, 0.0), 1e-3);
    } else {
      EXPECT_EQ(radius(after), radius(before)) << s;
    }
  }
}

TEST(FlowTree, OfAForkSharesItsPointAndCoversEveryLine) {
  const auto bent = [](int id, double sign) {
    CenterlinePath path;
    path.id = id;
    for (int i = 0; i <= 240; ++i) {
      const double s = 0.25 * i, x = std::max(s - 30.0, 0.0);
      path.points.push_back({sign * 0.6 * x, 0.0, s});
      path.inscribed_radius.push_back(s <= 30.0 ? 1.5 : 1.2);
    }
    return path;
  };
  const CenterlineTree tree = test::tree_of({bent(0, 1.0), bent(1, -1.0)});
  const FlowTree flow = make_flow_tree(tree, 0.0);
  ASSERT_EQ(flow.branches.size(), 3U);
  for (std::size_t b : {1U, 2U}) {
    EXPECT_EQ(flow.branches[b].parent, 0);
    EXPECT_EQ(flow.branches[b].abscissa.front(), flow.branches[0].abscissa.back());
  }
  for (std::size_t p = 0; p < 2; ++p)
    for (std::size_t i = 0; i < tree.paths[p].points.size(); ++i) {
      const FlowPlace place = flow.paths[p][i];
      EXPECT_EQ(flow.branches[place.branch].abscissa[place.point], tree.paths[p].abscissa[i]);
    }
  const FlowSolution found = solve_flow(flow, {}, 0.0).best;
  EXPECT_NEAR(found.flow_ml_min[1], found.flow_ml_min[2], 0.02 * found.flow_ml_min[1]);
}

}  // namespace
}  // namespace angio::centerline
