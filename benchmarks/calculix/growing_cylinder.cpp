#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include "benchmarks/calculix/ccx_wall.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "simulation/bodies/layered_model.hpp"
#include "simulation/newton/wall_terms.hpp"

/// A stenosed segment, plaque that yields inside a layer that does not, blown up by a rigid
/// cylinder that grows and shrinks again, here and in CalculiX.
/// growing_cylinder.sh runs both:  growing_cylinder write FILE.inp;  ccx FILE;
/// growing_cylinder compare FILE.dat.
/// Both have the same law: Simo's neo-Hookean solid with multiplicative J2 plasticity (Simo,
/// Hughes, "Computational Inelasticity", box 9.1; CalculiX: *ELASTIC and *PLASTIC with NLGEOM).
namespace {

using namespace angio;
using namespace angio::simulation;
using namespace angio::simulation::detail;

constexpr double kLength = 3.0, kOuter = 2.0;  // mm; the throat lies in the mirror plane z = 0
constexpr double kSmall = 0.6, kLarge = 1.5;   // mm: the cylinder's radius
constexpr double kPlaqueKpa = 1840.0, kYieldKpa = 400.0;  // Morlacchi's fibrous plaque
constexpr double kVesselKpa = 900.0;
constexpr double kPoisson = 0.48;
constexpr double kContactKpaPerMm = 1e5;  // at 500 kPa it gives by 5 um, in both
constexpr int kAround = 24, kAlong = 12;
constexpr int kFacets = 128;  // of the cylinder: it is a circle to 0.03 %

double shear(double young) { return young / (2.0 * (1.0 + kPoisson)); }
double bulk(double young) { return young / (3.0 * (1.0 - 2.0 * kPoisson)); }

LayeredWall segment() {
  TubeWall tube;
  tube.around = kAround;
  tube.along = kAlong;
  tube.length_mm = kLength;
  tube.inner_radius_mm = [](double angle, double z) {
    return kLarge - std::exp(-z * z) * (0.45 + 0.3 * std::cos(angle));
  };
  tube.outer_radius_mm = [](double, double) { return kOuter; };
  tube.layer_shares.assign(5, 1.0);
  tube.layer_regions = {WallRegion::plaque, WallRegion::plaque, WallRegion::plaque,
                        WallRegion::media, WallRegion::media};
  LayeredWall wall = make_tube_wall(tube);
  // Two vertices of the outer rim keep the segment from moving as a rigid body; they carry no load.
  const std::size_t rim = wall.vertices.size() / 6 * 5;
  wall.fixed[rim] = 2 + 4 + 8;
  wall.fixed[rim + kAround / 2] = 4 + 8;
  return wall;
}

WallOptions options() {
  WallOptions o;
  o.materials.fill({.shear_kpa = shear(kVesselKpa), .bulk_kpa = bulk(kVesselKpa)});
  o.materials[std::size_t(WallRegion::plaque)] = {
      .shear_kpa = shear(kPlaqueKpa), .bulk_kpa = bulk(kPlaqueKpa), .yield_kpa = kYieldKpa};
  o.foundation_kpa_per_mm = 0.0;
  return o;
}

/// The cylinder's nodes: inner and outer circle at either end.
std::vector<Vec3> cylinder_nodes() {
  std::vector<Vec3> nodes;
  for (const double z : {-0.5, kLength + 0.5})
    for (const double r : {kSmall - 0.1, kSmall})
      for (int k = 0; k < kFacets; ++k) {
        const double angle = 2.0 * units::kPi * k / kFacets;
        nodes.push_back({r * std::cos(angle), r * std::sin(angle), z});
      }
  return nodes;
}

/// Bricks around the axis, and their outer faces as a surface.
///
/// @param node, element  numbers of the first ones less one
void write_cylinder(std::ostream& out, std::size_t node, std::size_t element) {
  out << "*ELEMENT, TYPE=C3D8, ELSET=ERING\n";
  for (int k = 0; k < kFacets; ++k) {
    const int n = (k + 1) % kFacets, corner[4] = {k, n, n + kFacets, k + kFacets};
    out << element + std::size_t(k) + 1;
    for (const int end : {0, 2 * kFacets})
      for (const int c : {0, 3, 2, 1}) out << ", " << node + std::size_t(corner[c] + end) + 1;
    out << '\n';
  }
  out << "*SURFACE, NAME=SRING\n";
  for (int k = 0; k < kFacets; ++k) out << element + std::size_t(k) + 1 << ", S4\n";
}

/// Which elements are plaque, and which faces are the lumen's.
void write_parts(std::ostream& out, const LayeredWall& wall) {
  for (const bool plaque : {true, false}) {
    out << "*ELSET, ELSET=" << (plaque ? "EPLAQUE" : "EVESSEL") << '\n';
    for (std::size_t w = 0; w < wall.wedges.size(); ++w)
      if ((wall.region[w] == WallRegion::plaque) == plaque) out << w + 1 << '\n';
  }
  out << "*SURFACE, NAME=SINNER\n";
  for (std::size_t w = 0; w < wall.wedges.size(); ++w)
    if (wall.layer[w] == 0) out << w + 1 << ", S1\n";
}

void write_materials(std::ostream& out) {
  out << "*MATERIAL, NAME=PLAQUE\n*ELASTIC\n"
      << kPlaqueKpa << ", " << kPoisson << "\n*PLASTIC\n"
      << kYieldKpa << ", 0.\n"
      << kYieldKpa << ", 10.\n*MATERIAL, NAME=VESSEL\n*ELASTIC\n"
      << kVesselKpa << ", " << kPoisson << "\n*PLASTIC\n1e6, 0.\n1e6, 10.\n"
      << "*MATERIAL, NAME=RIGID\n*ELASTIC\n1e6, 0.3\n"
      << "*SOLID SECTION, ELSET=EPLAQUE, MATERIAL=PLAQUE\n"
      << "*SOLID SECTION, ELSET=EVESSEL, MATERIAL=VESSEL\n"
      << "*SOLID SECTION, ELSET=ERING, MATERIAL=RIGID\n"
      << "*SURFACE INTERACTION, NAME=TOUCH\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n"
      << kContactKpaPerMm << ", 1.\n"
      << "*CONTACT PAIR, INTERACTION=TOUCH, TYPE=SURFACE TO SURFACE\nSINNER, SRING\n";
}

/// The cylinder grows, then shrinks: its displacements count from where it was made.
void write_steps(std::ostream& out, const std::vector<Vec3>& cylinder, std::size_t node) {
  for (const double radius : {kLarge, kSmall}) {
    out << "*STEP, NLGEOM, INC=2000\n*STATIC\n0.02, 1.0, 1e-6, 0.05\n*BOUNDARY\n";
    for (std::size_t v = 0; v < cylinder.size(); ++v) {
      const Vec3& x = cylinder[v];
      const double grown = (radius - kSmall) / std::hypot(x.x, x.y);
      out << node + v + 1 << ", 1, 1, " << grown * x.x << '\n'
          << node + v + 1 << ", 2, 2, " << grown * x.y << '\n'
          << node + v + 1 << ", 3, 3, 0.\n";
    }
    out << "*NODE PRINT, NSET=NWALL, FREQUENCY=100000\nU\n*END STEP\n";
  }
}

void write_calculix(const LayeredWall& wall, const std::string& path) {
  ccx::Nodes nodes;
  const std::string elements = ccx::elements_of(wall, nodes);
  const std::vector<Vec3> cylinder = cylinder_nodes();
  std::ofstream out(path);
  out << std::fixed;  // a field holds 20 characters
  out.precision(12);
  out << "*NODE, NSET=NWALL\n";
  ccx::write_nodes(out, nodes.places);
  out << "*NODE, NSET=NRING\n";
  ccx::write_nodes(out, cylinder, nodes.places.size());
  out << "*ELEMENT, TYPE=C3D15, ELSET=EALL\n" << elements;
  write_cylinder(out, nodes.places.size(), wall.wedges.size());
  write_parts(out, wall);
  write_materials(out);
  out << "*BOUNDARY\n";
  ccx::write_held(out, nodes.fixed);
  write_steps(out, cylinder, nodes.places.size());
  if (!out.flush()) throw IoError("cannot write " + path + ". Check the folder and the disk");
}

/// k A_v / 2 <R - r_v>^2 of the lumen's vertices: a rigid cylinder around z, without friction.
class CylinderTerm final : public EnergyTerm {
 public:
  explicit CylinderTerm(const LayeredWall& wall) : stiffness_(wall.vertices.size(), 0.0) {
    for (const Triangle& t : wall.lumen_triangles) {
      const Vec3 &a = wall.vertices[std::size_t(t[0])], &b = wall.vertices[std::size_t(t[1])],
                 &c = wall.vertices[std::size_t(t[2])];
      for (const int v : t)
        stiffness_[std::size_t(v)] +=
            units::kPascalPerKilopascal * kContactKpaPerMm * norm(cross(b - a, c - a)) / 6.0;
    }
  }
  double radius = kSmall;  ///< R [mm]

