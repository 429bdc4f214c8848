#include "formats/gltf.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "formats/text.hpp"

namespace angio::formats {
namespace {

using nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "glTF is written little-endian");

// The specification's numbers.
constexpr int kFloat = 5126, kUint32 = 5125;
constexpr int kVertexBuffer = 34962, kIndexBuffer = 34963;
constexpr int kLineStrip = 3, kTriangles = 4;
constexpr std::uint32_t kMagic = 0x46546C67, kVersion = 2, kJsonChunk = 0x4E4F534A,
                        kBinaryChunk = 0x004E4942;

constexpr double kMetre = 1000.0;  // [mm]

Vec3 turned(const Vec3& lps) { return {lps.x, lps.z, -lps.y}; }

std::vector<float> places(const std::vector<Vec3>& points) {
  std::vector<float> numbers;
  for (const Vec3& point : points) {
    const Vec3 at = turned(point);
    for (int axis = 0; axis < 3; ++axis) numbers.push_back(float(at[axis] / kMetre));
  }
  return numbers;
}

std::vector<float> normals_of(const TriangleMesh& mesh) {
  std::vector<float> numbers;
  for (const Vec3& normal : vertex_normals(mesh)) {
    const double length = norm(normal);
    const Vec3 unit = length > 0.0 ? turned(normal) / length : Vec3{0.0, 0.0, 1.0};
    for (int axis = 0; axis < 3; ++axis) numbers.push_back(float(unit[axis]));
  }
  return numbers;
}

std::vector<float> subtract(const std::vector<float>& a, const std::vector<float>& b) {
  std::vector<float> difference(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) difference[i] = a[i] - b[i];
  return difference;
}

class SceneWriter {
 public:
  explicit SceneWriter(const GltfScene& scene) {
    document_["asset"] = {{"version", "2.0"}, {"generator", "angio"}};
    document_["scene"] = 0;
    document_["scenes"] = {{{"nodes", ordered_json::array()}}};
    for (const char* list : {"nodes", "meshes", "materials", "accessors", "bufferViews"})
      document_[list] = ordered_json::array();
    if (scene.times_s.size() > 1) {
      std::vector<float> times;
      for (const double time : scene.times_s) times.push_back(float(time - scene.times_s.front()));
      times_ = add_floats(times, 1, 0);
    }
    for (const GltfBody& body : scene.bodies) add(body, scene.times_s.size());
  }

  [[nodiscard]] std::string gltf() {
    document_["buffers"] = {{{"byteLength", bytes_.size()},
                             {"uri", "data:application/octet-stream;base64," + base64(bytes_)}}};
    return document_.dump(1) + "\n";
  }

  [[nodiscard]] std::string glb() {
    document_["buffers"] = {{{"byteLength", bytes_.size()}}};
    std::string json = document_.dump();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string file;
    const auto append = [&](std::uint32_t number) {
      file.append(reinterpret_cast<const char*>(&number), sizeof(number));
    };
    constexpr std::size_t kHeads = 12 + 8 + 8;
    if (kHeads + json.size() + bytes_.size() > std::numeric_limits<std::uint32_t>::max())
      throw InputError(
          "the scene is over 4 GiB (a .glb file cannot be larger). Simulate with a greater "
          "simulation.write_every");
    append(kMagic);
    append(kVersion);
    append(std::uint32_t(kHeads + json.size() + bytes_.size()));
    append(std::uint32_t(json.size()));
    append(kJsonChunk);
    file += json;
    append(std::uint32_t(bytes_.size()));  // whole words: all that is in it has four bytes
    append(kBinaryChunk);
    return file + bytes_;
  }

 private:
  template <class Value>
  int add_view(const std::vector<Value>& values, int target) {
    static_assert(sizeof(Value) == 4);
    const std::size_t offset = bytes_.size(), size = values.size() * sizeof(Value);
    bytes_.append(reinterpret_cast<const char*>(values.data()), size);
    ordered_json view = {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}};
    if (target != 0) view["target"] = target;
    document_["bufferViews"].push_back(view);
    return int(document_["bufferViews"].size()) - 1;
  }

  /// An accessor with the least and the greatest of each component.
  int add_floats(const std::vector<float>& values, int components, int target) {
    const auto width = std::size_t(components);
    std::vector<float> low(values.begin(), values.begin() + components), high = low;
    for (std::size_t i = 0; i < values.size(); ++i) {
      low[i % width] = std::min(low[i % width], values[i]);
      high[i % width] = std::max(high[i % width], values[i]);
    }
    const int view = add_view(values, target);
    document_["accessors"].push_back({{"bufferView", view},
                                      {"componentType", kFloat},
                                      {"count", values.size() / width},
                                      {"type", components == 3 ? "VEC3" : "SCALAR"},
                                      {"min", low},
                                      {"max", high}});
    return int(document_["accessors"].size()) - 1;
  }

