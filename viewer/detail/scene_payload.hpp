#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/vec3.hpp"

namespace angio::viewer::detail {

/// Numbers for the page's scene, as viewer/page/scene.js reads them: whole numbers as differences
/// to the one `stride` places before, with the sign in the lowest bit, one plane for each of their
/// four bytes. What hardly changes is then mostly zeros, which deflate takes away.
class ScenePayload {
 public:
  static constexpr double kQuantum = 0.005;  ///< of places [mm]

  /// @return where they are: {offset, count, stride}
  nlohmann::json add_integers(const std::vector<std::int32_t>& values, std::size_t stride);

  /// Places rounded to kQuantum. @param frames  each with as many points [mm]
  /// @return {at, quantum, array}
  nlohmann::json add_points(const std::vector<std::vector<Vec3>>& frames);

  /// The header's length (32 bits, least byte first), the header, the planes.
  [[nodiscard]] std::string bytes(const nlohmann::json& header) const;

 private:
  std::string planes_;
};

/// zlib's format (RFC 1950), in base64.
std::string packed(const std::string& bytes);

}  // namespace angio::viewer::detail
