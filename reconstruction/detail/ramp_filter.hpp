#pragma once

#include <memory>
#include <vector>

#include "reconstruction/reconstruction.hpp"

namespace angio::reconstruction::detail {

/// What the ramp filter does to each frequency of a circle of `length` pixels, over `length`: the
/// spectrum of a h(n) (RampFilter) times a window of the frequency f up to the highest, F: 1,
/// sinc(f / 2F), or (1 + cos(pi f / F)) / 2.
/// @param length  even
/// @return shape [length / 2 + 1]
std::vector<float> ramp_response(int length, double spacing_mm, FilterWindow window);

/// The ramp filter of rows of line integrals, by FFTW.
///
///     q(u) = a sum_n p(u - n a) h(n),   h(0) = 1 / (4 a^2),   h(odd n) = -1 / (pi n a)^2,   else 0
///
/// (Kak, Slaney, Principles of Computerized Tomographic Imaging, 1988, ch. 3, eq. 61), times a
/// window of the frequency. A row that ends within the body goes on as that of a cylinder of water
/// (row_ends.hpp).
class RampFilter {
 public:
  RampFilter(int columns, double spacing_mm, FilterWindow window);
  ~RampFilter();
  RampFilter(const RampFilter&) = delete;
  RampFilter& operator=(const RampFilter&) = delete;

  /// Numbers of a row for filter(), one set a thread.
  class Workspace {
   public:
    explicit Workspace(const RampFilter& filter);
    ~Workspace();
    Workspace(const Workspace&) = delete;
    Workspace& operator=(const Workspace&) = delete;

   private:
    friend class RampFilter;
    struct Buffers;
    std::unique_ptr<Buffers> buffers_;
  };

  /// @param row  shape [columns]; filtered in place
  void filter(float* row, Workspace& workspace) const;

 private:
  struct Plans;
  std::unique_ptr<Plans> plans_;
  int columns_ = 0, beyond_ = 0, length_ = 0;
  double spacing_mm_ = 1.0;
  std::vector<float> response_;  ///< shape [length / 2 + 1]
};

/// Whether a row ends within the body at either side, where its value is above what its noise or
/// air would leave.
bool is_truncated(const float* row, int columns);

}  // namespace angio::reconstruction::detail
