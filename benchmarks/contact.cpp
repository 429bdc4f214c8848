#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <exception>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "benchmarks/result_table.hpp"
#include "core/units.hpp"
#include "simulation/contact/contact_force.hpp"
#include "simulation/materials/material.hpp"
#include "simulation/newton/membrane_term.hpp"
#include "simulation/run/measure.hpp"
#include "simulation/simulation.hpp"
#include "tests/simulation/folded.hpp"
#include "tests/simulation/gaps.hpp"
#include "tests/simulation/matched.hpp"
#include "tests/simulation/models.hpp"
#include "tests/simulation/pushed.hpp"
#include "tests/simulation/sliding.hpp"
#include "tests/simulation/small_stenosis.hpp"

/// The laws that docs/contact.md explains, a row each:
///
///     contact [friction|motion|newton|throat|phantoms|adhesion|folds|paper|soak=N ...]
///             [--markdown FILE]
///
/// @return 1 if a row misses its bar
namespace angio::simulation {
namespace {

struct Row {
  std::string law;
  double value;
  double bar;
  const char* unit;
  bool at_least = false;  ///< the bar is a floor
};
using Rows = std::vector<Row>;

// Friction
// -----------------------------------------------------------------------------------------

const char* name_of(testing::Touch touch) {
  switch (touch) {
    case testing::Touch::vertex_on_face:
      return "1 + 3";
    case testing::Touch::edge_on_edge:
      return "2 + 2";
    case testing::Touch::face_on_vertex:
      return "3 + 1";
  }
  return "";
}

void add_friction(testing::Touch touch, Rows& rows) {
  using testing::kGravity;
  testing::SlideSetup setup;
  setup.touch = touch;
  const std::string kind = std::string("friction ") + name_of(touch) + ": ";
  const double coulomb = std::atan(setup.mu_static);
  rows.push_back({kind + "angle of repose",
                  100.0 * std::abs(testing::angle_of_repose(setup) / coulomb - 1.0), 1.0, "%"});

  testing::SlideSetup push = setup;
  push.dt = 1e-4;
  push.acceleration = {0.0, 0.0, -kGravity};
  push.velocity = {60.0, 80.0, 0.0};
  testing::Slide pushed(push);
  const Vec3 start = pushed.block();
  pushed.run(0.1);
  const Vec3 slip = pushed.block() - start;
  const double law = 1e4 / (2.0 * setup.mu_kinetic * kGravity);
  rows.push_back({kind + "slip after a push",
                  100.0 * std::abs(std::hypot(slip.x, slip.y) / law - 1.0), 1.0, "%"});

  testing::SlideSetup both = setup;
  both.base_is_free = true;
  both.velocity = {20.0, -10.0, -5.0};
  testing::Slide hit(both);
  const Vec3 before = hit.momentum();
  hit.run(0.05);
  rows.push_back(
      {kind + "momentum, relative", norm(hit.momentum() - before) / norm(before), 1e-6, ""});
}

Rows friction() {
  Rows rows;
  for (const auto touch : {testing::Touch::vertex_on_face, testing::Touch::edge_on_edge,
                           testing::Touch::face_on_vertex})
    add_friction(touch, rows);
  return rows;
}

// Motion in a lumen
// -----------------------------------------------------------------------------------------

Rows motion() {
  constexpr double kDegree = units::kPi / 180.0;
  const SimulationModel loose = testing::loose_balloon(0.875, 1.0);
  const SimulationOptions quiet = testing::led_options(90 * 0.025);
  testing::Screw turn, pull;
  turn.turn = 2.0 * kDegree;
  turn.frames = 90;
  pull.shift = 0.05;
  pull.turn = 1.0 * kDegree;
  pull.frames = 90;
  Rows rows;
  rows.push_back({"turned by 180 degrees, 0.1 mm from the wall: strays from free space by",
                  100.0 * testing::hindrance(loose, quiet, turn), 1.0, "%"});
  rows.push_back({"pulled by 4.5 mm and turned, 0.1 mm from the wall: strays by",
                  100.0 * testing::hindrance(loose, quiet, pull), 1.0, "%"});

  // Pressed against the wall, without friction or film, and turned.
  SimulationOptions pressed = testing::led_options(170 * 0.025);
  pressed.balloon.name = "polyurethane";
  pressed.inflation.peak_pressure_atm = 2.0;
  pressed.inflation.inflate_s = 0.25;
  pressed.contact.friction_static = pressed.contact.friction_kinetic =
      pressed.contact.adhesion_traction_kpa = 0.0;
  turn.from_frame = 11;
  turn.frames = 160;
  const testing::Led led = testing::lead(loose, pressed, turn);
  testing::ContactCheck check;
  for (std::size_t f = 11; f < led.frames.size() - 1; ++f)
    testing::check_contact(loose, led.frames[f], check);
  double angle = 0.0;
  for (std::size_t f = 11; f < led.frames.size() - 1; ++f) {
    const Vec3 &from = led.frames[f - 1].balloon[0], &to = led.frames[f].balloon[0];
    angle += std::atan2(from.x * to.y - from.y * to.x, from.x * to.x + from.y * to.y);
  }
  rows.push_back(
      {"pressed and turned: wall vertices in contact", double(check.active), 1.0, "", true});
  rows.push_back({"pressed and turned: false contacts", double(check.false_ones), 0.0, ""});
  rows.push_back({"pressed and turned: least gap", 1e3 * check.least_gap, 0.5, "um", true});
  rows.push_back({"pressed and turned: angle reached", angle / kDegree, 180.0, "deg", true});
  return rows;
}

// Angioplasty of phantoms
// -----------------------------------------------------------------------------------------

SimulationOptions schedule() {
  SimulationOptions options;
  options.inflation.inflate_s = 1.2;
  options.inflation.hold_s = 0.4;
  options.inflation.deflate_s = 1.0;
  options.inflation.rest_s = 0.1;
  return options;
}

struct Phantom {
  std::string name;
  SimulationModel model;
  SimulationOptions options;
};

// The paper's way: a rubber balloon that starts unfolded.
void make_rubber(Phantom& phantom) {
  phantom.model.balloon_rest = phantom.model.balloon.vertices;
  phantom.options.balloon.name = "polyurethane";
  phantom.options.balloon.wall_mm = 0.03;
  phantom.options.inflation.peak_pressure_atm = 8.0;
}

std::vector<Phantom> phantoms() {
  std::vector<Phantom> list;
  for (const bool eccentric : {false, true})
    for (const double stenosis : {0.3, eccentric ? 0.35 : 0.6}) {
      testing::StenosedTube p = testing::small_stenosis();
      p.eccentric = eccentric;
      p.stenosis = stenosis;
      p.start_radius = 0.35;
      char name[80];
      std::snprintf(name, sizeof name, "%.0f %% %s", 100.0 * stenosis,
                    eccentric ? "on one side" : "around");
      list.push_back({name, testing::make_model(p), schedule()});
    }
  Phantom rubber{"60 % around, rubber", list[1].model, schedule()};
  make_rubber(rubber);
  list.push_back(rubber);
  return list;
}

Rows phantom_rows() {
  Rows rows;
  for (const Phantom& phantom : phantoms()) {
    testing::ContactCheck check;
    double crossings = 0.0;
    simulate(phantom.model, phantom.options, [&](const SimulationFrame& frame) {
      testing::check_contact(phantom.model, frame, check);
      crossings += frame.contact.max_penetration_mm > 0.0 ? 1.0 : 0.0;
    });
    const std::string what = "phantom, " + phantom.name + ": ";
    rows.push_back({what + "frames with crossing triangles", crossings, 0.0, ""});
    rows.push_back({what + "least gap", 1e3 * check.least_gap, 0.5, "um", true});
    rows.push_back({what + "false contacts",
                    check.active > 0 ? 100.0 * check.false_ones / check.active : 100.0, 1.0, "%"});
  }
  return rows;
}

// Mean radius of the ring of the wall that is narrowest at the start.
class Throat {
 public:
  Throat(const std::vector<Vec3>& wall, int around) : around_(std::size_t(around)) {
    double least = 1e9;
    for (std::size_t ring = 0; ring < wall.size(); ring += around_) {
      const double here = mean(wall, ring);
      if (here < least) first_ = ring;
      least = std::min(least, here);
    }
  }
  [[nodiscard]] double radius(const std::vector<Vec3>& wall) const { return mean(wall, first_); }

