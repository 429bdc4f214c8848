#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/tet_mesh.hpp"
#include "core/vec3.hpp"

namespace angio {
namespace {

std::vector<Vec3> random_vectors(int count) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  std::vector<Vec3> vectors;
  for (int i = 0; i < count; ++i) {
    const double x = uniform(generator);
    const double y = uniform(generator);
    vectors.push_back({x, y, uniform(generator)});
  }
  return vectors;
}

std::vector<Mat3> random_matrices(int count) {
  const std::vector<Vec3> rows = random_vectors(3 * count);
  std::vector<Mat3> matrices;
  for (std::size_t i = 0; i < std::size_t(count); ++i)
    matrices.push_back({{{rows[3 * i].x, rows[3 * i].y, rows[3 * i].z},
                         {rows[3 * i + 1].x, rows[3 * i + 1].y, rows[3 * i + 1].z},
                         {rows[3 * i + 2].x, rows[3 * i + 2].y, rows[3 * i + 2].z}}});
  return matrices;
}

void expect_near(const Mat3& a, const Mat3& b, double tolerance) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(a(i, j), b(i, j), tolerance) << i << ", " << j;
}

TEST(Vec3, CrossOfAxesIsRightHanded) {
  constexpr Vec3 kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};
  static_assert(cross(kX, kY) == kZ);
  static_assert(cross(kY, kZ) == kX);
  static_assert(cross(kZ, kX) == kY);
}

TEST(Vec3, CrossObeysLagrangesIdentity) {
  const std::vector<Vec3> v = random_vectors(200);
  for (std::size_t i = 0; i + 1 < v.size(); i += 2) {
    const Vec3& a = v[i];
    const Vec3& b = v[i + 1];
    EXPECT_NEAR(norm_squared(cross(a, b)) + dot(a, b) * dot(a, b),
                norm_squared(a) * norm_squared(b), 1e-12);
    EXPECT_NEAR(dot(cross(a, b), a), 0.0, 1e-14);
  }
}

TEST(Vec3, NormalizedHasUnitLengthAndKeepsZero) {
  for (const Vec3& v : random_vectors(50)) EXPECT_NEAR(norm(normalized(v)), 1.0, 1e-15);
  EXPECT_EQ(normalized(Vec3{}), (Vec3{}));
}

TEST(Vec3, AnyPerpendicularIsAUnitVectorAtRightAngles) {
  std::vector<Vec3> directions = random_vectors(200);
  directions.insert(directions.end(), {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, 1, 1}});
  for (const Vec3& v : directions) {
    const Vec3 p = any_perpendicular(normalized(v));
    EXPECT_NEAR(norm(p), 1.0, 1e-14);
    EXPECT_NEAR(dot(p, v), 0.0, 1e-14);
  }
}

TEST(Mat3, InverseUndoesTheMatrix) {
  for (const Mat3& a : random_matrices(100)) {
    if (std::abs(determinant(a)) < 0.1) continue;
    expect_near(a * inverse(a), Mat3::identity(), 1e-12);
    expect_near(inverse(a) * a, Mat3::identity(), 1e-12);
  }
}

TEST(Mat3, DeterminantIsMultiplicativeAndTheTripleProductOfTheRows) {
  const std::vector<Mat3> m = random_matrices(100);
  for (std::size_t i = 0; i + 1 < m.size(); ++i) {
    EXPECT_NEAR(determinant(m[i] * m[i + 1]), determinant(m[i]) * determinant(m[i + 1]), 1e-11);
    const auto row = [&](int r) { return Vec3{m[i](r, 0), m[i](r, 1), m[i](r, 2)}; };
    EXPECT_NEAR(determinant(m[i]), dot(cross(row(0), row(1)), row(2)), 1e-13);
  }
}

TEST(Mat3, TransposeOfAProductIsTheProductOfTransposesReversed) {
  const std::vector<Mat3> m = random_matrices(20);
  for (std::size_t i = 0; i + 1 < m.size(); ++i)
    expect_near(transpose(m[i] * m[i + 1]), transpose(m[i + 1]) * transpose(m[i]), 1e-14);
}

TEST(Mat3, OuterProductAppliedToAVectorScalesTheFirstByTheDotOfTheOthers) {
  const std::vector<Vec3> v = random_vectors(30);
  for (std::size_t i = 0; i + 2 < v.size(); ++i)
    EXPECT_NEAR(distance(outer(v[i], v[i + 1]) * v[i + 2], dot(v[i + 1], v[i + 2]) * v[i]), 0.0,
                1e-14);
}

TEST(TetVolume, IsASixthForTheUnitCornerAndChangesSignWithTheHandedness) {
  constexpr Vec3 kO{}, kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};
  EXPECT_DOUBLE_EQ(tet_volume(kO, kX, kY, kZ), 1.0 / 6.0);
  EXPECT_DOUBLE_EQ(tet_volume(kO, kY, kX, kZ), -1.0 / 6.0);
}

}  // namespace
}  // namespace angio
