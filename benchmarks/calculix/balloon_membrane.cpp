#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/triangle_mesh.hpp"
#include "core/units.hpp"
#include "simulation/newton/initial_capsule.hpp"
#include "testing/simulation/closed_forms.hpp"
#include "testing/simulation/spheres.hpp"

/// A balloon's membrane in CalculiX and here (see balloon_membrane.sh):
///
///     balloon_membrane write sphere|capsule FILE.inp     writes CalculiX's deck
///     balloon_membrane compare sphere|capsule FILE.dat   reads its displacements, solves, compares
///     balloon_membrane solve sphere|capsule AROUND       prints mesh and solution
///
/// CalculiX has no incompressible membrane: it gets a Mooney-Rivlin solid, nearly incompressible,
/// of the same thickness. Half of the pressure pushes on its inner face, half pulls on its outer
/// one, so that it acts on the mid-surface.
///
/// The sphere is the same mesh in both: each triangle becomes one quadratic wedge C3D15. It is
/// stretched alike everywhere; where the stretch varies these wedges, integrated in full, lock. So
/// the capsule (a cylinder with hemispherical ends) is a surface of revolution in CalculiX, of
/// quadratic elements of reduced integration (CAX8R), far finer than our meshes, which must come to
/// it as they are refined.
namespace angio::simulation {
namespace {

using namespace detail;
using testing::kC1, testing::kC2;  // polyurethane [MPa]

constexpr double kRadius = 1.5, kWall = 0.01, kStretch = 1.1;
constexpr double kLength = 10.0;  // of the capsule's cylinder
constexpr double kBar = 0.01;     // of the largest displacement

// The step that ends a deck: pressure on the given faces, inner and outer.
void write_step(double pressure, const char* inner, const char* outer, std::FILE* file) {
  std::fprintf(file,
               "*STEP,NLGEOM,INC=1000\n*STATIC\n0.1,1.,1e-6,0.2\n*DLOAD\nWALL,%s,%.9g\n"
               "WALL,%s,%.9g\n*NODE PRINT,NSET=ALL,FREQUENCY=1000\nU\n*END STEP\n",
               inner, 0.5 * pressure, outer, -0.5 * pressure);
}

// @param bulk_ratio  of the bulk to the shear modulus
void write_rubber(double bulk_ratio, std::FILE* file) {
  std::fprintf(file,
               "*MATERIAL,NAME=RUBBER\n*HYPERELASTIC,MOONEY-RIVLIN\n%.9g,%.9g,%.9g\n"
               "*SOLID SECTION,ELSET=WALL,MATERIAL=RUBBER\n*BOUNDARY\n",
               kC1, kC2, 2.0 / (bulk_ratio * 2.0 * (kC1 + kC2)));
}

double sphere_pressure_mpa() {
  return 4.0 * kWall / kRadius *
         (kC1 * (1.0 / kStretch - std::pow(kStretch, -7)) +
          kC2 * (kStretch - std::pow(kStretch, -5)));
}

TriangleMesh sphere_mesh() { return testing::icosphere(kRadius, 7); }  // 492 vertices

// From the mid-surface to the faces at a vertex: so long that the facets around are H thick.
std::vector<Vec3> half_walls(const TriangleMesh& mesh, double wall) {
  std::vector<Vec3> sum(mesh.vertices.size());
  std::vector<double> area(mesh.vertices.size(), 0.0);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3& p = mesh.vertices[std::size_t(a)];
    const Vec3 normal = cross(mesh.vertices[std::size_t(b)] - p, mesh.vertices[std::size_t(c)] - p);
    for (const int v : {a, b, c}) {
      sum[std::size_t(v)] += normal;
      area[std::size_t(v)] += norm(normal);
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) {
    const double cosine = norm(sum[v]) / area[v];  // of the facets' normals with the vertex's
    sum[v] = (0.5 * wall / cosine) * normalized(sum[v]);
  }
  return sum;
}

// A point of the mid-surface: its corners and their weights in twelfths.
using Point = std::map<int, int>;

// Nodes 3 v + 1, 2 and 3 are the inner face's, the middle's and the outer face's of vertex v; those
// of the edges follow.
class Deck {
 public:
  Deck(const TriangleMesh& mesh, double wall) : mesh_(mesh), half_(half_walls(mesh, wall)) {
    for (int v = 0; v < int(mesh.vertices.size()); ++v)
      for (const int layer : {0, 1, 2}) node({{v, 12}}, layer);
    for (const Triangle& t : mesh.triangles) add_wedge(t);
  }