 private:
  [[nodiscard]] double mean(const std::vector<Vec3>& wall, std::size_t ring) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < around_; ++k) sum += std::hypot(wall[ring + k].x, wall[ring + k].y);
    return sum / double(around_);
  }
  std::size_t around_, first_ = 0;
};

// The throat when the balloon has been held.
double throat(const SimulationModel& model, SimulationOptions options, double* sweeps = nullptr) {
  options.inflation.deflate_s = options.frame_s;
  options.inflation.rest_s = 0.0;
  const Throat ring(model.wall.vertices, 20);
  double radius = 0.0;
  const SimulationSummary summary = simulate(model, options, [&](const SimulationFrame& f) {
    if (f.phase == Phase::hold) radius = ring.radius(f.wall);
  });
  if (sweeps) *sweeps = summary.mean_sweeps;
  return 2.0 * radius;
}

Rows throat_rows() {
  const SimulationModel model = testing::make_model(testing::small_stenosis());
  const SimulationOptions base = schedule();
  double sweeps = 0.0;
  const double reference = throat(model, base, &sweeps);
  Rows rows;
  const auto add = [&](const char* what, const SimulationOptions& options) {
    rows.push_back({std::string("throat after the hold: ") + what,
                    100.0 * std::abs(throat(model, options) / reference - 1.0), 1.0, "%"});
  };
  SimulationOptions changed = base;
  changed.contact.stiffness = 4.0;
  add("penalty x 4", changed);
  changed = base;
  changed.sweeps = int(std::lround(4.0 * sweeps));
  add("sweeps x 4", changed);
  changed = base;
  changed.frame_s = 0.5 * base.frame_s;
  add("time step / 2", changed);
  changed = base;
  changed.contact.distance_mm = 0.5 * base.contact.distance_mm;
  add("contact distance / 2", changed);
  return rows;
}

