#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "centerline/centerline.hpp"
#include "centerline/detail/healthy_line.hpp"
#include "centerline/detail/reference.hpp"
#include "core/units.hpp"
#include "tests/centerline/straight_lines.hpp"

namespace angio::centerline {
namespace {

using test::line_of;
using test::narrowed;
using test::tree_of;

TEST(LesionReferences, ALargeAneurysmIsNoHealthyWidth) {
  // 3.5 mm wide, then 13 mm over 45 mm, then 3.2 mm: a vessel of 3.5 mm with an aneurysm.
  const auto diameter = [](double s) {
    const double x = (s - 50.0) / 25.0;
    const double bulge = std::abs(x) < 1.0 ? std::min(1.0, 4.0 * (1.0 - std::abs(x))) : 0.0;
    return (s < 50.0 ? 3.5 : 3.2) + 9.5 * bulge;
  };
  for (const double end : {100.0, 120.0})
    for (const Lesion& lesion : find_lesions(tree_of({line_of(diameter, end)}), {}))
      EXPECT_FALSE(lesion.is_stenosis) << lesion.abscissa_mm << " of " << end;
}

TEST(LesionReferences, BesideALargeAneurysmAStenosisIsReadAgainstItsOwnVessel) {
  const auto diameter = [](double s) {
    const double x = (s - 40.0) / 20.0;
    const double bulge = std::abs(x) < 1.0 ? std::min(1.0, 4.0 * (1.0 - std::abs(x))) : 0.0;
    return (3.5 + 9.0 * bulge) * narrowed(s, 80.0, 6.0, 0.7);
  };
  const auto lesions = find_lesions(tree_of({line_of(diameter, 120.0)}), {});
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_TRUE(lesions[0].is_stenosis);
  EXPECT_NEAR(lesions[0].abscissa_mm, 80.0, 0.5);
  EXPECT_NEAR(lesions[0].reference_diameter_mm, 3.5, 0.1);
  EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 70.0, 2.0);
}

TEST(LesionReferences, ABallThatFitsProvesThatTheLumenIsNoNarrower) {
  // A fitted section that errs: its tube is half as wide as the ball that lies in the lumen.
  CenterlinePath path = line_of([](double) { return 4.0; }, 60.0);
  path.tube_radius = path.inscribed_radius;
  for (std::size_t i = 0; i < path.points.size(); ++i)
    if (std::abs(path.points[i].z - 30.0) < 4.0) path.tube_radius[i] *= 0.5;
  EXPECT_FALSE(find_lesions(tree_of({path}), {}).at(0).is_stenosis);
  for (std::size_t i = 0; i < path.points.size(); ++i)
    path.inscribed_radius[i] = path.tube_radius[i];
  EXPECT_TRUE(find_lesions(tree_of({path}), {}).at(0).is_stenosis);
}

TEST(LesionReferences, BesideALesionTheVesselIsAsWideAsItsReferenceButWhereItIsDilated) {
  for (const double widened : {1.0, 1.5}) {  // over 5 mm, 10 mm before and behind the throat
    const auto diameter = [&](double s) {
      const double wide = 1.0 - narrowed(std::abs(s - 60.0), 10.0, 5.0, 1.0);
      return 4.0 * (1.0 + (widened - 1.0) * wide) * narrowed(s, 60.0, 4.0, 0.6);
    };
    const auto lesions = find_lesions(tree_of({line_of(diameter, 120.0)}), {});
    ASSERT_TRUE(lesions.at(0).is_stenosis);
    EXPECT_NEAR(lesions[0].reference_diameter_mm, 4.0, 0.15);
    EXPECT_NEAR(lesions[0].widest_beside_mm, 4.0 * widened, 0.2);  // a tenth of it is wider
  }
}

TEST(LesionReferences, AThroatChangesNothingThatIsToldOfTheVesselBeyondIt) {
  // 3.2 mm wide, behind 92 mm 1.9 mm, and waving; with a throat and without.
  struct Wave {
    double share, length_mm, throat_mm;
  };
  for (const Wave& wave : {Wave{0.14, 44.0, 100.0}, Wave{0.08, 25.0, 50.0}}) {
    const auto reference_at = [&](double depth, double s) {
      const auto diameter = [&](double x) {
        const double step = std::clamp((x - 88.0) / 8.0, 0.0, 1.0);
        return (3.2 - 1.3 * step) *
               (1.0 + wave.share * std::sin(2.0 * units::kPi * x / wave.length_mm)) *
               narrowed(x, wave.throat_mm, 5.0, depth);
      };
      const CenterlineTree tree = tree_of({line_of(diameter, 170.0)});
      const std::vector<double>& abscissa = tree.paths[0].abscissa;
      const auto at = std::lower_bound(abscissa.begin(), abscissa.end(), s) - abscissa.begin();
      return find_reference(tree, 0.0).paths[0].diameter[std::size_t(at)];
    };
    for (double s = 20.0; s < 160.0; s += 10.0)
      if (std::abs(s - wave.throat_mm) > 12.0) {
        EXPECT_NEAR(reference_at(0.7, s) / reference_at(0.0, s), 1.0, 0.06) << s;
      }
  }
}

TEST(LesionReferences, AVesselThatWavesSlowlyIsHealthyOnBothOfItsSides) {
  // 3 mm and thinner by 0.3 % a mm, 15 % wider and narrower in turn: no stenosis but the one of
  // 60 % that is there, and its reference is not the crest of the waves.
  for (const double wave_mm : {20.0, 26.0, 32.0})
    for (const double phase : {0.0, 1.5, 3.0, 4.5}) {
      const auto healthy = [&](double s) {
        return 3.0 * std::exp(-0.003 * s) *
               (1.0 + 0.15 * std::sin(2.0 * units::kPi * s / wave_mm + phase));
      };
      const auto diameter = [&](double s) { return healthy(s) * narrowed(s, 60.0, 4.0, 0.6); };
      for (const Lesion& lesion : find_lesions(tree_of({line_of(diameter, 150.0)}), {})) {
        if (!lesion.is_stenosis) continue;
        EXPECT_NEAR(lesion.abscissa_mm, 60.0, 1.0) << wave_mm << " mm, " << phase;
        EXPECT_NEAR(lesion.reference_tree_mm / (3.0 * std::exp(-0.18)), 1.0, 0.12)
            << wave_mm << " mm, " << phase;
      }
    }
}

TEST(LesionReferences, HalfOfTheWidthBesideAThroatIsToldOfThoughTheTreeIsNarrower) {
  // 4 mm wide; dilated to 5.8 mm over 22 mm, in the middle of which a throat of 2.8 mm lies.
  const auto with_throat = [](double mld) {
    return [mld](double s) {
      const double wide = std::clamp((13.0 - std::abs(s - 60.0)) / 2.0, 0.0, 1.0);
      return (4.0 + 1.8 * wide) * narrowed(s, 60.0, 4.0, 1.0 - mld / 5.8);
    };
  };
  const auto lesions = find_lesions(tree_of({line_of(with_throat(2.8), 120.0)}), {});
  const auto told = std::find_if(lesions.begin(), lesions.end(), [](const Lesion& lesion) {
    return lesion.doubt == Doubt::wide_sides;
  });
  ASSERT_NE(told, lesions.end());
  EXPECT_FALSE(told->is_stenosis);
  EXPECT_NEAR(told->abscissa_mm, 60.0, 0.5);
  EXPECT_NEAR(told->percent_of_sides(), 100.0 * (1.0 - 2.8 / 5.8), 3.0);
  EXPECT_NEAR(told->beside_throat_mm, 5.8, 0.1);
  for (const Lesion& lesion : find_lesions(tree_of({line_of(with_throat(3.4), 120.0)}), {}))
    EXPECT_NE(lesion.doubt, Doubt::wide_sides);
}

TEST(LesionReferences, AThroatInAThinStretchSaysHowWideItsSidesAreButNotAtTheBranchsEnd) {
  // 4 mm wide, 2.4 mm over 24 mm, with a throat in its middle.
  const auto diameter = [](double s) {
    const double thin = std::clamp((14.0 - std::abs(s - 60.0)) / 2.0, 0.0, 1.0);
    return (4.0 - 1.6 * thin) * narrowed(s, 60.0, 3.0, 0.5);
  };
  const Lesion lesion = find_lesions(tree_of({line_of(diameter, 120.0)}), {}).at(0);
  ASSERT_TRUE(lesion.is_stenosis);
  EXPECT_NEAR(lesion.reference_diameter_mm, 4.0, 0.1);
  EXPECT_NEAR(lesion.beside_throat_mm, 2.4, 0.05);
  EXPECT_TRUE(lesion.is_in_thin_vessel());
  // Without the throat, too: the stretch is no narrower than itself.
  const auto thin = [](double s) {
    return 4.0 - 1.6 * std::clamp((14.0 - std::abs(s - 60.0)) / 2.0, 0.0, 1.0);
  };
  const Lesion stretch = find_lesions(tree_of({line_of(thin, 120.0)}), {}).at(0);
  ASSERT_TRUE(stretch.is_stenosis);
  EXPECT_TRUE(stretch.is_in_thin_vessel());
  const auto throat = [](double s) { return 4.0 * narrowed(s, 60.0, 3.0, 0.5); };
  EXPECT_FALSE(find_lesions(tree_of({line_of(throat, 120.0)}), {}).at(0).is_in_thin_vessel());
  const auto near_end = [](double s) { return 4.0 * narrowed(s, 5.5, 3.0, 0.6); };
  for (const Lesion& at_end : find_lesions(tree_of({line_of(near_end, 80.0)}), {}))
    EXPECT_EQ(at_end.beside_throat_mm, 0.0);
}

TEST(LesionReferences, OfWhatIsMeasuredNowhereIsTheLumensOwnWidth) {
  CenterlinePath path = line_of([](double s) { return 2.5 + 0.1 * s; }, 4.0);
  path.tracts = {{0, int(path.points.size()) - 1, 0, 0, true}};
  const ReferenceDiameter reference = find_reference(tree_of({path}), 0.0).paths[0];
  for (const double diameter : reference.diameter) EXPECT_NEAR(diameter, 2.7, 0.05);
}

/// The cells of a branch of given diameters, a quarter of a diameter long each.
FieldBranch cells_of(const std::function<double(double)>& diameter, double length) {
  FieldBranch branch;
  double position = 0.0;
  for (double s = 0.0; s < length; s += 0.25 * diameter(s)) {
    branch.cells.push_back({.log_diameter = std::log(diameter(s)),
                            .weight = 0.25,
                            .position = position,
                            .length_mm = 0.25 * diameter(s),
                            .abscissa_mm = s});
    position += 0.25;
  }
  branch.length = position;
  return branch;
}

/// Diameters [mm] of a branch whose healthy width is said to be 11 mm, by accept_narrower_vessel.
std::vector<double> accepted(const FieldBranch& branch) {
  std::vector<double> line(branch.cells.size(), std::log(11.0));
  line = accept_narrower_vessel(branch, line);
  for (double& value : line) value = std::exp(value);
  return line;
}

TEST(LesionReferences, AVesselThatStaysNarrowerBehindAThroatHasThatWidth) {
  // A coarctation: 11 mm, a throat at 50 mm, behind it 7 to 6.3 mm, which waver.
  const auto diameter = [](double s) {
    const double behind = (7.0 - 0.01 * (s - 60.0)) * (1.0 + 0.03 * std::sin(s / 7.0));
    return (s < 50.0 ? 11.0 : behind) * narrowed(s, 50.0, 15.0, 0.7);
  };
  const FieldBranch branch = cells_of(diameter, 130.0);
  const std::vector<double> healthy = accepted(branch);
  for (std::size_t c = 0; c < healthy.size(); ++c) {
    const double s = branch.cells[c].abscissa_mm;
    if (s < 30.0) {
      EXPECT_NEAR(healthy[c], 11.0, 0.2) << s;
    } else if (s > 68.0) {
      EXPECT_NEAR(healthy[c] / diameter(s), 1.0, 0.06) << s;
    } else {  // between both
      EXPECT_GT(healthy[c], 6.5) << s;
      EXPECT_LT(healthy[c], 11.1) << s;
    }
  }
}

TEST(LesionReferences, ADilatationBehindAThroatDoesNotTellTheWidthOfALongVessel) {
  // 11 mm, a throat, 8.5 mm (or 6 mm) that come to 7 mm within 35 mm, and 7 mm for long.
  for (const double behind : {8.5, 6.0})
    for (const double length : {150.0, 200.0, 300.0}) {
      SCOPED_TRACE(testing::Message() << behind << " mm, " << length << " mm long");
      const auto diameter = [&](double s) {
        const double even = behind + (7.0 - behind) * std::clamp((s - 60.0) / 35.0, 0.0, 1.0);
        return (s < 50.0 ? 11.0 : even) * narrowed(s, 50.0, 15.0, 0.7);
      };
      const FieldBranch branch = cells_of(diameter, length);
      const std::vector<double> healthy = accepted(branch);
      for (std::size_t c = 0; c < healthy.size(); ++c) {
        const double s = branch.cells[c].abscissa_mm;
        if (s > 100.0) {
          EXPECT_NEAR(healthy[c] / 7.0, 1.0, 0.12) << s;
        }
      }
    }
}

TEST(LesionReferences, AnEvenNarrowVesselIsAcceptedOnlyBehindAThroatAndToItsEnd) {
  const auto expect_kept = [](const std::function<double(double)>& diameter) {
    for (const double healthy : accepted(cells_of(diameter, 150.0)))
      EXPECT_NEAR(healthy, 11.0, 1e-9);
  };
  expect_kept([](double s) { return s < 50.0 ? 11.0 : 7.0; });  // no throat
  expect_kept([](double s) {                                    // wide again at the end
    return (s < 50.0 || s > 130.0 ? 11.0 : 7.0) * narrowed(s, 50.0, 15.0, 0.7);
  });
  expect_kept([](double s) {  // not even
    const double uneven = 7.0 * (1.0 + 0.15 * std::sin(s / 4.0));
    return (s < 50.0 ? 11.0 : uneven) * narrowed(s, 50.0, 15.0, 0.7);
  });
}

TEST(LesionReferences, TheFlareOfAnOstiumIsNoVessel) {
  // A vessel 3.2 mm wide that leaves one of 24 mm through a funnel.
  constexpr double kOstium = 35.0;
  const auto diameter = [](double s) {
    if (s < kOstium) return 24.0;
    return std::max(3.2, 12.0 - 2.0 * (s - kOstium));
  };
  CenterlinePath trunk = line_of([](double) { return 24.0; }, 100.0);
  CenterlinePath branch = line_of(diameter, 53.0, 1);
  for (Vec3& p : branch.points)
    if (p.z > 21.0) p = {p.z - 21.0, 0.0, 21.0};
  const auto part = [](CenterlinePath& path, double begin, double end) {
    const std::vector<double> s = arc_length(path.points);
    const auto at = [&](double where) {
      return int(std::lower_bound(s.begin(), s.end(), where) - s.begin());
    };
    path.tracts = {{0, at(begin), 0, 0, false},
                   {at(begin), at(end), 1, 1, true},
                   {at(end), int(s.size()) - 1, 2 + path.id, 2, false}};
  };
  part(trunk, 20.0, 44.0);
  part(branch, 20.0, kOstium);
  const CenterlineTree tree = tree_of({trunk, branch});
  const ReferenceDiameter reference = find_reference(tree, 0.0).paths[1];
  const std::vector<double>& s = tree.paths[1].abscissa;
  for (std::size_t i = 0; i < s.size(); ++i) {
    if (s[i] < kOstium) continue;
    EXPECT_NEAR(reference.diameter[i], 3.2, 0.16) << s[i];
    EXPECT_LT(reference.measured[i], 6.4) << s[i];
  }
}

struct ShortVessel {
  double depth = 0.0;   ///< diameter stenosis
  double length = 0.0;  ///< of the narrowed stretch [mm]
  double beside = 0.0;  ///< healthy vessel on each side of it, up to the line's ends [mm]