  [[nodiscard]] double value(const std::vector<Vec3>& x) const override {
    double sum = 0.0;
    for (std::size_t v = 0; v < x.size(); ++v) {
      const double into = radius - std::hypot(x[v].x, x[v].y);
      if (stiffness_[v] > 0.0 && into > 0.0) sum += 0.5 * stiffness_[v] * into * into;
    }
    return sum;
  }
  void add(const std::vector<Vec3>& x, bool clamp, Assembly& out) const override {
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (!(stiffness_[v] > 0.0)) continue;
      const double r = std::hypot(x[v].x, x[v].y), into = radius - r;
      Mat3 block;
      if (into > 0.0) {
        const Vec3 n{x[v].x / r, x[v].y / r, 0.0}, t{-n.y, n.x, 0.0};
        out.add_gradient(int(v), -stiffness_[v] * into * n);
        block = stiffness_[v] * outer(n, n);
        if (!clamp) block += (-stiffness_[v] * into / r) * outer(t, t);
      }
      out.add_block(int(v), int(v), block);
    }
  }

 private:
  std::vector<double> stiffness_;  ///< k A_v [uN/mm]
};

struct Ours {
  std::vector<Vec3> peak, after;
  bool converged = true;
};

/// The cylinder grows and shrinks in steps; in each the plaque flows until it is still.
Ours grow(const LayeredWall& wall) {
  constexpr int kSteps = 30, kMostRounds = 2000;
  constexpr double kStill = 1e-6;  // of the equivalent plastic strain
  const WallOptions o = options();
  SolidModel model = make_solid_model(wall, o);
  WallState state = unloaded_state(wall);
  set_memory(state, model);
  const SolidTerm solid(model);
  CylinderTerm cylinder(wall);
  const NewtonOptions newton{
      .most_iterations = 200, .tolerance = 1e-6, .reuse = 0.8, .longest_move = 0.1};
  const Enclosure nothing;
  Minimizer minimizer({&solid, &cylinder}, wall.fixed, newton, nothing);
  Ours out;
  const auto follow = [&] {
    for (int round = 0; round < kMostRounds; ++round) {
      out.converged = minimizer.run(state.vertices).residual <= 1e-5 && out.converged;
      if (flow(model, state, 0.0) <= kStill) return;
    }
    out.converged = false;
  };
  for (int step = 1; step <= kSteps; ++step) {
    cylinder.radius = kSmall + (kLarge - kSmall) * step / kSteps;
    follow();
  }
  out.peak = state.vertices;
  for (int step = kSteps - 1; step >= 0; --step) {
    cylinder.radius = kSmall + (kLarge - kSmall) * step / kSteps;
    follow();
  }
  out.after = state.vertices;
  return out;
}

