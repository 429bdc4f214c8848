#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "testing/meshing/placed_balloon.hpp"

/// Random stenosed vessels and balloons for them.
namespace angio::meshing {

struct Draw {
  std::mt19937 random;

  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  int one_of(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random); }
};

// A straight stenosed tube, an arc, or a fork of two to four branches, with a lesion's place.
struct Site {
  test::Vessel vessel;
  double abscissa, lesion_length, reference_diameter;
};
inline Site random_site(Draw& draw) {
  const double radius = draw.between(1.0, 2.2);
  switch (draw.one_of(3)) {
    case 0: {
      const double half = draw.between(2.0, 6.0);
      return {
          test::make_tube(36.0, 0.3, test::stenosis(radius, 18.0, half, draw.between(0.2, 0.75))),
          18.0, 2.0 * half, 2.0 * radius};
    }
    case 1: {
      const double bend = draw.between(8.0, 25.0), angle = 34.0 / bend;
      return {test::make_arc(radius, bend, std::min(angle, 3.0), 0.3),
              0.5 * bend * std::min(angle, 3.0), 4.0, 2.0 * radius};
    }
    default:
      return {test::make_branching(2 + draw.one_of(3), radius, 0.75 * radius, 18.0, 16.0,
                                   draw.between(0.4, 0.8), 0.3),
              draw.between(12.0, 22.0), 4.0, 2.0 * radius};
  }
}

/// The same vessel, all lengths times `factor`.
inline Site scaled(Site site, double factor) {
  site.abscissa *= factor;
  site.lesion_length *= factor;
  site.reference_diameter *= factor;
  Volume<float>& level_set = site.vessel.level_set;
  level_set.geometry.spacing *= factor;
  level_set.geometry.origin *= factor;
  for (float& value : level_set.values) value *= float(factor);
  for (CenterlinePath& path : site.vessel.tree.paths) {
    for (Vec3& p : path.points) p *= factor;
    for (double& s : path.abscissa) s *= factor;
    for (double& r : path.inscribed_radius) r *= factor;
    for (double& r : path.equivalent_radius) r *= factor;
    for (double& a : path.section_area) a *= factor * factor;
  }
  return site;
}

/// A healthy diameter from 0.6 to 25 mm, as likely to lie from 1 to 2 as from 10 to 20.
inline double random_diameter(Draw& draw) {
  return 0.6 * std::pow(25.0 / 0.6, draw.between(0.0, 1.0));
}

/// The balloon that the program would choose for a vessel of any size: its own length and profile.
inline BalloonOptions fitting_balloon(const Site& site) {
  BalloonOptions options;
  options.nominal_diameter_mm = std::max(0.5, site.reference_diameter);
  return options;
}

inline BalloonOptions random_balloon(Draw& draw) {
  BalloonOptions options;
  options.ring_count = 16 + draw.one_of(30);
  options.ring_vertex_count = 12 + draw.one_of(16);
  options.length_mm = draw.between(6.0, 12.0);
  options.start_diameter_mm = draw.between(0.5, 1.0);
  if (draw.one_of(5) == 0) options.folds = draw.one_of(2) == 0 ? 2 : 3;
  return options;
}

}  // namespace angio::meshing