// Against Newton's method with exact distances
// -----------------------------------------------------------------------------------------

/// Two planes |x| = a as the walls of a flat channel: a point's distance to them is exact, no pair
/// of primitives is searched, no area is shared out.
class ChannelTerm final : public detail::EnergyTerm {
 public:
  ChannelTerm(double half, double reach, double stiffness, std::vector<double> area)
      : half_(half), reach_(reach), stiffness_(stiffness), area_(std::move(area)) {}

  [[nodiscard]] double value(const std::vector<Vec3>& x) const override {
    double sum = 0.0;
    each(x, [&](std::size_t v, double, double gap) {
      sum += gap > 0.0 ? stiffness_ * area_[v] * detail::barrier(gap, reach_).value
                       : std::numeric_limits<double>::infinity();
    });
    return sum;
  }
  void add(const std::vector<Vec3>& x, bool, detail::Assembly& out) const override {
    std::vector<Mat3> blocks(x.size());
    each(x, [&](std::size_t v, double side, double gap) {
      const auto b = detail::barrier(gap, reach_);
      Vec3 slope;
      slope.x = -side * stiffness_ * area_[v] * b.slope;
      out.add_gradient(int(v), slope);
      blocks[v](0, 0) += stiffness_ * area_[v] * b.curvature;
    });
    for (std::size_t v = 0; v < x.size(); ++v) out.add_block(int(v), int(v), blocks[v]);
  }
  /// Sum of the forces on both planes [uN].
  [[nodiscard]] double force(const std::vector<Vec3>& x) const {
    double sum = 0.0;
    each(x, [&](std::size_t v, double, double gap) {
      sum -= stiffness_ * area_[v] * detail::barrier(gap, reach_).slope;
    });
    return sum;
  }

 private:
  template <class Body>
  void each(const std::vector<Vec3>& x, const Body& body) const {
    for (std::size_t v = 0; v < x.size(); ++v)
      for (const double side : {-1.0, 1.0}) body(v, side, half_ - side * x[v].x);
  }
  double half_, reach_, stiffness_;
  std::vector<double> area_;
};

