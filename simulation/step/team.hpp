#pragma once

#include <omp.h>

#include <algorithm>
#include <vector>

/// How a step's loops are run: by a team, the same source for every backend.
///
/// All threads of a team run the same program and meet in its loops. A team has
///
///     leader()                        one of its threads
///     barrier()                       all writes before it are seen after it
///     for_each<L>(count, body)        body(i, lanes) for i in [0, count); no barrier at its end
///     sum<L, N>(count, body, total)   the same with body(i, lanes, part), part[N] to be added to;
///                                     total[N] is the sum, the same bits for every thread; it ends
///                                     with a barrier
///     quick_sum<L, N>                 the same, N <= 4, when single precision will do for the sum
///     most<N>(count, body, total)     as quick_sum<1, N>, but total[N] is the largest of the
///                                     parts, which are not negative
///     now()                           a clock [s]
///     kSurroundings                   can there be anything beside the balloon?
///     kSolids                         can it move a layered wall, and project what the paper does?
///     kIsSmall                        does a short piece of work pay for one of its threads alone?
///     kBalloonLanes, kVertexLanes, kSlabLanes  the L that suits a balloon's vertex (with a wall
///                                     there are many pairs), a wall's vertex or what lies behind
///                                     it, a slab's members
///
/// `lanes` are the threads that share one i, up to L of them: the body strides by lanes.size() from
/// lanes.rank(), and lanes.sum(x) adds over them, lanes.before(yes) counts those before this one
/// that say yes, and lanes.sync() comes before one of them writes what all have read. What is added
/// to `part` counts once per i.
namespace angio::simulation::detail {

/// A single thread has an index to itself.
struct OneLane {
  static constexpr int rank() { return 0; }
  static constexpr int size() { return 1; }
  static constexpr void sync() {}
  static constexpr int before(bool) { return 0; }
  template <class Value>
  static constexpr Value sum(Value value) {
    return value;
  }
};

/// OpenMP threads. Sums are taken over pieces that depend on the count alone, so results do not
/// depend on the number of threads.
class CpuTeam {
 public:
  static constexpr bool kSurroundings = true, kSolids = true, kIsSmall = true;
  static constexpr int kBalloonLanes = 1, kVertexLanes = 1, kSlabLanes = 1;
  static constexpr int kMostSums = 4;

  /// What the threads of a team share.
  struct Shared {
    std::vector<double> parts = std::vector<double>(std::size_t(2 * kPieces * kMostSums));
  };

  CpuTeam(int rank, int size, Shared& shared)
      : rank_(rank), size_(size), parts_(shared.parts.data()) {}

  [[nodiscard]] bool leader() const { return rank_ == 0; }
  [[nodiscard]] static double now() { return omp_get_wtime(); }

  void barrier() const {
    if (size_ > 1) {
#pragma omp barrier
    }
  }

  template <int L, class Body>
  void for_each(int count, const Body& body) const {
    const int pieces = pieces_of(count);
    const int end = bound(count, pieces, (rank_ + 1) * pieces / size_);
    for (int i = bound(count, pieces, rank_ * pieces / size_); i < end; ++i) body(i, OneLane{});
  }

  template <int L, int N, class Body>
  void sum(int count, const Body& body, double (&total)[N]) {
    gather(count, body, total, [](double a, double b) { return a + b; });
  }

  template <int L, int N, class Body>
  void quick_sum(int count, const Body& body, double (&total)[N]) {
    sum<L>(count, body, total);
  }

  template <int N, class Body>
  void most(int count, const Body& body, double (&total)[N]) {
    gather(count, body, total, [](double a, double b) { return std::max(a, b); });
  }

 private:
  template <int N, class Body, class Combine>
  void gather(int count, const Body& body, double (&total)[N], const Combine& combine) {
    static_assert(N <= kMostSums);
    const int pieces = pieces_of(count);
    double* parts = parts_ + turn_ * kPieces * kMostSums;
    turn_ = 1 - turn_;
    for (int piece = rank_ * pieces / size_; piece < (rank_ + 1) * pieces / size_; ++piece) {
      double part[N] = {};
      const int end = bound(count, pieces, piece + 1);
      for (int i = bound(count, pieces, piece); i < end; ++i) body(i, OneLane{}, part);
      std::copy(part, part + N, parts + N * piece);
    }
    barrier();
    for (int n = 0; n < N; ++n) total[n] = 0.0;
    for (int piece = 0; piece < pieces; ++piece)
      for (int n = 0; n < N; ++n) total[n] = combine(total[n], parts[N * piece + n]);
  }

  static constexpr int kPieces = 256;    // at most
  static constexpr int kLeastPiece = 8;  // iterations

  static int pieces_of(int count) { return std::clamp(count / kLeastPiece, 1, kPieces); }
  static int bound(int count, int pieces, int piece) {
    return int(std::ptrdiff_t(count) * piece / pieces);
  }

  int rank_, size_, turn_ = 0;
  double* parts_;
};

/// Runs program(team) by a team of `threads` OpenMP threads.
template <class Program>
void run_on_cpu(int threads, CpuTeam::Shared& shared, const Program& program) {
  if (threads <= 1) {
    CpuTeam team(0, 1, shared);
    program(team);
    return;
  }
#pragma omp parallel num_threads(threads)
  {
    CpuTeam team(omp_get_thread_num(), omp_get_num_threads(), shared);
    program(team);
  }
}

}  // namespace angio::simulation::detail
