#pragma once

#include <string>
#include <vector>

namespace angio {

enum class ArrayType { float32, float64, int32, uint8 };

/// A named array over the points or the cells of a file, tuple by tuple.
struct DataArray {
  std::string name;            ///< as in docs/contract.md, e.g. "MaximumInscribedSphereRadius"
  std::vector<double> values;  ///< shape [tuple_count, component_count]
  int component_count = 1;
  ArrayType type = ArrayType::float64;  ///< as stored in the file
};

}  // namespace angio
