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

#include "core/triangle_mesh.hpp"
#include "core/units.hpp"
#include "tests/simulation/spheres.hpp"

/// A spherical balloon's membrane in CalculiX and here, on the same mesh (see balloon_membrane.sh):
///
///     balloon_membrane write FILE.inp     writes CalculiX's deck
///     balloon_membrane compare FILE.dat   reads its displacements, solves, compares
///
/// CalculiX has no incompressible membrane: each triangle becomes one quadratic wedge C3D15 of the
/// same thickness, of a Mooney-Rivlin solid with a bulk modulus of 500 times its shear modulus.
/// Half of the pressure pushes on its inner face, half pulls on its outer one, so that it acts on
/// the mid-surface. A sphere, since it is stretched alike everywhere: where the stretch varies
/// these wedges, nearly incompressible and integrated in full, are too stiff.
namespace angio::simulation {
namespace {

using namespace detail;

constexpr double kC1 = 1.031, kC2 = 3.69;  // polyurethane [MPa]
constexpr double kRadius = 1.5, kWall = 0.01, kStretch = 1.1;

double pressure_mpa() {
  return 4.0 * kWall / kRadius *
         (kC1 * (1.0 / kStretch - std::pow(kStretch, -7)) +
          kC2 * (kStretch - std::pow(kStretch, -5)));
}

TriangleMesh the_mesh() { return testing::icosphere(kRadius, 7); }  // 492 vertices

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
    const double bulk = 500.0 * 2.0 * (kC1 + kC2);
    std::fprintf(file,
                 "*MATERIAL,NAME=RUBBER\n*HYPERELASTIC,MOONEY-RIVLIN\n%.9g,%.9g,%.9g\n"
                 "*SOLID SECTION,ELSET=WALL,MATERIAL=RUBBER\n*BOUNDARY\n",
                 kC1, kC2, 2.0 / bulk);
    const std::vector<char> fixed = testing::without_rigid_motion(mesh_);
    for (std::size_t v = 0; v < fixed.size(); ++v)
      for (int axis = 0; axis < 3; ++axis)
        if ((fixed[v] & std::array{kFixedX, kFixedY, kFixedZ}[std::size_t(axis)]) != 0)
          std::fprintf(file, "%zu,%d,%d\n", 3 * v + 2, axis + 1, axis + 1);
    std::fprintf(file,
                 "*STEP,NLGEOM,INC=1000\n*STATIC\n0.1,1.,1e-6,0.2\n*DLOAD\nWALL,P1,%.9g\n"
                 "WALL,P2,%.9g\n*NODE PRINT,NSET=ALL,FREQUENCY=1000\nU\n*END STEP\n",
                 0.5 * pressure, -0.5 * pressure);
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

int write(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) {
    std::fprintf(stderr, "cannot write %s. Check the folder\n", path.c_str());
    return 73;
  }
  const TriangleMesh mesh = the_mesh();
  Deck(mesh, kWall).write(pressure_mpa(), file);
  return std::fclose(file) == 0 ? 0 : 74;
}

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

int compare(const std::string& path) {
  const TriangleMesh mesh = the_mesh();
  const auto theirs = read_displacements(path);
  std::vector<Vec3> x = mesh.vertices;
  const MembraneTerm skin(
      {{units::pascal_from_megapascal(kC1), units::pascal_from_megapascal(kC2)}, {}, false},
      mesh.triangles, mesh.vertices, kWall);
  const NewtonResult ours = minimize({&skin}, testing::without_rigid_motion(mesh), x, {},
                                     {mesh.triangles, Enclosure::Control::pressure,
                                      units::pascal_from_megapascal(pressure_mpa())});
  double largest = 0.0, worst = 0.0, squared = 0.0;
  for (std::size_t v = 0; v < x.size(); ++v) {
    const auto middle = theirs.find(3 * int(v) + 2);
    if (middle == theirs.end()) {
      std::fprintf(stderr, "%s lacks node %zu (CalculiX did not finish?). See its output\n",
                   path.c_str(), 3 * v + 2);
      return 65;
    }
    const Vec3 u = x[v] - mesh.vertices[v];
    const double off = norm(u - middle->second);
    largest = std::max(largest, norm(u));
    worst = std::max(worst, off);
    squared += off * off;
  }
  const double mean = std::sqrt(squared / double(x.size()));
  const bool pass = ours.converged && worst <= 0.01 * largest;
  std::printf(
      "spherical balloon against CalculiX: %zu vertices, largest displacement %.4f mm, difference "
      "%.2f %% of it at most (root mean square %.2f %%), bar 1 %%: %s\n",
      x.size(), largest, 100.0 * worst / largest, 100.0 * mean / largest, pass ? "pass" : "FAIL");
  return pass ? 0 : 1;
}

}  // namespace
}  // namespace angio::simulation

int main(int count, char** arguments) {
  const std::vector<std::string> words(arguments + 1, arguments + count);
  try {
    if (words.size() == 2 && words[0] == "write") return angio::simulation::write(words[1]);
    if (words.size() == 2 && words[0] == "compare") return angio::simulation::compare(words[1]);
    std::fprintf(stderr, "usage: balloon_membrane write FILE.inp | compare FILE.dat\n");
    return 64;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 70;
  }
}
