#pragma once

#include <cstdint>
#include <vector>

#include "core/triangle_mesh.hpp"
#include "datasets/rotational_run.hpp"

/// How vessels of a phantom move with heart and breath.
namespace angio::datasets::detail {

/// The phase at which the truth stands, as a part of the way from R wave to R wave: the heart rests
/// in the middle of its diastole.
constexpr double kRestingPhase = 0.75;

/// How far the heart's motion is on at a phase, from 0 (at rest) to 1 (end of systole): a cubic
/// without overshoot through keys of a left coronary's way (Fritsch, Carlson, SIAM J. Numer. Anal.
/// 17:238, 1980; the course is of the kind that Shechter, Resar, McVeigh, IEEE Trans. Med. Imaging
/// 25:369, 2006 measured: fastest in early diastole, at rest before the atria contract).
/// @param phase  any; whole numbers are R waves
double heart_excursion(double phase);

/// How far a breath is on at a time, from 0 (breathed out) to 1, with a rest between breaths:
/// sin^6(pi t / T) (Lujan et al., Med. Phys. 26:715, 1999, eq. 1, n = 3).
double breath_excursion(double time_s, double breaths_per_min);

/// The times of R waves, from the last before `from_s` to the first after `to_s`: beats whose
/// lengths scatter by 3 % of their mean, the first at any time of a beat.
std::vector<double> r_waves(double beats_per_min, double from_s, double to_s, std::uint64_t seed);

/// The part of the beat that is over at a time. @param r_waves  the times around it
double cardiac_phase(const std::vector<double>& r_waves, double time_s);

/// Where each of a surface's vertices goes from rest to the end of systole: drawn towards the
/// heart's apex, inward across its long axis, and twisted around it,
///
///     u(x) = m (0.45 e - 0.5 (x - (e . x) e) / L + 0.35 (e x x) (e . x) / L^2)
///
/// e: the long axis, to the left, front and feet; L: how far the farthest vertex lies from the
/// origin; m: so that the longest way is `largest_mm`.
/// @throws OptionError  the surface would fold (m / L > 0.5)
std::vector<Vec3> systolic_ways(const TriangleMesh& surface, double largest_mm);

/// Times, phases and shifts of a run's frames.
RunMotion plan_motion(const RotationalRunOptions& run, std::uint64_t seed);

/// A surface as a frame finds it.
/// @param ways  systolic_ways(), or empty
TriangleMesh moved_surface(const TriangleMesh& surface, const std::vector<Vec3>& ways,
                           const RunMotion& motion, std::size_t frame);

}  // namespace angio::datasets::detail