  int add_indices(const std::vector<Triangle>& triangles) {
    std::vector<std::uint32_t> corners;
    for (const Triangle& triangle : triangles)
      for (const int corner : triangle) corners.push_back(std::uint32_t(corner));
    const int view = add_view(corners, kIndexBuffer);
    document_["accessors"].push_back({{"bufferView", view},
                                      {"componentType", kUint32},
                                      {"count", corners.size()},
                                      {"type", "SCALAR"}});
    return int(document_["accessors"].size()) - 1;
  }

  int add_material(const GltfBody& body) {
    ordered_json material = {
        {"name", body.name},
        {"pbrMetallicRoughness",
         {{"baseColorFactor", {body.rgb[0], body.rgb[1], body.rgb[2], body.opacity}},
          {"metallicFactor", 0.0},
          {"roughnessFactor", 0.6}}},
        {"doubleSided", true}};
    if (body.opacity < 1.0) material["alphaMode"] = "BLEND";
    document_["materials"].push_back(material);
    return int(document_["materials"].size()) - 1;
  }

  void add(const GltfBody& body, std::size_t time_count) {
    const bool is_line = body.mesh.triangles.empty();
    if (body.mesh.vertices.size() < 2)
      throw InputError("the body " + body.name + " is empty. Run the stage that writes it again");
    const std::vector<float> at_first = places(body.mesh.vertices);
    ordered_json primitive = {
        {"attributes", {{"POSITION", add_floats(at_first, 3, kVertexBuffer)}}},
        {"mode", is_line ? kLineStrip : kTriangles},
        {"material", add_material(body)}};
    std::vector<float> normals;
    if (!is_line) {
      normals = normals_of(body.mesh);
      primitive["attributes"]["NORMAL"] = add_floats(normals, 3, kVertexBuffer);
      primitive["indices"] = add_indices(body.mesh.triangles);
    }
    for (const std::vector<Vec3>& later : body.later) {
      if (later.size() != body.mesh.vertices.size())
        throw InputError("the body " + body.name +
                         " has another number of points in a later frame (its files are of "
                         "different runs). Run `angio simulate` again");
      ordered_json target = {
          {"POSITION", add_floats(subtract(places(later), at_first), 3, kVertexBuffer)}};
      if (!is_line)
        target["NORMAL"] = add_floats(subtract(normals_of({later, body.mesh.triangles}), normals),
                                      3, kVertexBuffer);
      primitive["targets"].push_back(target);
    }
    ordered_json mesh = {{"name", body.name}, {"primitives", {primitive}}};
    if (!body.later.empty()) mesh["weights"] = std::vector<double>(body.later.size(), 0.0);
    document_["meshes"].push_back(mesh);
    const auto index = document_["meshes"].size() - 1;
    document_["nodes"].push_back({{"name", body.name}, {"mesh", index}});
    document_["scenes"][0]["nodes"].push_back(index);
    if (!body.later.empty()) animate(int(index), body.later.size(), time_count);
  }

  /// At each time the weight of its own target is one: at the first there is none.
  void animate(int node, std::size_t target_count, std::size_t time_count) {
    if (target_count + 1 != time_count)
      throw InternalError("a body has shapes for another number of times than the scene");
    std::vector<float> weights(time_count * target_count, 0.0F);
    for (std::size_t time = 1; time < time_count; ++time)
      weights[time * target_count + time - 1] = 1.0F;
    const int output = add_floats(weights, 1, 0);
    if (!document_.contains("animations"))
      document_["animations"] = {{{"name", "simulation"},
                                  {"channels", ordered_json::array()},
                                  {"samplers", ordered_json::array()}}};
    ordered_json& animation = document_["animations"][0];
    const auto sampler = animation["samplers"].size();
    animation["channels"].push_back(
        {{"sampler", sampler}, {"target", {{"node", node}, {"path", "weights"}}}});
    animation["samplers"].push_back(
        {{"input", times_}, {"interpolation", "LINEAR"}, {"output", output}});
  }

  ordered_json document_;
  std::string bytes_;
  int times_ = -1;
};

}  // namespace

void write_gltf(const std::filesystem::path& path, const GltfScene& scene) {
  const std::string extension = lower_extension(path);
  if (extension != ".glb" && extension != ".gltf")
    throw Error(ExitCode::usage, "no scene can be written as " + path.filename().string() +
                                     ". Give a name ending in .glb or .gltf");
  SceneWriter writer(scene);
  write_text_atomically(path, extension == ".glb" ? writer.glb() : writer.gltf());
}

}  // namespace angio::formats
