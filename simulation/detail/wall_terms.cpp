#include "simulation/detail/wall_terms.hpp"

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

struct Share {
  Vec3 gradient[6];
  Mat3 hessian[6][6];
};

}  // namespace

double SolidTerm::value(const std::vector<Vec3>& x) const {
  std::vector<double> energy(model_.region.size());
  parallel_for(model_.wedge_count(), [&](std::ptrdiff_t w) {
    const std::array<Vec3, 6> corners = corners_of(model_, static_cast<int>(w), x);
    energy[static_cast<std::size_t>(w)] =
        wedge_energy(model_.view(nullptr).wedge(static_cast<int>(w)), corners.data());
  });
  double sum = 0.0;
  for (const double e : energy) sum += e;
  return sum;
}

void SolidTerm::add(const std::vector<Vec3>& x, bool clamp, Assembly& out) const {
  std::vector<Share> shares(model_.region.size());
  parallel_for(model_.wedge_count(), [&](std::ptrdiff_t w) {
    const std::array<Vec3, 6> corners = corners_of(model_, static_cast<int>(w), x);
    const SolidWedge<double> wedge = model_.view(nullptr).wedge(static_cast<int>(w));
    Share& share = shares[static_cast<std::size_t>(w)];
    wedge_gradient(wedge, corners.data(), share.gradient);
    wedge_hessian(wedge, corners.data(), share.hessian);
    if (clamp) clamp_wedge(share.hessian);
  });
  for (std::size_t w = 0; w < shares.size(); ++w)
    for (std::size_t a = 0; a < 6; ++a) {
      out.add_gradient(model_.corners[6 * w + a], shares[w].gradient[a]);
      for (std::size_t b = a; b < 6; ++b)
        out.add_block(model_.corners[6 * w + a], model_.corners[6 * w + b],
                      shares[w].hessian[a][b]);
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
