#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "simulation/step/pair_forces.hpp"
#include "simulation/step/team.hpp"

/// A block on a base, touching by one pair, stepped by the solver's own contact functions.
namespace angio::simulation::testing {

/// How the block touches the base: the air tet's kinds.
enum class Touch { vertex_on_face, edge_on_edge, face_on_vertex };

inline constexpr double kGravity = 9810.0;  // [mm/s^2]

struct SlideSetup {
  Touch touch = Touch::vertex_on_face;
  double mu_static = 0.2, mu_kinetic = 0.15;
  double dt = 1e-3;   ///< [s]
  Vec3 acceleration;  ///< of the block [mm/s^2]; the base lies in z = 0
  Vec3 velocity;      ///< of the block at the start [mm/s]
  bool base_is_free = false;
};

/// Block and base move without turning. Implicit Euler, each step solved to rounding.
class Slide {
 public:
  explicit Slide(const SlideSetup& setup) : setup_(setup) {
    const double high = 0.5 * kReach, l = 50.0;
    switch (setup.touch) {
      case Touch::vertex_on_face:
        x_ = {{0, 0, high}, {l, 0, 0}, {-0.5 * l, 0.8 * l, 0}, {-0.4 * l, -0.9 * l, 0}};
        block_ = {true, false, false, false};
        break;
      case Touch::edge_on_edge:
        x_ = {{-l, -0.3 * l, high}, {l, 0.3 * l, high}, {0.2 * l, -l, 0}, {-0.2 * l, l, 0}};
        block_ = {true, true, false, false};
        break;
      case Touch::face_on_vertex:
        x_ = {{0, 0, 0}, {l, 0, high}, {-0.5 * l, 0.8 * l, high}, {-0.4 * l, -0.9 * l, high}};
        block_ = {false, true, true, true};
        break;
    }
    pair_.edges = setup.touch == Touch::edge_on_edge;
    for (int i = 0; i < 4; ++i) pair_.vertex[i] = i;
    pair_.area = 1.0;
    pair_.distance = kReach;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto side = std::count(block_.begin(), block_.end(), block_[i]);
      mass_[i] = kMass / double(side);
      velocity_[i] = block_[i] ? setup.velocity : Vec3{};
      refs_[i] = {0, int(i)};
    }
    view_.motion.dt = setup.dt;
    view_.contact.law.distance = kReach;
    view_.contact.law.stiffness = detail::barrier_stiffness(kMass * kGravity, kReach);
    view_.contact.law.friction = {setup.mu_static, setup.mu_kinetic, 0.02 * setup.dt};
    view_.contact.near.moved = moved_.data();
    view_.motion.x = x_.data();
    view_.motion.x_before = before_.data();
    view_.motion.x_inertial = inertial_.data();
    view_.motion.mass = mass_.data();
    view_.contact.near.pairs = &pair_;
    view_.contact.candidates.count = 1;
    view_.contact.candidates.ref_begin = ref_begin_.data();
    view_.contact.near.ref_end = ref_begin_.data() + 1;
    view_.contact.near.refs = refs_.data();
  }

  Slide(const Slide&) = delete;
  Slide& operator=(const Slide&) = delete;

  void step() {
    std::copy(x_.begin(), x_.end(), before_.begin());
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3 pull = block_[i] ? setup_.acceleration : Vec3{};
      inertial_[i] = x_[i] + setup_.dt * (velocity_[i] + setup_.dt * pull);
    }
    for (int iteration = 0; iteration < 400; ++iteration) {
      double moved = move(true);
      if (setup_.base_is_free) moved = std::max(moved, move(false));
      if (moved < 1e-13) break;
    }
    for (std::size_t i = 0; i < 4; ++i) velocity_[i] = (x_[i] - before_[i]) / setup_.dt;
  }

  void run(double seconds) {
    for (int i = 0; i < int(std::lround(seconds / setup_.dt)); ++i) step();
  }

  [[nodiscard]] Vec3 block() const { return x_[std::size_t(first(true))]; }
  [[nodiscard]] Vec3 speed() const { return velocity_[std::size_t(first(true))]; }
  [[nodiscard]] Vec3 momentum() const {
    Vec3 sum;
    for (std::size_t i = 0; i < 4; ++i) sum += mass_[i] * velocity_[i];
    return sum;
  }

  static constexpr double kReach = 0.03;  ///< contact distance [mm]
  static constexpr double kMass = 1e-3;   ///< of block and of base [g]

 private:
  [[nodiscard]] int first(bool block) const {
    for (int i = 0; i < 4; ++i)
      if (block_[std::size_t(i)] == block) return i;
    return -1;
  }

  // A Newton step of block or base as a whole. Returns how far it went.
  double move(bool block) {
    detail::refresh_pair(view_, 0);
    detail::VertexForces<double> inertia, contact;
    double weights = 0.0;
    for (int i = 0; i < 4; ++i) {
      if (block_[std::size_t(i)] != block) continue;
      detail::add_inertia(view_, i, inertia);
      detail::add_contact(view_, i, detail::OneLane{}, contact);
      weights += pair_.weights.w[i] * pair_.weights.w[i];
    }
    // Moved as one, the side's weights sum to 1 where single vertices count by their squares.
    Vec3 by = detail::inverse_block(inertia.hessian + (1.0 / weights) * contact.hessian) *
              (inertia.force + contact.force);
    const double towards =
        (block == block_[0] ? -1.0 : 1.0) * dot(pair_.direction, by);  // of the gap
    if (towards > 0.45 * pair_.gap) by *= 0.45 * pair_.gap / towards;
    for (std::size_t i = 0; i < 4; ++i)
      if (block_[i] == block) x_[i] += by;
    return norm(by);
  }

  SlideSetup setup_;
  std::vector<Vec3> x_, before_ = std::vector<Vec3>(4), inertial_ = before_, velocity_ = before_;
  std::array<double, 4> mass_{};
  std::array<bool, 4> block_{};
  detail::NearPair<double> pair_;
  std::array<double, 4> moved_{};  // as if the pair had just been found
  std::array<int, 5> ref_begin_{0, 1, 2, 3, 4};
  std::array<detail::ContactRef, 4> refs_;
  detail::StepView<double> view_;
};

/// Gravity on an incline whose steepest line is x.
inline Vec3 on_incline(double angle) {
  return {kGravity * std::sin(angle), 0.0, -kGravity * std::cos(angle)};
}

/// The steepest incline [rad] on which the block stays: found by bisection.
inline double angle_of_repose(SlideSetup setup) {
  double low = 0.0, high = 0.6;
  while (high - low > 5e-4) {
    const double angle = 0.5 * (low + high);
    setup.acceleration = on_incline(angle);
    Slide slide(setup);
    const double start = slide.block().x;
    slide.run(0.2);
    (slide.block().x - start > 0.05 ? high : low) = angle;
  }
  return 0.5 * (low + high);
}

}  // namespace angio::simulation::testing