/// Mean distance from the axis [mm] of the throat's ring: of the lumen or the outside.
double mean_radius(const std::vector<Vec3>& x, bool outside) {
  const std::size_t first = outside ? x.size() / 6 * 5 : 0;
  double sum = 0.0;
  for (std::size_t k = 0; k < kAround; ++k) sum += std::hypot(x[first + k].x, x[first + k].y);
  return sum / kAround;
}

/// Least diameter [mm] of that ring of the lumen.
double least_diameter(const std::vector<Vec3>& x) {
  double least = 1e9;
  for (std::size_t k = 0; k < kAround / 2; ++k)
    least = std::min(least, distance(x[k], x[k + kAround / 2]));
  return least;
}

std::vector<Vec3> moved(const LayeredWall& wall, const std::vector<Vec3>& displacements) {
  std::vector<Vec3> x = wall.vertices;
  for (std::size_t v = 0; v < x.size(); ++v) x[v] += displacements[v];
  return x;
}

int compare(const LayeredWall& wall, const std::string& path) {
  const auto tables = ccx::read_displacements(path, wall.vertices.size(), 2);
  const std::vector<Vec3> peak = moved(wall, tables[tables.size() - 2]),
                          after = moved(wall, tables.back());
  const Ours ours = grow(wall);
  constexpr double kBar = 2.0;  // %
  bool good = ours.converged;
  std::printf(
      "\n%zu wedges; lumen's least radius %.2f mm, cylinder %.2f to %.2f to %.2f mm; plaque E "
      "%.0f kPa, yields at %.0f kPa, vessel E %.0f kPa, nu %.2f. %s.\n\n"
      "| in the throat's ring | before | CalculiX | here | difference %% | bar %% |\n"
      "|---|---|---|---|---|---|\n",
      wall.wedges.size(), 0.75, kSmall, kLarge, kSmall, kPlaqueKpa, kYieldKpa, kVesselKpa, kPoisson,
      ours.converged ? "Every step converged" : "NOT every step converged");
  const auto row = [&](const char* what, double before, double theirs, double mine) {
    const double off = 100.0 * (mine - theirs) / theirs;
    good = good && std::abs(off) <= kBar;
    std::printf("| %s | %.4f | %.4f | %.4f | %.2f | %.0f |\n", what, before, theirs, mine, off,
                kBar);
  };
  row("mean lumen diameter at the peak mm", 2.0 * mean_radius(wall.vertices, false),
      2.0 * mean_radius(peak, false), 2.0 * mean_radius(ours.peak, false));
  row("mean outer diameter at the peak mm", 2.0 * mean_radius(wall.vertices, true),
      2.0 * mean_radius(peak, true), 2.0 * mean_radius(ours.peak, true));
  row("mean lumen diameter after mm", 2.0 * mean_radius(wall.vertices, false),
      2.0 * mean_radius(after, false), 2.0 * mean_radius(ours.after, false));
  row("least lumen diameter after mm", least_diameter(wall.vertices), least_diameter(after),
      least_diameter(ours.after));
  row("mean outer diameter after mm", 2.0 * mean_radius(wall.vertices, true),
      2.0 * mean_radius(after, true), 2.0 * mean_radius(ours.after, true));
  return good ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  return ccx::write_or_compare(argc, argv, segment(), write_calculix, compare);
}