constexpr double kHalf = 0.44, kFarHalf = 0.9;  // of the channel [mm]

SimulationModel flat_channel() {
  testing::StenosedTube p;
  p.start_radius = 0.4;
  p.stenosis = 0.0;
  p.length = 14.0;
  p.lesion_length = 4.0;
  p.balloon_length = 6.0;
  p.balloon_rings = 19;
  p.balloon_around = 20;
  SimulationModel model = testing::make_model(p);
  model.balloon_rest = model.balloon.vertices;
  for (std::size_t v = 0; v < model.balloon_fixed.size(); ++v)  // the end rings too: no free spin
    if (std::abs(model.balloon.vertices[v].z) > 0.44 * p.balloon_length) model.balloon_fixed[v] = 1;
  model.wall = testing::open_tube(p.length, 57, 32, [&](double, double angle) {
    return std::min(kHalf / std::max(1e-9, std::abs(std::cos(angle))),
                    kFarHalf / std::max(1e-9, std::abs(std::sin(angle))));
  });
  model.wall_fixed.assign(model.wall.vertices.size(), 1);
  model.wall_abscissa.clear();
  for (const Vec3& v : model.wall.vertices) model.wall_abscissa.push_back(v.z + 0.5 * p.length);
  model.wall_group.assign(model.wall.vertices.size(), 0);
  return model;
}

SimulationOptions pressed_in_channel() {
  SimulationOptions options;
  options.balloon.name = "polyurethane";
  options.inflation.control = InflationControl::pressure;
  options.inflation.peak_pressure_atm = 2.5;
  options.inflation.inflate_s = 0.5;
  options.inflation.hold_s = 0.5;
  options.inflation.deflate_s = options.frame_s;
  options.inflation.rest_s = 0.0;
  options.tolerance = 1e-4;
  options.contact.distance_mm = 0.01;  // as 0.03 to an artery
  options.contact.friction_static = options.contact.friction_kinetic =
      options.contact.adhesion_traction_kpa = 0.0;
  return options;
}

/// A balloon at rest between the planes.
struct Pressed {
  std::vector<Vec3> balloon;
  double volume = 0.0, force = 0.0;  ///< [mm^3], on both planes [uN]
  bool converged = true;
};

Pressed by_the_step(const SimulationModel& model, const SimulationOptions& options) {
  Pressed result;
  simulate(model, options, [&](const SimulationFrame& f) {
    if (f.phase != Phase::hold) return;
    TriangleMesh wall = model.wall;
    wall.vertices = f.wall;
    const auto areas = vertex_areas(wall);
    result = {f.balloon, f.balloon_volume_mm3};
    for (std::size_t v = 0; v < areas.size(); ++v)
      result.force += units::pascal_from_kilopascal(f.contact_pressure_kpa[v]) * areas[v];
  });
  return result;
}

/// @param areas  that the balloon's vertices stand for [mm^2]
Pressed by_newton(const SimulationModel& model, const SimulationOptions& options,
                  const std::vector<double>& areas) {
  const double pressure = units::pascal_from_atm(options.inflation.peak_pressure_atm);
  const detail::MembraneTerm skin(detail::membrane_law(options.balloon), model.balloon.triangles,
                                  model.balloon_rest, options.balloon.wall_mm);
  const ChannelTerm channel(kHalf, options.contact.distance_mm,
                            detail::barrier_stiffness(pressure, options.contact.distance_mm),
                            areas);
  std::vector<char> fixed;
  for (const char held : model.balloon_fixed) fixed.push_back(held ? detail::kFixedAll : char(0));
  detail::NewtonOptions newton;
  newton.longest_move = 0.02;
  newton.most_iterations = 500;
  Pressed result;
  result.balloon = model.balloon.vertices;
  for (int step = 1; step <= 10; ++step) {
    detail::Enclosure gas;
    gas.triangles = model.balloon.triangles;
    gas.target = 0.1 * step * pressure;
    const auto at = detail::minimize({&skin, &channel}, fixed, result.balloon, newton, gas);
    result.volume = at.volume;
    result.converged = at.converged;
  }
  result.force = channel.force(result.balloon);
  return result;
}

