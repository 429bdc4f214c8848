#include "viewer/detail/scene_payload.hpp"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "formats/text.hpp"

namespace angio::viewer::detail {
using nlohmann::json;

json ScenePayload::add_integers(const std::vector<std::int32_t>& values, std::size_t stride) {
  const std::size_t offset = planes_.size(), count = values.size();
  planes_.resize(offset + 4 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = std::uint32_t(values[i]);
    const std::uint32_t step = i < stride ? value : value - std::uint32_t(values[i - stride]);
    const std::uint32_t word = (step << 1) ^ (step >> 31 != 0 ? ~std::uint32_t(0) : 0u);
    for (std::size_t plane = 0; plane < 4; ++plane)
      planes_[offset + plane * count + i] = char(word >> (8 * plane) & 0xffu);
  }
  return {{"offset", offset}, {"count", count}, {"stride", stride}};
}

json ScenePayload::add_points(const std::vector<std::vector<Vec3>>& frames) {
  const Vec3 at = frames.empty() || frames.front().empty() ? Vec3{} : frames.front().front();
  std::vector<std::int32_t> values;
  for (const std::vector<Vec3>& frame : frames)
    for (const Vec3& p : frame)
      for (const double way : {p.x - at.x, p.y - at.y, p.z - at.z})
        values.push_back(std::int32_t(std::lround(way / kQuantum)));
  // A frame differs little from the one before; a point of a single frame from its neighbour.
  const std::size_t stride = frames.size() > 1 ? 3 * frames.front().size() : 3;
  return {{"at", {at.x, at.y, at.z}},
          {"quantum", kQuantum},
          {"array", add_integers(values, std::max<std::size_t>(1, stride))}};
}

std::string ScenePayload::bytes(const json& header) const {
  const std::string text = header.dump();
  std::string out;
  for (int byte = 0; byte < 4; ++byte) out += char(text.size() >> (8 * byte) & 0xffu);
  return out + text + planes_;
}

std::string packed(const std::string& bytes) {
  uLongf size = compressBound(uLong(bytes.size()));
  std::string out(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), uLong(bytes.size()), 6) != Z_OK)
    throw Error(ExitCode::internal, "zlib could not compress the report's scene");
  out.resize(size);
  return formats::base64(out);
}

}  // namespace angio::viewer::detail
