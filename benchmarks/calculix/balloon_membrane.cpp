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
#include "simulation/detail/free_states.hpp"

/// A balloon's membrane in CalculiX and here, on the same mesh (see balloon_membrane.sh):
///
///     balloon_membrane write FILE.inp [C3D6|C3D15]   writes CalculiX's deck
///     balloon_membrane compare FILE.dat              reads its displacements, solves, compares
///
/// CalculiX has no incompressible membrane: each triangle becomes one wedge of the same thickness,
/// of a Mooney-Rivlin solid with a bulk modulus of 500 times its shear modulus. Half of the
/// pressure pushes on its inner face, half pulls on its outer one, so that it acts on the
/// mid-surface.
namespace angio::simulation {
namespace {

using namespace detail;

constexpr double kC1 = 1.031, kC2 = 3.69;  // polyurethane [MPa]
constexpr double kLoad = 2.945;            // p R / H [MPa]: a stretch of 1.1
constexpr int kAround = 24;

FreeBalloon the_balloon() {
  FreeBalloon balloon;
  balloon.radius_mm = 1.5;
  balloon.length_mm = 4.0;
  balloon.material.name = "polyurethane";
  balloon.material.wall_mm = 0.01;
  return balloon;
}

double pressure_mpa(const FreeBalloon& balloon) {
  return kLoad * balloon.material.wall_mm / balloon.radius_mm;
}

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

bool is_upper(const Capsule& capsule, const Triangle& t) {
  return std::all_of(t.begin(), t.end(),
                     [&](int v) { return capsule.mesh.vertices[std::size_t(v)].z > -1e-9; });
}

// A point of the mid-surface: its corners and their weights in twelfths.
using Point = std::map<int, int>;

Point between(const Point& a, const Point& b) {
  Point sum;
  for (const Point* point : {&a, &b})
    for (const auto& [v, weight] : *point) sum[v] += weight;
  for (auto& [v, weight] : sum) weight /= 2;
  return sum;
}

// Each triangle becomes three bricks of 20 nodes, around its corners. Nodes 3 v + 1, 2 and 3 are
// the inner face's, the middle's and the outer face's of vertex v; the others follow.
class Deck {
 public:
  Deck(const Capsule& capsule, double wall)
      : capsule_(capsule), half_(half_walls(capsule.mesh, wall)) {
    for (int v = 0; v < int(capsule.mesh.vertices.size()); ++v)
      for (const int layer : {0, 1, 2}) node({{v, 12}}, layer);  // those of the lower half unused
  }

  void write(double pressure, std::FILE* file) {
    for (const Triangle& t : capsule_.mesh.triangles)
      if (is_upper(capsule_, t)) add_bricks(t);
    std::fprintf(file, "*NODE,NSET=ALL\n");
    for (std::size_t n = 0; n < nodes_.size(); ++n)
      std::fprintf(file, "%zu,%.12g,%.12g,%.12g\n", n + 1, nodes_[n].x, nodes_[n].y, nodes_[n].z);
    std::fprintf(file, "*ELEMENT,TYPE=C3D20R,ELSET=WALL\n");
    for (std::size_t e = 0; e < bricks_.size(); ++e) {
      std::fprintf(file, "%zu", e + 1);
      for (std::size_t k = 0; k < bricks_[e].size(); ++k)
        std::fprintf(file, k == 14 ? ",\n%d" : ",%d", bricks_[e][k]);
      std::fprintf(file, "\n");
    }
    const double bulk = 500.0 * 2.0 * (kC1 + kC2);
    std::fprintf(file,
                 "*MATERIAL,NAME=RUBBER\n*HYPERELASTIC,MOONEY-RIVLIN\n%.9g,%.9g,%.9g\n"
                 "*SOLID SECTION,ELSET=WALL,MATERIAL=RUBBER\n*BOUNDARY\n",
                 kC1, kC2, 2.0 / bulk);
    for (const int layer : {1, 3}) {
      std::fprintf(file, "%d,1,2\n", 3 * capsule_.high_pole + layer);
      std::fprintf(file, "%d,2,2\n", 3 * capsule_.middle_ring * capsule_.around + layer);
    }
    for (std::size_t n = 0; n < nodes_.size(); ++n)
      if (std::abs(nodes_[n].z) < 1e-9) std::fprintf(file, "%zu,3,3\n", n + 1);
    std::fprintf(file,
                 "*STEP,NLGEOM,INC=1000\n*STATIC\n0.05,1.,1e-6,0.2\n*DLOAD\nWALL,P1,%.9g\n"
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
             (capsule_.mesh.vertices[std::size_t(v)] + double(layer - 1) * half_[std::size_t(v)]);
      nodes_.push_back(p);
    }
    return at->second;
  }

