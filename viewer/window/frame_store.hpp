#pragma once

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "viewer/detail/case_data.hpp"

namespace angio::viewer::window {

enum class Body { wall, balloon, wire, tissue };

/// The surfaces of one written frame with the arrays of their files. Null where there is no file.
struct FrameShapes {
  vtkSmartPointer<vtkPolyData> wall;     ///< the lumen's wall: vessel_NNNNNN.vtp
  vtkSmartPointer<vtkPolyData> balloon;  ///< balloon_NNNNNN.vtp
  vtkSmartPointer<vtkPolyData> wire;     ///< guidewire_NNNNNN.vtp, a line
  vtkSmartPointer<vtkPolyData> tissue;   ///< the border of wall_NNNNNN.vtu, the layered wall

  TriangleMesh wall_mesh, balloon_mesh;  ///< the same, to be cut

  [[nodiscard]] vtkPolyData* of(Body body) const;
};

/// A number per point or per cell of a body's files, by which it can be coloured.
struct Field {
  Body body = Body::wall;
  std::string array;
  bool is_on_cells = false;

  [[nodiscard]] std::string title() const;        ///< for people, with its unit
  [[nodiscard]] std::string short_title() const;  ///< without
  friend bool operator==(const Field&, const Field&) = default;
};

struct FieldRange {
  double low = 0.0;
  double high = 1.0;  ///< > low
};

/// The frames of a case: each is read when it is first asked for, and kept, so that a second
/// round plays without reading.
class FrameStore {
 public:
  explicit FrameStore(const detail::CaseData& data) : data_(data) {}

  /// @throws InputError where a file is missing or damaged (a run may just be moving it)
  const FrameShapes& at(std::size_t index);
  /// What bodies can be coloured by, in the first frame's order; none without frames.
  std::vector<Field> fields();
  /// Over the first, the peak and the last frame, up to the 99.5th percentile, so that one vertex
  /// does not set the scale; from 0 where the least is less than a fifth of the highest.
  FieldRange range(const Field& field);

 private:
  const detail::CaseData& data_;
  std::map<int, FrameShapes> shapes_;  ///< by the frame's number
};

}  // namespace angio::viewer::window
