#include "simulation/newton/wall_terms.hpp"

#include <Eigen/Eigenvalues>

#include "core/parallel.hpp"

namespace angio::simulation::detail {
namespace {

using Matrix18 = Eigen::Matrix<double, 18, 18>;

// Sets the negative eigenvalues of a wedge's Hessian to zero.
void clamp_wedge(Mat3 (*hessian)[6]) {
  Matrix18 h;
  for (int a = 0; a < 18; ++a)
    for (int b = 0; b < 18; ++b) h(a, b) = hessian[a / 3][b / 3](a % 3, b % 3);
  const Eigen::SelfAdjointEigenSolver<Matrix18> eigen(h);
  if (eigen.eigenvalues()[0] >= 0.0) return;
  h = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
      eigen.eigenvectors().transpose();
  for (int a = 0; a < 18; ++a)
    for (int b = 0; b < 18; ++b) hessian[a / 3][b / 3](a % 3, b % 3) = h(a, b);
}

// What a patch gives, kept until it is its turn.
struct Share {
  struct Block {
    int i, j;
    Mat3 value;
  };
  std::vector<std::pair<int, Vec3>> gradient;
  std::vector<Block> blocks;
  void add_gradient(int v, const Vec3& slope) { gradient.emplace_back(v, slope); }
  void add_block(int i, int j, const Mat3& value) { blocks.push_back({i, j, value}); }
};

}  // namespace

double SolidTerm::value(const std::vector<Vec3>& x) const {
  const SolidView<double> view = model_.view(x.data());
  std::vector<double> energy(model_.patch_volume.size());
  parallel_for(model_.patch_count(), [&](std::ptrdiff_t index) {
    const int patch = static_cast<int>(index);
    double sum =
        model_.patch_volume[static_cast<std::size_t>(index)] * patch_energy(view, patch).value;
    for (int m = view.patch_begin[patch]; m < view.patch_begin[patch + 1]; ++m)
      sum += wedge_energy(view.wedge(view.patch_wedges[m]),
                          corners_of(model_, view.patch_wedges[m], x).data());
    energy[static_cast<std::size_t>(index)] = sum;
  });
  double sum = 0.0;
  for (const double e : energy) sum += e;
  return sum;
}

void SolidTerm::add(const std::vector<Vec3>& x, bool clamp, Assembly& out) const {
  const SolidView<double> view = model_.view(x.data());
  std::vector<Share> shares(model_.patch_volume.size());
  parallel_for(model_.patch_count(), [&](std::ptrdiff_t patch) {
    Share& share = shares[static_cast<std::size_t>(patch)];
    if (!out.wants_blocks()) {
      add_patch_gradient(view, static_cast<int>(patch), share);
      return;
    }
    add_patch(view, static_cast<int>(patch), share, [clamp](Mat3(*hessian)[6]) {
      if (clamp) clamp_wedge(hessian);
    });
  });
  for (const Share& share : shares) {
    for (const auto& [v, slope] : share.gradient) out.add_gradient(v, slope);
    for (const Share::Block& block : share.blocks) out.add_block(block.i, block.j, block.value);
  }
}

double FoundationTerm::value(const std::vector<Vec3>& x) const {
  double sum = 0.0;
  for (std::size_t v = 0; v < x.size(); ++v)
    sum += 0.5 * stiffness_[v] * norm_squared(x[v] - place_[v]);
  return sum;
}

void FoundationTerm::add(const std::vector<Vec3>& x, bool /*clamp*/, Assembly& out) const {
  for (std::size_t v = 0; v < x.size(); ++v) {
    if (!(stiffness_[v] > 0.0)) continue;
    out.add_gradient(static_cast<int>(v), stiffness_[v] * (x[v] - place_[v]));
    out.add_block(static_cast<int>(v), static_cast<int>(v), stiffness_[v] * Mat3::identity());
  }
}

Enclosure lumen_enclosure(const LayeredWall& wall, double pressure) {
  Enclosure out;
  out.triangles = wall.lumen_triangles;
  for (const std::vector<int>& rim : boundary_loops({wall.vertices, wall.lumen_triangles}))
    for (std::size_t i = 1; i + 1 < rim.size(); ++i)
      out.triangles.push_back({rim[0], rim[i], rim[i + 1]});
  out.control = Enclosure::Control::pressure;
  out.target = pressure;
  return out;
}

}  // namespace angio::simulation::detail