  [[nodiscard]] double throat() const { return beside + 0.5 * length; }
  [[nodiscard]] CenterlineTree tree() const {
    const auto diameter = [&](double s) {
      return 3.0 * narrowed(s, throat(), 0.5 * length, depth);
    };
    return tree_of({line_of(diameter, length + 2.0 * beside)});
  }
  /// Whether the radii are those of balls in a lumen, which change by no more than the way between
  /// them: by up to 3 / 2 pi depth / length a mm here.
  [[nodiscard]] bool is_possible() const { return 1.5 * units::kPi * depth <= length; }
};

std::vector<ShortVessel> short_vessels() {
  std::vector<ShortVessel> vessels;
  for (const double depth : {0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9})
    for (const double length : {3.0, 4.5, 6.0, 8.0, 10.0, 12.0, 15.0})
      for (const double beside : {5.0, 7.0, 10.0}) {
        const ShortVessel vessel{depth, length, beside};
        if (vessel.is_possible()) vessels.push_back(vessel);
      }
  return vessels;
}

TEST(LesionReferences, FiveMillimetresOfHealthyVesselOnEachSideTellItsDiameter) {
  for (const ShortVessel& vessel : short_vessels()) {
    SCOPED_TRACE(testing::Message() << 100.0 * vessel.depth << " % over " << vessel.length
                                    << " mm, " << vessel.beside << " mm beside it");
    LesionOptions options;
    options.abscissa_mm = vessel.throat();
    const Lesion lesion = find_lesions(vessel.tree(), options).at(0);
    EXPECT_NEAR(lesion.reference_diameter_mm, 3.0, 0.03);
    EXPECT_NEAR(lesion.diameter_stenosis_percent, 100.0 * vessel.depth, 1.0);
    EXPECT_NEAR(lesion.reference_interpolated_mm, 3.0, 0.03);
    EXPECT_NEAR(lesion.reference_average_mm, 3.0, 0.03);
  }
}

/// A thread of a tenth of the vessel, uneven, over the last or first 5 mm.
double thread(double s) { return 0.4 * (1.0 + 0.5 * std::sin(5.0 * s)); }

TEST(LesionReferences, AVesselThatEndsInAThreadEndsThere) {
  const auto last = [](double s) { return s < 45.0 ? 4.0 : thread(s); };
  EXPECT_FALSE(find_lesions(tree_of({line_of(last, 50.0)}), {}).at(0).is_stenosis);
  const auto first = [](double s) { return s > 5.0 ? 4.0 : thread(s); };
  EXPECT_FALSE(find_lesions(tree_of({line_of(first, 50.0)}), {}).at(0).is_stenosis);
}

TEST(LesionReferences, AThreadWithVesselBehindItIsALesion) {
  const auto diameter = [](double s) { return s < 40.0 || s > 45.0 ? 4.0 : thread(s); };
  const Lesion lesion = find_lesions(tree_of({line_of(diameter, 80.0)}), {}).at(0);
  EXPECT_TRUE(lesion.is_stenosis);
  EXPECT_GT(lesion.diameter_stenosis_percent, 85.0);
}

}  // namespace
}  // namespace angio::centerline