  void write(double pressure, std::FILE* file) const {
    std::fprintf(file, "*NODE,NSET=ALL\n");
    for (std::size_t n = 0; n < nodes_.size(); ++n)
      std::fprintf(file, "%zu,%.12g,%.12g,%.12g\n", n + 1, nodes_[n].x, nodes_[n].y, nodes_[n].z);
    std::fprintf(file, "*ELEMENT,TYPE=C3D15,ELSET=WALL\n");
    for (std::size_t e = 0; e < wedges_.size(); ++e) {
      std::fprintf(file, "%zu", e + 1);
      for (const int n : wedges_[e]) std::fprintf(file, ",%d", n);
      std::fprintf(file, "\n");
    }
    write_rubber(500.0, file);
    const std::vector<char> fixed = testing::without_rigid_motion(mesh_);
    for (std::size_t v = 0; v < fixed.size(); ++v)
      for (int axis = 0; axis < 3; ++axis)
        if ((fixed[v] & std::array{kFixedX, kFixedY, kFixedZ}[std::size_t(axis)]) != 0)
          std::fprintf(file, "%zu,%d,%d\n", 3 * v + 2, axis + 1, axis + 1);
    write_step(pressure, "P1", "P2", file);
  }

 private:
  int node(const Point& point, int layer) {
    const auto [at, is_new] = number_.try_emplace({point, layer}, int(nodes_.size()) + 1);
    if (is_new) {
      Vec3 p;
      for (const auto& [v, weight] : point)
        p += (weight / 12.0) *
             (mesh_.vertices[std::size_t(v)] + double(layer - 1) * half_[std::size_t(v)]);
      nodes_.push_back(p);
    }
    return at->second;
  }

  void add_wedge(const Triangle& t) {
    std::vector<int> wedge;
    for (const int layer : {0, 2})
      for (const int v : t) wedge.push_back(node({{v, 12}}, layer));
    for (const int layer : {0, 2})
      for (std::size_t k = 0; k < 3; ++k)
        wedge.push_back(node({{t[k], 6}, {t[(k + 1) % 3], 6}}, layer));
    for (const int v : t) wedge.push_back(node({{v, 12}}, 1));
    wedges_.push_back(std::move(wedge));
  }

  const TriangleMesh& mesh_;
  std::vector<Vec3> half_;
  std::vector<Vec3> nodes_;
  std::map<std::pair<Point, int>, int> number_;
  std::vector<std::vector<int>> wedges_;
};

// The displacements of the last block of CalculiX's node print, by node.
std::map<int, Vec3> read_displacements(const std::string& path) {
  std::ifstream file(path);
  std::map<int, Vec3> all;
  std::string line;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    int number = 0;
    Vec3 u;
    if (words >> number >> u.x >> u.y >> u.z) all[number] = u;
  }
  return all;
}

// The equilibrium here.
NewtonResult inflate(const TriangleMesh& mesh, const std::vector<char>& fixed, double pressure_mpa,
                     std::vector<Vec3>& x) {
  x = mesh.vertices;
  const MembraneTerm skin(
      {{units::pascal_from_megapascal(kC1), units::pascal_from_megapascal(kC2)}, {}, false},
      mesh.triangles, mesh.vertices, kWall);
  return minimize(
      {&skin}, fixed, x, {},
      {mesh.triangles, Enclosure::Control::pressure, units::pascal_from_megapascal(pressure_mpa)});
}

// @throws InputError
Vec3 displacement(const std::map<int, Vec3>& all, int node) {
  const auto at = all.find(node);
  if (at == all.end())
    throw InputError("CalculiX's file lacks node " + std::to_string(node) +
                     " (it did not finish?). See its output");
  return at->second;
}

void write_sphere(std::FILE* file) {
  const TriangleMesh mesh = sphere_mesh();
  Deck(mesh, kWall).write(sphere_pressure_mpa(), file);
}

int compare_sphere(const std::map<int, Vec3>& theirs) {
  const TriangleMesh mesh = sphere_mesh();
  std::vector<Vec3> x;
  const NewtonResult ours =
      inflate(mesh, testing::without_rigid_motion(mesh), sphere_pressure_mpa(), x);
  double largest = 0.0, worst = 0.0, squared = 0.0;
  for (std::size_t v = 0; v < x.size(); ++v) {
    const Vec3 u = x[v] - mesh.vertices[v];
    const double off = distance(u, displacement(theirs, 3 * int(v) + 2));
    largest = std::max(largest, norm(u));
    worst = std::max(worst, off);
    squared += off * off;
  }
  const double mean = std::sqrt(squared / double(x.size()));
  const bool pass = ours.converged && worst <= kBar * largest;
  std::printf(
      "\nSpherical balloon, the same mesh; differences in %% of the largest displacement.\n\n"
      "| vertices | largest displacement mm | at most | root mean square | bar | |\n"
      "|---|---|---|---|---|---|\n| %zu | %.4f | %.2f | %.2f | 1 | %s |\n",
      x.size(), largest, 100.0 * worst / largest, 100.0 * mean / largest, pass ? "pass" : "FAIL");
  return pass ? 0 : 1;
}

double capsule_pressure_mpa() { return testing::closed_tube(kStretch).load_mpa * kWall / kRadius; }

// The capsule's meridian from its middle to its pole, in quadratic elements between every second
// station. Nodes 3 i + 1, 2 and 3 are the inner face's, the middle's and the outer face's.
class Meridian {
 public:
  Meridian() {
    constexpr int kElements = 60;  // of the half cylinder, and of the end; finer at the shoulder
    const double end = 0.5 * units::kPi * kRadius;
    for (int i = 0; i < 2 * kElements; ++i)
      stations_.push_back(0.5 * kLength * (1.0 - std::pow(1.0 - 0.5 * i / kElements, 1.7)));
    for (int i = 0; i <= 2 * kElements; ++i)
      stations_.push_back(0.5 * kLength + end * std::pow(0.5 * i / kElements, 1.3));
    for (std::size_t i = 1; i + 1 < stations_.size(); i += 2)
      stations_[i] = 0.5 * (stations_[i - 1] + stations_[i + 1]);
  }

