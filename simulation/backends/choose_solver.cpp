#include "simulation/backends/step_solver.hpp"
#include "simulation/newton/eliminate_front.hpp"

// The solvers of a program that is compiled for several processors (ANGIO_CPU=ANY).
namespace angio::simulation::detail {

// What cpu_solver.cpp, cuda_solver.cpp and eliminate_front.cpp define for any x86-64, and for
// x86-64-v3.
std::unique_ptr<StepSolver> make_cpu_solver_v1(const Scene&, const SimulationOptions&, Precision,
                                               int);
std::unique_ptr<StepSolver> make_cpu_solver_v3(const Scene&, const SimulationOptions&, Precision,
                                               int);
std::unique_ptr<StepSolver> make_cuda_solver_v1(const Scene&, const SimulationOptions&, Precision,
                                                Spread);
std::unique_ptr<StepSolver> make_cuda_solver_v3(const Scene&, const SimulationOptions&, Precision,
                                                Spread);

int eliminate_front_v1(double*, std::ptrdiff_t, std::ptrdiff_t, double*);
int eliminate_front_v3(double*, std::ptrdiff_t, std::ptrdiff_t, double*);

int eliminate_front(double* front, std::ptrdiff_t size, std::ptrdiff_t count, double* pivots) {
  return __builtin_cpu_supports("x86-64-v3") ? eliminate_front_v3(front, size, count, pivots)
                                             : eliminate_front_v1(front, size, count, pivots);
}

std::unique_ptr<StepSolver> make_cpu_solver(const Scene& scene, const SimulationOptions& options,
                                            Precision precision, int threads) {
  return __builtin_cpu_supports("x86-64-v3")
             ? make_cpu_solver_v3(scene, options, precision, threads)
             : make_cpu_solver_v1(scene, options, precision, threads);
}

#ifdef ANGIO_HAS_CUDA
std::unique_ptr<StepSolver> make_cuda_solver(const Scene& scene, const SimulationOptions& options,
                                             Precision precision, Spread spread) {
  return __builtin_cpu_supports("x86-64-v3")
             ? make_cuda_solver_v3(scene, options, precision, spread)
             : make_cuda_solver_v1(scene, options, precision, spread);
}
#endif

}  // namespace angio::simulation::detail