// The farthest point of one shape from the other: sliding along the planes costs next to nothing.
double apart(const std::vector<Vec3>& from, const std::vector<Vec3>& x,
             const std::vector<Triangle>& triangles) {
  double worst = 0.0;
  for (const Vec3& v : from) {
    double here = std::numeric_limits<double>::max();
    for (const Triangle& f : triangles) {
      const Vec3 &a = x[std::size_t(f[0])], &b = x[std::size_t(f[1])], &c = x[std::size_t(f[2])];
      here = std::min(here, testing::length_of(detail::point_triangle_gap(v, a, b, c), v, a, b, c));
    }
    worst = std::max(worst, here);
  }
  return worst;
}

Rows against_newton() {
  const SimulationModel model = flat_channel();
  const SimulationOptions options = pressed_in_channel();
  const Pressed step = by_the_step(model, options);
  TriangleMesh now = model.balloon;
  now.vertices = step.balloon;
  const Pressed newton = by_newton(model, options, vertex_areas(now));
  const double shapes = apart(step.balloon, newton.balloon, model.balloon.triangles);
  return {
      {"newton with exact distances: it has converged", newton.converged ? 1.0 : 0.0, 1.0, "",
       true},
      {"newton: enclosed volume", 100.0 * std::abs(step.volume / newton.volume - 1.0), 1.0, "%"},
      {"newton: force on the wall", 100.0 * std::abs(step.force / newton.force - 1.0), 1.0, "%"},
      {"newton: distance of the shapes, of the channel's half width", 100.0 * shapes / kHalf, 1.0,
       "%"}};
}

// Adhesion, and the paper's contact
// -----------------------------------------------------------------------------------------

SimulationOptions touch_and_part() {
  SimulationOptions options;
  options.balloon.name = "polyurethane";
  options.backend = Backend::cpu;
  options.inflation.control = InflationControl::pressure;
  options.inflation.peak_pressure_atm = 2.0;
  options.inflation.inflate_s = options.inflation.deflate_s = 0.75;
  options.inflation.hold_s = options.inflation.rest_s = 0.1;
  return options;
}

struct Curves {
  double untouched = 0.0;  ///< the greatest of both before the first touch [mm]
  double friction = 0.0, pressed = 0.0, parting = 0.0, last = 0.0;  ///< [mm]
  double depth = 0.0, widest = 0.0;                                 ///< [mm]
};

Curves curves(const SimulationModel& model, const SimulationOptions& options) {
  Curves c;
  bool touched = false;
  simulate(model, options, [&](const SimulationFrame& f) {
    touched = touched || f.contact.count > 0;
    const double viscous = f.contact.viscous_delta_mm;
    if (!touched) c.untouched = std::max({c.untouched, viscous, f.contact.friction_delta_mm});
    c.friction = std::max(c.friction, f.contact.friction_delta_mm);
    if (f.phase == Phase::hold) c.pressed = viscous;
    if (f.phase == Phase::deflate) c.parting = std::max(c.parting, viscous);
    c.last = viscous;
    c.depth = std::max(c.depth, f.contact.max_penetration_mm);
    c.widest = std::max(c.widest, f.balloon_diameter_mm);
  });
  return c;
}

Rows adhesion() {
  const SimulationModel model = testing::matched_model(0.5, 0.62);
  const Curves c = curves(model, touch_and_part());
  SimulationOptions strong = touch_and_part();
  strong.contact.adhesion_traction_kpa = 25.0;
  const Curves s = curves(model, strong);
  const Curves near = curves(testing::matched_model(0.565, 0.62), touch_and_part());
  return {{"film: pull before the first touch", c.untouched, 0.0, "mm"},
          {"film: pull while pressed, over that while they part", c.pressed / c.parting, 0.5, ""},
          {"film: pull at the end, over the greatest", c.last / c.parting, 0.5, ""},
          {"film, balloon that stays near: pull at the end", near.last, 1e-4, "mm", true},
          {"film x 10: pull while they part, over film x 1", s.parting / c.parting, 2.0, "", true}};
}

