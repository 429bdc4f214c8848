#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"
#include "simulation/materials/membrane.hpp"
#include "simulation/pbd/point_packs.hpp"

namespace angio::simulation::detail {

struct SheetStep {
  double dt = 0.025;        ///< [s]; 0: no inertia, towards the equilibrium
  int sweeps = 20;          ///< over all vertices
  double relaxation = 1.0;  ///< of each vertex's Newton step, [1, 2)
  int lanes = 0;  ///< vertices at once, 8 or 16; 0: as many as the processor's vectors hold
};

/// A membrane alone, open or closed, by vertex block descent: implicit Euler, each vertex taking a
/// Newton step in its own 3 x 3 block, colour by colour. (The balloon's step is the same, with gas
/// and contact: program.hpp.)
///
/// Vertices of a colour have no term in common, so that many of them are worked on at once, in
/// packs of one vertex a lane. The result does not depend on the pack's width. Single precision.
///
/// Source: Chen, Liu, Yang, Yuksel, "Vertex Block Descent", ACM TOG 43 (2024), Eqs. 4-9.
class SheetSolver {
 public:
  /// @param rest       unloaded shape [mm]
  /// @param thickness  H [mm]
  /// @param density    [g/mm^3]
  /// @param fixed      shape [vertex]: moves only by `set_position`; empty: none
  SheetSolver(const TriangleMesh& rest, const MooneyRivlin<double>& law, double thickness,
              double density, const std::vector<char>& fixed);

  void set_position(int vertex, const Vec3& position);

  void step(const SheetStep& options);

  [[nodiscard]] std::vector<Vec3> positions() const;  ///< [mm], shape [vertex]
  [[nodiscard]] int color_count() const { return color_count_; }

  static constexpr int kBatch = 16;
  /// A triangle of each of a batch's vertices, seen from there: the places of its other corners,
  /// and its CornerMetric. For want of a triangle the vertex's last one, without volume.
  struct Corners {
    int next[kBatch], last[kBatch];
    float k11[kBatch], k12[kBatch], k22[kBatch], inverse_det[kBatch], volume[kBatch];
  };
  /// Vertices of a colour, at the places first, first + 1, ...; of the last one, copies fill up.
  struct Batch {
    int first = 0;
    int corner_begin = 0, corner_end = 0;
  };
  /// What a sweep works on.
  struct View {
    MooneyRivlin<float> law;
    const Batch* batches = nullptr;
    int batch_count = 0;
    const Corners* corners = nullptr;
    PackedPoint* points = nullptr;          // [place]
    const PackedPoint* inertial = nullptr;  // [place], where inertia alone would lead
    const float* mass = nullptr;            // [place] [g]
    const float* reach = nullptr;           // [place], the farthest move of a sweep [mm]
    float per_time_squared = 0.0F;          // 1 / dt^2 [1/s^2]
    float relaxation = 1.0F;
  };

 private:
  struct Ring;  // what a vertex has around it

  [[nodiscard]] static std::vector<Ring> rings(const TriangleMesh& rest, double thickness);
  std::vector<int> place_vertices(const TriangleMesh& rest, const std::vector<Ring>& rings,
                                  std::vector<char> fixed);
  void add_corners(const std::vector<int>& vertex_at, const std::vector<Ring>& rings);
  void predict(float dt);

  MooneyRivlin<float> law_;
  Vec3 origin_;
  int color_count_ = 0, moving_ = 0;  // colours; places of what moves
  std::vector<int> place_;            // of a vertex
  std::vector<Batch> batches_;
  std::vector<Corners> corners_;
  std::vector<PackedPoint> points_, before_, inertial_, velocities_;  // [place]
  std::vector<float> mass_, reach_;                                   // [place]
};

}  // namespace angio::simulation::detail
