#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <exception>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "benchmarks/contact_rows.hpp"
#include "core/units.hpp"
#include "simulation/run/measure.hpp"
#include "simulation/simulation.hpp"
#include "testing/result_table.hpp"
#include "testing/simulation/folded.hpp"
#include "testing/simulation/gaps.hpp"
#include "testing/simulation/matched.hpp"
#include "testing/simulation/models.hpp"
#include "testing/simulation/pushed.hpp"
#include "testing/simulation/sliding.hpp"
#include "testing/simulation/small_stenosis.hpp"

/// The laws that docs/contact.md explains, a row each:
///
///     contact [friction|motion|newton|throat|phantoms|adhesion|folds|paper|soak=N ...]
///             [--markdown FILE]
///
/// @return 1 if a row misses its bar
namespace angio::simulation {

SimulationOptions schedule() {
  SimulationOptions options;
  options.inflation.inflate_s = 1.2;
  options.inflation.hold_s = 0.4;
  options.inflation.deflate_s = 1.0;
  options.inflation.rest_s = 0.1;
  return options;
}

namespace {

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

// The balloon against itself
// -----------------------------------------------------------------------------------------

struct Unfolding {
  int crossings = 0;         ///< of the membrane with itself, in all frames
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
  rows.push_back({part + "crossings of the membrane with itself", double(with.crossings), 0.0, ""});
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
