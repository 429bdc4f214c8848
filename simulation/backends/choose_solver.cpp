#include "simulation/backends/step_solver.hpp"

// The solvers of a program that is compiled for several processors (ANGIO_CPU=ANY).
namespace angio::simulation::detail {

// What cpu_solver.cpp and cuda_solver.cpp define for any x86-64, and for x86-64-v3.
std::unique_ptr<StepSolver> make_cpu_solver_v1(const Scene&, const SimulationOptions&, Precision,
                                               int);
std::unique_ptr<StepSolver> make_cpu_solver_v3(const Scene&, const SimulationOptions&, Precision,
                                               int);
std::unique_ptr<StepSolver> make_cuda_solver_v1(const Scene&, const SimulationOptions&, Precision,
                                                Spread);
std::unique_ptr<StepSolver> make_cuda_solver_v3(const Scene&, const SimulationOptions&, Precision,
                                                Spread);

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
