#include <gtest/gtest.h>

#include <limits>

#include "core/error.hpp"
#include "simulation/bodies/scene.hpp"
#include "simulation/newton/equilibria.hpp"
#include "testing/simulation/models.hpp"

/// Models that cannot be simulated are refused with the element that is wrong.
namespace angio::simulation {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

SimulationModel good() {
  testing::StenosedTube p;
  p.balloon_rings = 7;
  p.balloon_around = 8;
  p.wall_rings = 9;
  p.wall_around = 10;
  return testing::make_model(p);
}

// What simulate() says; find_equilibria() must say the same of a balloon.
template <class Change>
std::string said_of(const Change& change, bool of_balloon = true,
                    const SimulationOptions& options = {}) {
  SimulationModel model = good();
  change(model);
  const auto message = [](const auto& run) -> std::string {
    try {
      run();
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing";
  };
  std::string said = message([&] { simulate(model, options, {}); });
  if (of_balloon) {
    EXPECT_EQ(message([&] { detail::find_equilibria(model, options, {}); }), said);
  }
  EXPECT_EQ(said.find('\n'), std::string::npos);
  return said;
}

#define EXPECT_SAYS(said, part) EXPECT_NE((said).find(part), std::string::npos) << (said)

TEST(Scene, AGoodModelIsTaken) {
  EXPECT_NO_THROW(detail::find_equilibria(good(), {}, {}));
  EXPECT_NO_THROW(detail::make_scene(good(), {}));
}

TEST(Scene, RefusesABalloonThatIsOpenInsideOutOrInPieces) {
  EXPECT_SAYS(said_of([](auto& m) { m.balloon.triangles.erase(m.balloon.triangles.begin() + 3); }),
              "the balloon is open at the edge between vertices");
  EXPECT_SAYS(said_of([](auto& m) {
                for (Triangle& t : m.balloon.triangles) std::swap(t[0], t[1]);
              }),
              "the balloon is inside out");
  EXPECT_SAYS(
      said_of([](auto& m) { std::swap(m.balloon.triangles[5][0], m.balloon.triangles[5][1]); }),
      "triangles");
  EXPECT_SAYS(said_of([](auto& m) {
                for (Vec3& p : m.balloon_rest) p.x = -p.x;
              }),
              "the balloon's rest shape is inside out");
  EXPECT_SAYS(said_of([](auto& m) {
                const int count = int(m.balloon.vertices.size());
                const std::vector<Triangle> first = m.balloon.triangles;
                for (int v = 0; v < count; ++v) {
                  m.balloon.vertices.push_back(m.balloon.vertices[std::size_t(v)] + Vec3{50, 0, 0});
                  m.balloon_rest.push_back(m.balloon_rest[std::size_t(v)] + Vec3{50, 0, 0});
                  m.balloon_fixed.push_back(0);
                }
                for (const Triangle& t : first)
                  m.balloon.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
              }),
              "the balloon is in pieces: vertex 58");
}

TEST(Scene, RefusesPositionsThatAreNoNumbers) {
  EXPECT_SAYS(said_of([](auto& m) { m.balloon.vertices[4].y = kNan; }),
              "vertex 4 of the balloon is not a number");
  EXPECT_SAYS(said_of([](auto& m) { m.balloon_rest[6].z = 1.0 / 0.0; }),
              "vertex 6 of the balloon's rest shape is not a number");
  EXPECT_SAYS(said_of([](auto& m) { m.guidewire[1].x = kNan; }),
              "vertex 1 of the guidewire is not a number");
  EXPECT_SAYS(said_of([](auto& m) { m.wall.vertices[9].x = kNan; }, false),
              "vertex 9 of the wall is not a number");
  EXPECT_SAYS(said_of([](auto& m) { m.wall_abscissa[2] = kNan; }, false), "vertex 2 of the wall");
}

TEST(Scene, RefusesCornersThatDoNotExistOrRepeat) {
  EXPECT_SAYS(said_of([](auto& m) { m.balloon.triangles[2][1] = 1000; }),
              "triangle 2 of the balloon has a corner 1000 that does not exist");
  EXPECT_SAYS(said_of([](auto& m) { m.balloon.triangles[2][1] = -1; }), "a corner -1");
  EXPECT_SAYS(said_of([](auto& m) { m.balloon.triangles[2][1] = m.balloon.triangles[2][0]; }),
              "triangle 2 of the balloon has the same corner twice");
  EXPECT_SAYS(said_of([](auto& m) { m.wall.triangles[7][0] = 1000; }, false),
              "triangle 7 of the wall has a corner 1000");
  EXPECT_SAYS(said_of(
                  [](auto& m) {
                    m.air.push_back({0, 1, 2, 5000});
                  },
                  false),
              "tetrahedron 0 of the air mesh has a corner 5000");
}

TEST(Scene, RefusesVerticesOnOneAnotherOrInNoTriangleAndFlatTriangles) {
  EXPECT_SAYS(said_of([](auto& m) { m.balloon.vertices[3] = m.balloon.vertices[20]; }),
              "vertices 3 and 20 of the balloon lie on the same point");
  EXPECT_SAYS(said_of([](auto& m) { m.wall.vertices[3] = m.wall.vertices[40]; }, false),
              "vertices 3 and 40 of the wall lie on the same point");
  EXPECT_SAYS(said_of([](auto& m) {
                const Triangle& t = m.balloon.triangles[0];
                m.balloon_rest[std::size_t(t[0])] = m.balloon_rest[std::size_t(t[1])];
              }),
              "triangle 0 of the balloon's rest shape has no area");
  EXPECT_SAYS(said_of(
                  [](auto& m) {
                    m.wall.vertices.push_back({0, 0, 40});
                    m.wall_fixed.push_back(0);
                    m.wall_abscissa.push_back(40);
                    m.wall_group.push_back(0);
                  },
                  false),
              "vertex 90 of the wall is in no triangle");
}

TEST(Scene, RefusesAGuidewireOutsideTheBalloon) {
  EXPECT_SAYS(said_of([](auto& m) {
                for (Vec3& p : m.guidewire) p.x += 1.0;
              }),
              "the guidewire lies outside the balloon");
  EXPECT_SAYS(said_of([](auto& m) {
                m.guidewire = {{0, 0, -4}, {0, 0, -2}, {2, 0, 0}, {0, 0, 2}, {0, 0, 4}};
              }),
              "the guidewire leaves the balloon through its side at node 2");
  // One that comes in and leaves by the ends is a wire.
  SimulationModel through = good();
  through.guidewire = {{0, 0, -30}, {0, 0, 0}, {0, 0, 30}};
  EXPECT_NO_THROW(detail::make_scene(through, {}));
}

TEST(Scene, RefusesAWallInPiecesOrHeldByNothing) {
  EXPECT_SAYS(said_of(
                  [](auto& m) {  // without the triangles of the strip in the middle
                    std::erase_if(m.wall.triangles, [](const Triangle& t) {
                      return std::min({t[0], t[1], t[2]}) / 10 == 4;
                    });
                  },
                  false),
              "the wall is in pieces: vertex 50 is not joined to vertex 0");
  SimulationOptions options;
  options.wall.foundation_kpa_per_mm = 0.0;
  EXPECT_SAYS(said_of([](auto& m) { m.wall_fixed.assign(m.wall_fixed.size(), 0); }, false, options),
              "nothing holds the wall");
}

TEST(Scene, RefusesNonsenseMaterial) {
  const auto refused = [](const auto& change) {
    SimulationOptions options;
    change(options);
    EXPECT_THROW(simulate(good(), options, {}), OptionError);
    EXPECT_THROW(detail::find_equilibria(good(), options, {}), OptionError);
  };
  refused([](SimulationOptions& o) { o.balloon.wall_mm = 0.0; });
  refused([](SimulationOptions& o) { o.balloon.wall_mm = kNan; });
  refused([](SimulationOptions& o) { o.balloon.c1_mpa = -1.0; });
  refused([](SimulationOptions& o) { o.balloon.name = "cheese"; });
  refused([](SimulationOptions& o) { o.wall.modulus_kpa = kNan; });
  refused([](SimulationOptions& o) { o.wall.thickness_ratio = 0.5; });
  refused([](SimulationOptions& o) { o.wall.shape_beta = 1.5; });
}

}  // namespace
}  // namespace angio::simulation
