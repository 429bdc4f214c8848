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

/// A balloon's membrane in CalculiX and here, on the same mesh (see run.sh):
///
///     calculix_membrane write FILE.inp [C3D6|C3D15]   writes CalculiX's deck
///     calculix_membrane compare FILE.dat              reads its displacements, solves, compares
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

// Nodes: 3 v + 1 inner, + 2 middle, + 3 outer of vertex v; then inner and outer of each edge.
class Deck {
 public:
  Deck(const Capsule& capsule, bool quadratic) : capsule_(capsule), quadratic_(quadratic) {}

  void write(const FreeBalloon& balloon, std::FILE* file) {
    std::fprintf(file, "*NODE,NSET=ALL\n");
    write_nodes(half_walls(capsule_.mesh, balloon.material.wall_mm), file);
    std::fprintf(file, "*ELEMENT,TYPE=%s,ELSET=WALL\n", quadratic_ ? "C3D15" : "C3D6");
    write_elements(file);
    const double bulk = 500.0 * 2.0 * (kC1 + kC2);
    std::fprintf(file,
                 "*MATERIAL,NAME=RUBBER\n*HYPERELASTIC,MOONEY-RIVLIN\n%.9g,%.9g,%.9g\n"
                 "*SOLID SECTION,ELSET=WALL,MATERIAL=RUBBER\n*BOUNDARY\n",
                 kC1, kC2, 2.0 / bulk);
    for (const int v : {capsule_.low_pole, capsule_.high_pole})
      std::fprintf(file, "%d,1,2\n%d,1,2\n", 3 * v + 1, 3 * v + 3);
    const int turn = capsule_.middle_ring * capsule_.around;
    std::fprintf(file, "%d,2,3\n%d,2,3\n", 3 * turn + 1, 3 * turn + 3);
    const double half = 0.5 * pressure_mpa(balloon);
    std::fprintf(file,
                 "*STEP,NLGEOM,INC=1000\n*STATIC\n0.02,1.,1e-6,0.1\n*DLOAD\nWALL,P1,%.9g\n"
                 "WALL,P2,%.9g\n*NODE PRINT,NSET=ALL,FREQUENCY=1000\nU\n*END STEP\n",
                 half, -half);
  }

 private:
  void node(int number, const Vec3& p, std::FILE* file) {
    std::fprintf(file, "%d,%.12g,%.12g,%.12g\n", number, p.x, p.y, p.z);
  }

  void write_nodes(const std::vector<Vec3>& half, std::FILE* file) {
    const auto& x = capsule_.mesh.vertices;
    for (std::size_t v = 0; v < x.size(); ++v) {
      node(3 * int(v) + 1, x[v] - half[v], file);
      if (quadratic_) node(3 * int(v) + 2, x[v], file);
      node(3 * int(v) + 3, x[v] + half[v], file);
    }
    if (!quadratic_) return;
    int next = 3 * int(x.size()) + 1;
    for (const auto& edge : unique_edges(capsule_.mesh)) {
      const auto a = std::size_t(edge[0]), b = std::size_t(edge[1]);
      edge_node_[{std::min(edge[0], edge[1]), std::max(edge[0], edge[1])}] = next;
      node(next++, 0.5 * (x[a] - half[a] + x[b] - half[b]), file);
      node(next++, 0.5 * (x[a] + half[a] + x[b] + half[b]), file);
    }
  }

  void write_elements(std::FILE* file) {
    for (std::size_t t = 0; t < capsule_.mesh.triangles.size(); ++t) {
      const Triangle& c = capsule_.mesh.triangles[t];
      std::vector<int> nodes{3 * c[0] + 1, 3 * c[1] + 1, 3 * c[2] + 1,
                             3 * c[0] + 3, 3 * c[1] + 3, 3 * c[2] + 3};
      if (quadratic_) {
        for (const int side : {0, 1})
          for (std::size_t k = 0; k < 3; ++k)
            nodes.push_back(edge_node_.at(std::minmax(c[k], c[(k + 1) % 3])) + side);
        for (const int v : c) nodes.push_back(3 * v + 2);
      }
      std::fprintf(file, "%d", int(t) + 1);
      for (const int n : nodes) std::fprintf(file, ",%d", n);
      std::fprintf(file, "\n");
    }
  }

  const Capsule& capsule_;
  bool quadratic_;
  std::map<std::pair<int, int>, int> edge_node_;  // inner; the outer one follows
};

int write(const std::string& path, bool quadratic) {
  const FreeBalloon balloon = the_balloon();
  const Capsule capsule = mesh_of(balloon, kAround);
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) {
    std::fprintf(stderr, "cannot write %s. Check the folder\n", path.c_str());
    return 73;
  }
  Deck(capsule, quadratic).write(balloon, file);
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
  for (std::size_t v = 0; v < capsule.mesh.vertices.size(); ++v) {
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
  const double mean = std::sqrt(squared / double(capsule.mesh.vertices.size()));
  const bool pass = states[0].converged && worst <= 0.01 * largest;
  std::printf(
      "balloon membrane against CalculiX: %zu vertices, largest displacement %.4f mm, difference "
      "%.2f %% of it at most (root mean square %.2f %%), bar 1 %%: %s\n",
      capsule.mesh.vertices.size(), largest, 100.0 * worst / largest, 100.0 * mean / largest,
      pass ? "pass" : "FAIL");
  return pass ? 0 : 1;
}

}  // namespace
}  // namespace angio::simulation

int main(int count, char** arguments) {
  const std::vector<std::string> words(arguments + 1, arguments + count);
  try {
    if (words.size() >= 2 && words[0] == "write")
      return angio::simulation::write(words[1], words.size() < 3 || words[2] == "C3D15");
    if (words.size() == 2 && words[0] == "compare") return angio::simulation::compare(words[1]);
    std::fprintf(stderr,
                 "usage: calculix_membrane write FILE.inp [C3D6|C3D15] | compare FILE.dat\n");
    return 64;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 70;
  }
}