// Nothing here is asked of the paper's contact: the numbers show what it is.
Rows paper() {
  const SimulationModel model = testing::matched_model(0.5, 0.62);
  SimulationOptions options = touch_and_part();
  options.contact.model = ContactModel::paper;
  const Curves c = curves(model, options);
  options.sweeps = 80;
  const Curves more = curves(model, options);
  return {{"paper: deepest crossing (no bar)", 1e3 * c.depth, 0.0, "um", true},
          {"paper: friction with sweeps x 4, over sweeps x 1 (no bar)", more.friction / c.friction,
           0.0, "", true},
          {"paper: viscous, while they part (no bar)", c.parting, 0.0, "mm", true},
          {"paper: viscous, sweeps x 4 over sweeps x 1 (no bar)", more.parting / c.parting, 0.0, "",
           true}};
}

// The balloon against itself
// -----------------------------------------------------------------------------------------

struct Unfolding {
  int crossings = 0;         ///< of the skin with itself, in all frames
  double diameter_mm = 0.0;  ///< at the peak pressure
  double open = 0.0;         ///< share of the frames
  double seconds = 0.0;      ///< of the processor
};

Unfolding unfold(const SimulationModel& model, bool self_contact) {
  SimulationOptions options;
  options.backend = Backend::cpu;
  options.contact.self_contact = self_contact;
  options.inflation.inflate_s = 1.0;
  options.inflation.hold_s = options.inflation.rest_s = 0.1;
  options.inflation.deflate_s = 0.5;
  Unfolding result;
  std::vector<std::vector<Vec3>> frames;
  const std::clock_t begin = std::clock();
  const SimulationSummary summary = simulate(
      model, options, [&](const SimulationFrame& frame) { frames.push_back(frame.balloon); });
  result.seconds = double(std::clock() - begin) / CLOCKS_PER_SEC;
  for (const auto& x : frames)
    result.crossings += detail::self_crossing_count(model.balloon.triangles, x);
  result.diameter_mm = summary.peak_diameter_mm;
  result.open = double(summary.open_frames) / double(frames.size());
  return result;
}

void add_folds(const char* name, const testing::FoldedBalloon& balloon, Rows& rows) {
  const SimulationModel model = testing::folded_model(balloon);
  const Unfolding with = unfold(model, true), without = unfold(model, false);
  const std::string part = std::string("folds, ") + name + ": ";
  rows.push_back({part + "crossings of the skin with itself", double(with.crossings), 0.0, ""});
  rows.push_back({part + "diameter at the peak, against no self-contact",
                  100.0 * std::abs(with.diameter_mm / without.diameter_mm - 1.0), 0.5, "%"});
  rows.push_back({part + "crossings without (no bar)", double(without.crossings), 0.0, "", true});
  rows.push_back(
      {part + "time over that without (no bar)", with.seconds / without.seconds, 0.0, "", true});
  rows.push_back({part + "frames left open (no bar)", 100.0 * with.open, 0.0, "%", true});
  rows.push_back(
      {part + "frames left open without (no bar)", 100.0 * without.open, 0.0, "%", true});
}

Rows folds() {
  Rows rows;
  add_folds("loose", {}, rows);
  testing::FoldedBalloon tight;
  tight.pitch = 0.03;
  tight.wrap = 2.2;
  tight.outer_edges = 16;
  tight.inner_edges = 8;
  add_folds("tight", tight, rows);
  return rows;
}

// Soak
// -----------------------------------------------------------------------------------------

constexpr double kMegabyte = 1048576.0;

struct Memory {
  double allocated = 0.0, resident = 0.0;  ///< [MB]
};

// What is freed, but kept for the next allocation, is given back first: how much that is changes
// from run to run.
Memory memory_now() {
  malloc_trim(0);
  const struct mallinfo2 heap = mallinfo2();
  long pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return {double(heap.uordblks + heap.hblkhd) / kMegabyte,
          double(resident) * double(sysconf(_SC_PAGESIZE)) / kMegabyte};
}