  void add_bricks(const Triangle& t) {
    const Point centre{{t[0], 4}, {t[1], 4}, {t[2], 4}};
    for (std::size_t k = 0; k < 3; ++k) {
      const Point corner{{t[k], 12}};
      const Point next = between(corner, {{t[(k + 1) % 3], 12}});
      const Point last = between(corner, {{t[(k + 2) % 3], 12}});
      const std::array<Point, 4> face{corner, next, centre, last};
      std::vector<int> brick;
      for (const int layer : {0, 2})
        for (const Point& p : face) brick.push_back(node(p, layer));
      for (const int layer : {0, 2})
        for (std::size_t i = 0; i < 4; ++i)
          brick.push_back(node(between(face[i], face[(i + 1) % 4]), layer));
      for (const Point& p : face) brick.push_back(node(p, 1));
      bricks_.push_back(std::move(brick));
    }
  }

  const Capsule& capsule_;
  std::vector<Vec3> half_;
  std::vector<Vec3> nodes_;
  std::map<std::pair<Point, int>, int> number_;
  std::vector<std::vector<int>> bricks_;
};

int write(const std::string& path) {
  const FreeBalloon balloon = the_balloon();
  const Capsule capsule = mesh_of(balloon, kAround);
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) {
    std::fprintf(stderr, "cannot write %s. Check the folder\n", path.c_str());
    return 73;
  }
  Deck(capsule, balloon.material.wall_mm).write(pressure_mpa(balloon), file);
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
  const FreeBalloon balloon = the_balloon();
  const Capsule capsule = mesh_of(balloon, kAround);
  const auto theirs = read_displacements(path);
  InflateOptions options;
  options.around = kAround;
  const auto states = find_states(balloon, capsule, options, Hold::pressure,
                                  {units::pascal_from_megapascal(pressure_mpa(balloon))}, {});
  double largest = 0.0, worst = 0.0, squared = 0.0;
  int count = 0;
  for (std::size_t v = 0; v < capsule.mesh.vertices.size(); ++v) {
    if (capsule.mesh.vertices[v].z < -1e-9) continue;
    ++count;
    const auto inner = theirs.find(3 * int(v) + 1), outer = theirs.find(3 * int(v) + 3);
    if (inner == theirs.end() || outer == theirs.end()) {
      std::fprintf(stderr, "%s lacks node %zu (CalculiX did not finish?). See its output\n",
                   path.c_str(), 3 * v + 1);
      return 65;
    }
    const Vec3 u = states[0].x[v] - capsule.mesh.vertices[v];
    const double off = norm(u - 0.5 * (inner->second + outer->second));
    largest = std::max(largest, norm(u));
    worst = std::max(worst, off);
    squared += off * off;
  }
  const double mean = std::sqrt(squared / count);
  const bool pass = states[0].converged && worst <= 0.01 * largest;
  std::printf(
      "balloon membrane against CalculiX: %d vertices, largest displacement %.4f mm, difference "
      "%.2f %% of it at most (root mean square %.2f %%), bar 1 %%: %s\n",
      count, largest, 100.0 * worst / largest, 100.0 * mean / largest, pass ? "pass" : "FAIL");
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
