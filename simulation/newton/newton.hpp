#pragma once

#include <array>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/triangle_mesh.hpp"
#include "core/vec3.hpp"

/// Sparse Newton's method on a sum of energies: the reference that other solvers are held against.
namespace angio::simulation::detail {

/// What of a vertex does not move: a sum of these.
inline constexpr char kFixedAll = 1, kFixedX = 2, kFixedY = 4, kFixedZ = 8;

/// Gradient and Hessian of the energies while they are being summed.
class Assembly {
 public:
  /// Adds dE/dx_v [uN].
  void add_gradient(int v, const Vec3& slope) { gradient_[std::size_t(v)] += slope; }
  /// Adds d2E/dx_i dx_j^T [uN/mm], once for each unordered pair: the block (j, i) is its transpose.
  void add_block(int i, int j, const Mat3& block);
  /// Is the Hessian asked for, too? If not, blocks are ignored.
  [[nodiscard]] bool wants_blocks() const { return wants_blocks_; }

 private:
  friend class NewtonSystem;
  struct Block {
    int i, j;
    Mat3 value;
  };
  std::vector<Vec3> gradient_;
  std::vector<Block> blocks_;
  bool wants_blocks_ = true;
};

/// One term of the energy that is minimised.
///
/// A term adds the same blocks (i, j), in the same order, whenever it is asked: their places in the
/// sparse matrix are then found once.
class EnergyTerm {
 public:
  EnergyTerm() = default;
  EnergyTerm(const EnergyTerm&) = default;
  EnergyTerm& operator=(const EnergyTerm&) = default;
  virtual ~EnergyTerm() = default;

  /// The energy [nJ]; not finite where x is not admissible (the line search then steps back).
  [[nodiscard]] virtual double value(const std::vector<Vec3>& x) const = 0;

  /// Adds gradient and Hessian, which need not be computed unless out.wants_blocks().
  ///
  /// @param clamp  leave out the negative eigenvalues of each element's Hessian, where it can be
  ///               done: asked for when the exact sum is not positive definite
  virtual void add(const std::vector<Vec3>& x, bool clamp, Assembly& out) const = 0;
};

/// A closed surface that holds gas or liquid.
struct Enclosure {
  enum class Control {
    pressure,  ///< `target` is the pressure above the outside [Pa]
    volume,    ///< `target` is the enclosed volume [mm^3]; the pressure is its multiplier
    gas,       ///< `target` is p V with p absolute [Pa mm^3]
  };
  std::vector<Triangle> triangles;  ///< normals outward; empty: nothing is enclosed
  Control control = Control::pressure;
  double target = 0.0;
  double outside = 0.0;         ///< absolute pressure around [Pa]; for `gas`
  double pressure_start = 0.0;  ///< first guess of the pressure above the outside [Pa]
};

struct NewtonOptions {
  int most_iterations = 100;
  /// Of the unbalanced force, relative to the forces that balance (NewtonResult::residual).
  double tolerance = 1e-9;
  double reduction = 0.0;  ///< or relative to what that was at the start
  /// The last factorisation serves on, also from a Minimizer's run to the next, while each of its
  /// steps leaves at most this share of the unbalanced force, [0, 1); 0: each step has its own.
  /// Under volume or gas control each has.
  double reuse = 0.0;
  /// The longest move of a vertex in one iteration [mm], > 0.
  double longest_move = std::numeric_limits<double>::infinity();
};

struct NewtonResult {
  int iterations = 0;
  /// |unbalanced force| over the root of the sum of the terms' squared forces.
  double residual = 0.0;
  bool converged = false;
  double pressure = 0.0;  ///< in the enclosure, above the outside [Pa]
  double volume = 0.0;    ///< enclosed [mm^3]
  double energy = 0.0;    ///< of the terms, without the enclosure [nJ]
};

/// Minimises the sum of the terms, less the work of the enclosure's pressure, over the free
/// vertices, by Newton's method with the exact Hessian and a line search.
///
///     pressure  min E - p V                      (H - p V'') dx = -(E' - p V')
///     gas       min E - Q ln V + p_out V         the same with dp V + p V' . dx = Q - p_abs V
///     volume    min E subject to V = V_target    the same with V' . dx = V_target - V
///
/// V'' is the exact, symmetric second derivative of a closed surface's volume. The last two couple
/// all vertices through one number, by a Schur complement (gas: Sherman-Morrison), so that the
/// matrix stays sparse; they go past the limit point of a pressure-volume curve, where H - p V''
/// has one negative eigenvalue. Where the matrix does not describe a minimum (seen in the signs of
/// its LDL^T), the elements' Hessians are clamped and a multiple of the diagonal is added.
/// The same input gives the same bits on any number of threads.
///
/// Source: Nocedal, Wright, "Numerical Optimization", 2nd ed., algorithms 3.2 and 18.3 (l1 merit
/// function), theorem 16.3 (inertia).
///
/// @param fixed  sums of kFixedAll, kFixedX, kFixedY, kFixedZ, shape [vertex]; rigid motion must
///               be excluded
/// @param x      start and result [mm], shape [vertex]
NewtonResult minimize(const std::vector<const EnergyTerm*>& terms, const std::vector<char>& fixed,
                      std::vector<Vec3>& x, const NewtonOptions& options,
                      const Enclosure& enclosure = {});

/// Minimises several times, while the terms' own constants or the enclosure's target change: the
/// matrix's pattern and ordering are found once.
class Minimizer {
 public:
  /// The terms and the enclosure are kept by reference.
  Minimizer(std::vector<const EnergyTerm*> terms, const std::vector<char>& fixed,
            const NewtonOptions& options, const Enclosure& enclosure);
  ~Minimizer();
  Minimizer(const Minimizer&) = delete;
  Minimizer& operator=(const Minimizer&) = delete;

  /// As minimize().
  NewtonResult run(std::vector<Vec3>& x);

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

/// m / (2 dt^2) |x - x_inertial|^2 with x_inertial = x_before + dt velocity: implicit Euler.
class InertiaTerm final : public EnergyTerm {
 public:
  /// @param mass  [g], shape [vertex]
  InertiaTerm(std::vector<double> mass, std::vector<Vec3> x_inertial, double dt)
      : mass_(std::move(mass)), x_inertial_(std::move(x_inertial)), dt_(dt) {}
  [[nodiscard]] double value(const std::vector<Vec3>& x) const override;
  void add(const std::vector<Vec3>& x, bool clamp, Assembly& out) const override;

 private:
  std::vector<double> mass_;
  std::vector<Vec3> x_inertial_;
  double dt_;
};

}  // namespace angio::simulation::detail