  void write(std::FILE* file) const {
    std::fprintf(file, "*NODE,NSET=ALL\n");
    const int last = int(stations_.size()) - 1;
    for (int i = 0; i <= last; ++i)
      for (int layer = 0; layer < 3; ++layer) {
        if (layer == 1 && i % 2 == 1) continue;
        const double s = stations_[std::size_t(i)];
        const double up = i == last ? 0.5 * units::kPi : std::max(0.0, s - 0.5 * kLength) / kRadius;
        const double r = kRadius + 0.5 * kWall * (layer - 1);
        std::fprintf(file, "%d,%.12g,%.12g,0.\n", 3 * i + layer + 1,
                     i == last ? 0.0 : r * std::cos(up),
                     std::min(s, 0.5 * kLength) + r * std::sin(up));
      }
    std::fprintf(file, "*ELEMENT,TYPE=CAX8R,ELSET=WALL\n");
    for (int i = 0; i < last; i += 2) {
      const int a = 3 * i, b = a + 3, c = a + 6;
      std::fprintf(file, "%d,%d,%d,%d,%d,%d,%d,%d,%d\n", i / 2 + 1, a + 1, a + 3, c + 3, c + 1,
                   a + 2, b + 3, c + 2, b + 1);
    }
    write_rubber(20000.0, file);
    for (int layer = 1; layer <= 3; ++layer)
      std::fprintf(file, "%d,2,2\n%d,1,1\n", layer, 3 * last + layer);
    write_step(capsule_pressure_mpa(), "P4", "P2", file);
  }

  // Outward from the axis and along it, of the middle of the wall, at a distance along the
  // meridian.
  [[nodiscard]] std::array<double, 2> at(const std::map<int, Vec3>& all, double s) const {
    const auto found = std::upper_bound(stations_.begin(), stations_.end(), s);
    const int j = std::clamp(int(found - stations_.begin()), 1, int(stations_.size()) - 1);
    const double before = stations_[std::size_t(j) - 1], after = stations_[std::size_t(j)];
    const double t = (s - before) / (after - before);
    const auto middle = [&](int i) {
      return 0.5 * (displacement(all, 3 * i + 1) + displacement(all, 3 * i + 3));
    };
    const Vec3 u = (1.0 - t) * middle(j - 1) + t * middle(j);
    return {u.x, u.y};
  }

