#pragma once

#include <cstddef>
#include <exception>

/// The program's one parallel loop. Every iteration writes its own output only, so results do
/// not depend on the number of threads (set by omp_set_num_threads, once, by the command).
namespace angio {

/// Calls body(i) for i in [0, count), in parallel. The first exception is thrown again here.
template <class Body>
void parallel_for(std::ptrdiff_t count, const Body& body) {
  std::exception_ptr error;
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    try {
      body(i);
    } catch (...) {
#pragma omp critical(angio_parallel_for)
      if (!error) error = std::current_exception();
    }
  }
  if (error) std::rethrow_exception(error);
}

/// Calls body(i) for i in [0, count), in parallel, for iterations of unequal cost.
template <class Body>
void parallel_for_uneven(std::ptrdiff_t count, const Body& body) {
  std::exception_ptr error;
#pragma omp parallel for schedule(dynamic, 1)
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    try {
      body(i);
    } catch (...) {
#pragma omp critical(angio_parallel_for)
      if (!error) error = std::current_exception();
    }
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace angio
