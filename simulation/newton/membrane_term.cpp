#include "simulation/newton/membrane_term.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <utility>

namespace angio::simulation::detail {
namespace {

// Leaves out the negative eigenvalues of an element's Hessian by its two edges.
void clamp_element(EdgeTerm<double>& term) {
  Eigen::Matrix<double, 6, 6> h;
  for (int e = 0; e < 2; ++e)
    for (int f = 0; f < 2; ++f)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) h(3 * e + i, 3 * f + j) = term.hessian[e][f](i, j);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(h);
  if (eigen.eigenvalues()(0) >= 0.0) return;
  h = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
      eigen.eigenvectors().transpose();
  for (int e = 0; e < 2; ++e)
    for (int f = 0; f < 2; ++f)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) term.hessian[e][f](i, j) = h(3 * e + i, 3 * f + j);
}

}  // namespace

MembraneTerm::MembraneTerm(MembraneLaw<double> law, std::vector<Triangle> triangles,
                           const std::vector<Vec3>& rest, double thickness,
                           const std::vector<Vec3>& fibre)
    : law_(law), triangles_(std::move(triangles)) {
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& [v, n, m] = triangles_[t];
    metric_.push_back(corner_metric(rest[std::size_t(v)], rest[std::size_t(n)],
                                    rest[std::size_t(m)], thickness,
                                    fibre.empty() ? Vec3{} : fibre[t]));
  }
}

double MembraneTerm::value(const std::vector<Vec3>& x) const {
  double sum = 0.0;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& [v, n, m] = triangles_[t];
    const Vec3& middle = x[std::size_t(n)];
    sum += metric_[t].volume *
           membrane_energy(law_, metric_[t], x[std::size_t(v)] - middle, x[std::size_t(m)] - middle)
               .value;
  }
  return sum;
}

MembraneStress<double> MembraneTerm::stress(std::size_t triangle,
                                            const std::vector<Vec3>& x) const {
  const auto& [v, n, m] = triangles_[triangle];
  const Vec3& middle = x[std::size_t(n)];
  return membrane_stress(law_, metric_[triangle], x[std::size_t(v)] - middle,
                         x[std::size_t(m)] - middle);
}

void MembraneTerm::add(const std::vector<Vec3>& x, bool clamp, Assembly& out) const {
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& [v, n, m] = triangles_[t];
    const Vec3 e1 = x[std::size_t(v)] - x[std::size_t(n)];
    const Vec3 e2 = x[std::size_t(m)] - x[std::size_t(n)];
    EdgeTerm<double> term =
        membrane_element(metric_[t], membrane_energy(law_, metric_[t], e1, e2), e1, e2);
    if (clamp) clamp_element(term);
    out.add_gradient(v, term.gradient[0]);
    out.add_gradient(m, term.gradient[1]);
    out.add_gradient(n, -(term.gradient[0] + term.gradient[1]));
    // x_n enters by -(e1 + e2).
    const Mat3 by_first = -1.0 * (term.hessian[0][0] + term.hessian[0][1]);
    const Mat3 by_second = -1.0 * (term.hessian[1][0] + term.hessian[1][1]);
    out.add_block(v, v, term.hessian[0][0]);
    out.add_block(v, m, term.hessian[0][1]);
    out.add_block(m, m, term.hessian[1][1]);
    out.add_block(v, n, by_first);
    out.add_block(m, n, by_second);
    out.add_block(n, n, -1.0 * (by_first + by_second));
  }
}

}  // namespace angio::simulation::detail