 private:
  std::vector<double> stations_;  // along the meridian [mm]
};

struct CapsuleDifference {
  double largest = 0.0;                // displacement [mm]
  double shoulder = 0.0, pole = 0.0;   // where the cylinder ends; at the two vertices on the axis
  double elsewhere = 0.0, mean = 0.0;  // at the other vertices; root mean square of all
  bool converged = false;
};

CapsuleDifference compare_capsule(const std::map<int, Vec3>& theirs, const Capsule& capsule) {
  const Meridian meridian;
  std::vector<Vec3> x;
  CapsuleDifference d;
  d.converged =
      inflate(capsule.mesh, without_rigid_motion(capsule), capsule_pressure_mpa(), x).converged;
  for (std::size_t v = 0; v < x.size(); ++v) {
    const Vec3 &p = capsule.mesh.vertices[v], u = x[v] - p;
    const double r = std::hypot(p.x, p.y), beyond = std::abs(p.z) - 0.5 * kLength;
    const bool is_pole = r < 1e-9;
    const double s = beyond > 1e-9
                         ? 0.5 * kLength + kRadius * std::asin(std::min(1.0, beyond / kRadius))
                         : std::abs(p.z);
    const auto [out, along] = meridian.at(theirs, s);
    // The vertices are the corners of a prism about the circle.
    const double f = is_pole ? 0.0 : capsule.circle_factor * out / r;
    const double off = distance(u, Vec3{f * p.x, f * p.y, p.z < 0.0 ? -along : along});
    d.largest = std::max(d.largest, norm(u));
    double& most = is_pole ? d.pole : std::abs(beyond) < 1e-9 ? d.shoulder : d.elsewhere;
    most = std::max(most, off);
    d.mean += off * off / double(x.size());
  }
  d.mean = std::sqrt(d.mean);
  return d;
}

int compare_capsule(const std::map<int, Vec3>& theirs) {
  std::printf(
      "\nCapsule balloon, against a far finer mesh of revolution; differences in %% of the largest "
      "displacement.\n\n"
      "| vertices around | in all | largest displacement mm | shoulder | elsewhere, at most | "
      "poles "
      "| root mean square |\n|---|---|---|---|---|---|---|\n");
  bool pass = true;
  for (const int around : {16, 32, 64, 128}) {
    const Capsule capsule = make_capsule(kRadius, kLength, around);
    const CapsuleDifference d = compare_capsule(theirs, capsule);
    const double percent = 100.0 / d.largest;
    std::printf("| %d | %zu | %.4f | %.2f | %.2f | %.2f | %.3f |\n", around,
                capsule.mesh.vertices.size(), d.largest, percent * d.shoulder,
                percent * d.elsewhere, percent * d.pole, percent * d.mean);
    pass = d.converged && std::max({d.shoulder, d.elsewhere, d.pole}) <= kBar * d.largest;
  }
  std::printf("\nThe bar of 1 %% at the last: %s.\n", pass ? "pass" : "FAIL");
  return pass ? 0 : 1;
}

int write(const std::string& shape, const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) {
    std::fprintf(stderr, "cannot write %s. Check the folder\n", path.c_str());
    return 73;
  }
  shape == "sphere" ? write_sphere(file) : Meridian().write(file);
  return std::fclose(file) == 0 ? 0 : 74;
}

// Mesh, fixed axes (sums of 1, 2, 4) and equilibrium, for another program on the same mesh
// (benchmarks/fenicsx).
int solve(const std::string& shape, int around, std::FILE* file) {
  TriangleMesh mesh = sphere_mesh();
  std::vector<char> fixed = testing::without_rigid_motion(mesh);
  double pressure = sphere_pressure_mpa();
  if (shape == "capsule") {
    const Capsule capsule = make_capsule(kRadius, kLength, around);
    mesh = capsule.mesh;
    fixed = without_rigid_motion(capsule);
    pressure = capsule_pressure_mpa();
  }
  std::vector<Vec3> x;
  const bool converged = inflate(mesh, fixed, pressure, x).converged;
  std::fprintf(file, "%zu %zu %.17g %.17g %.17g %.17g\n", x.size(), mesh.triangles.size(), kC1, kC2,
               kWall, pressure);
  for (std::size_t v = 0; v < x.size(); ++v) {
    const Vec3 &p = mesh.vertices[v], &q = x[v];
    std::fprintf(file, "%.17g %.17g %.17g %d %.17g %.17g %.17g\n", p.x, p.y, p.z, fixed[v] / 2, q.x,
                 q.y, q.z);
  }
  for (const auto& [a, b, c] : mesh.triangles) std::fprintf(file, "%d %d %d\n", a, b, c);
  return converged ? 0 : 1;
}

int compare(const std::string& shape, const std::string& path) {
  const auto theirs = read_displacements(path);
  return shape == "sphere" ? compare_sphere(theirs) : compare_capsule(theirs);
}

}  // namespace
}  // namespace angio::simulation

int main(int count, char** arguments) {
  const std::vector<std::string> words(arguments + 1, arguments + count);
  try {
    if (words.size() == 3 && (words[1] == "sphere" || words[1] == "capsule")) {
      if (words[0] == "write") return angio::simulation::write(words[1], words[2]);
      if (words[0] == "compare") return angio::simulation::compare(words[1], words[2]);
    }
    if (words.size() == 3 && words[0] == "solve")
      return angio::simulation::solve(words[1], std::stoi(words[2]), stdout);
    std::fprintf(stderr,
                 "usage: balloon_membrane write|compare sphere|capsule FILE.inp|FILE.dat\n"
                 "       balloon_membrane solve sphere|capsule AROUND\n");
    return 64;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 70;
  }
}