// FNV-1a over the bytes of all frames.
std::size_t fingerprint(const SimulationModel& model, const SimulationOptions& options) {
  std::size_t hash = 1469598103934665603ULL;
  const auto add = [&](const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211ULL;
  };
  simulate(model, options, [&](const SimulationFrame& f) {
    add(f.balloon.data(), f.balloon.size() * sizeof(Vec3));
    add(f.wall.data(), f.wall.size() * sizeof(Vec3));
    add(&f.contact.viscous_delta_mm, sizeof(double));
  });
  return hash;
}

Rows soak(int count) {
  testing::StenosedTube p = testing::small_stenosis();
  p.balloon_rings = 13;
  p.balloon_around = 12;
  p.wall_rings = 31;
  p.wall_around = 14;
  const SimulationModel model = testing::make_model(p);
  SimulationOptions options = schedule();
  options.inflation.inflate_s = 0.3;
  options.inflation.hold_s = options.inflation.rest_s = 0.025;
  options.inflation.deflate_s = 0.2;
  const std::size_t first = fingerprint(model, options);
  Memory before;
  int different = 0;
  for (int i = 1; i < count; ++i) {
    different += fingerprint(model, options) == first ? 0 : 1;
    if (i == std::min(10, count / 2)) before = memory_now();
  }
  const Memory after = memory_now();
  const std::string name = "soak, " + std::to_string(count) + " inflations: ";
  return {{name + "runs with other bytes", double(different), 0.0, ""},
          {name + "growth of allocated memory after the first ones",
           after.allocated - before.allocated, 0.01, "MB"},
          {name + "growth of resident memory after the first ones",
           after.resident - before.resident, 1.0, "MB"}};
}

// ------------------------------------------------------------------------------------------

int print(const Rows& rows, benchmarks::ResultTable& results) {
  using benchmarks::formatted;
  int failed = 0;
  for (const Row& row : rows) {
    const bool good = row.at_least ? row.value >= row.bar : row.value <= row.bar;
    failed += good ? 0 : 1;
    const bool has_bar = std::isfinite(row.bar) && std::abs(row.bar) < 1e30;
    results.row(
        {row.law,
         has_bar ? formatted("%s %.3g %s", row.at_least ? "at least" : "at most", row.bar, row.unit)
                 : std::string(),
         formatted("%.4g %s%s", row.value, row.unit, good ? "" : ", missed")});
  }
  return failed;
}

int run(const std::vector<std::string>& asked, benchmarks::ResultTable& results) {
  int soak_count = 10;
  const std::vector<std::pair<std::string, std::function<Rows()>>> groups = {
      {"friction", friction},
      {"motion", motion},
      {"newton", against_newton},
      {"throat", throat_rows},
      {"phantoms", phantom_rows},
      {"adhesion", adhesion},
      {"folds", folds},
      {"paper", paper},
      {"soak", [&] { return soak(soak_count); }},
  };
  std::vector<std::string> names;
  for (const std::string& a : asked) {
    const bool count = a.rfind("soak=", 0) == 0;
    if (count) soak_count = std::max(2, std::atoi(a.c_str() + 5));
    names.push_back(count ? "soak" : a);
    if (std::none_of(groups.begin(), groups.end(),
                     [&](const auto& g) { return g.first == names.back(); })) {
      std::fprintf(
          stderr,
          "no group \"%s\". Use friction, motion, newton, throat, phantoms, adhesion, folds, "
          "paper or soak=N\n",
          a.c_str());
      return 64;
    }
  }
  int failed = 0;
  for (const auto& [name, rows] : groups) {
    if (!names.empty() && std::find(names.begin(), names.end(), name) == names.end()) continue;
    results.section(name);
    results.columns({"law", "bar", "value"});
    failed += print(rows(), results);
  }
  return failed == 0 ? 0 : 1;
}

}  // namespace
}  // namespace angio::simulation

int main(int count, char** arguments) {
  try {
    angio::benchmarks::ResultTable results("Contact between balloon and vessel", count, arguments);
    const int code = angio::simulation::run({arguments + 1, arguments + count}, results);
    results.write();
    return code;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 70;
  }
}
