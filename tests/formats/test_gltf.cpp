#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/files.hpp"
#include "formats/gltf.hpp"
#include "formats/text.hpp"
#include "testing/viewer/shapes.hpp"

namespace angio::formats {
namespace {
using nlohmann::json;
using viewer::test::make_cube;
using viewer::test::TemporaryFolder;

/// A cube that moves by 1 mm towards the head, then 2 mm to the back, a still cube, and a line.
GltfScene moving_cube() {
  const TriangleMesh start = make_cube();
  GltfBody cube{"balloon", start, {0.1, 0.2, 0.9}, 0.5, {}};
  cube.later = {make_cube({0, 0, 1}).vertices, make_cube({0, 2, 0}).vertices};
  const GltfBody still{"lumen", make_cube({5, 0, 0}), {1, 0, 0}, 1.0, {}};
  const GltfBody line{"wire", {{{0, 0, 0}, {10, 0, 0}, {20, 0, 1}}, {}}, {0, 0, 0}, 1.0, {}};
  return {{cube, still, line}, {0.5, 1.0, 2.5}};
}

struct Glb {
  json document;
  std::string bytes;
};

std::uint32_t word_at(const std::string& file, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, file.data() + offset, 4);
  return word;
}

Glb parse_glb(const std::string& file) {
  EXPECT_EQ(file.substr(0, 4), "glTF");
  EXPECT_EQ(word_at(file, 4), 2u);
  EXPECT_EQ(word_at(file, 8), file.size());
  const std::size_t json_size = word_at(file, 12);
  EXPECT_EQ(file.substr(16, 4), "JSON");
  EXPECT_EQ(json_size % 4, 0u);
  const std::size_t bytes_size = word_at(file, 20 + json_size);
  EXPECT_EQ(file.substr(24 + json_size, 4), std::string("BIN\0", 4));
  EXPECT_EQ(28 + json_size + bytes_size, file.size());
  return {json::parse(file.substr(20, json_size)), file.substr(28 + json_size)};
}

int components(const json& accessor) { return accessor.at("type") == "VEC3" ? 3 : 1; }

std::vector<float> floats_of(const Glb& glb, int index) {
  const json& accessor = glb.document.at("accessors").at(std::size_t(index));
  const json& view =
      glb.document.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
  std::vector<float> values(accessor.at("count").get<std::size_t>() *
                            std::size_t(components(accessor)));
  EXPECT_EQ(values.size() * 4, view.at("byteLength").get<std::size_t>());
  EXPECT_LE(view.at("byteOffset").get<std::size_t>() + values.size() * 4, glb.bytes.size());
  std::memcpy(values.data(), glb.bytes.data() + view.at("byteOffset").get<std::size_t>(),
              values.size() * 4);
  return values;
}

Glb write_and_parse(const GltfScene& scene) {
  const TemporaryFolder folder;
  write_gltf(folder / "scene.glb", scene);
  return parse_glb(read_text(folder / "scene.glb"));
}

TEST(Gltf, AccessorsFillTheBufferAndBoundTheirValues) {
  const Glb glb = write_and_parse(moving_cube());
  EXPECT_EQ(glb.document.at("asset").at("version"), "2.0");
  EXPECT_EQ(glb.document.at("buffers").at(0).at("byteLength"), glb.bytes.size());
  std::size_t end = 0;
  for (const json& view : glb.document.at("bufferViews")) {  // no gap, no overlap, whole words
    EXPECT_EQ(view.at("byteOffset"), end);
    EXPECT_EQ(end % 4, 0u);
    end += view.at("byteLength").get<std::size_t>();
  }
  EXPECT_EQ(end, glb.bytes.size());
  const json& accessors = glb.document.at("accessors");
  for (int a = 0; a < int(accessors.size()); ++a) {
    const json& accessor = accessors.at(std::size_t(a));
    if (accessor.at("componentType") != 5126) continue;
    const std::vector<float> values = floats_of(glb, a);
    const int width = components(accessor);
    for (int c = 0; c < width; ++c) {
      float low = values[std::size_t(c)], high = low;
      for (auto i = std::size_t(c); i < values.size(); i += std::size_t(width)) {
        low = std::min(low, values[i]);
        high = std::max(high, values[i]);
      }
      EXPECT_EQ(accessor.at("min").at(std::size_t(c)).get<float>(), low);
      EXPECT_EQ(accessor.at("max").at(std::size_t(c)).get<float>(), high);
    }
  }
}

TEST(Gltf, IndicesNameVerticesThatThereAre) {
  const Glb glb = write_and_parse(moving_cube());
  for (const json& mesh : glb.document.at("meshes")) {
    const json& primitive = mesh.at("primitives").at(0);
    const auto& accessors = glb.document.at("accessors");
    const json& points = accessors.at(primitive.at("attributes").at("POSITION").get<std::size_t>());
    if (!primitive.contains("indices")) {
      EXPECT_EQ(primitive.at("mode"), 3);
      continue;
    }
    const json& indices = accessors.at(primitive.at("indices").get<std::size_t>());
    EXPECT_EQ(indices.at("count"), 36u);
    const json& view =
        glb.document.at("bufferViews").at(indices.at("bufferView").get<std::size_t>());
    EXPECT_EQ(view.at("byteLength"), 36u * 4u);
    for (std::size_t i = 0; i < 36; ++i)
      EXPECT_LT(word_at(glb.bytes, view.at("byteOffset").get<std::size_t>() + 4 * i),
                points.at("count").get<std::uint32_t>());
  }
}

// What a program that plays the file shows at its times is the body there, in its axes.
TEST(Gltf, MorphTargetsAndWeightsGiveEveryFrame) {
  const GltfScene scene = moving_cube();
  const Glb glb = write_and_parse(scene);
  const json& primitive = glb.document.at("meshes").at(0).at("primitives").at(0);
  const json& animation = glb.document.at("animations").at(0);
  ASSERT_EQ(animation.at("channels").size(), 1u);  // the other bodies are still
  EXPECT_EQ(animation.at("channels").at(0).at("target"), json({{"node", 0}, {"path", "weights"}}));
  const json& sampler = animation.at("samplers").at(0);
  EXPECT_EQ(floats_of(glb, sampler.at("input")), (std::vector<float>{0.0F, 0.5F, 2.0F}));
  const std::vector<float> weights = floats_of(glb, sampler.at("output"));
  const json& targets = primitive.at("targets");
  ASSERT_EQ(targets.size(), 2u);
  ASSERT_EQ(weights.size(), 3u * targets.size());
  const std::vector<float> base = floats_of(glb, primitive.at("attributes").at("POSITION"));
  const GltfBody& body = scene.bodies[0];
  for (std::size_t time = 0; time < 3; ++time) {
    const std::vector<Vec3>& wanted = time == 0 ? body.mesh.vertices : body.later[time - 1];
    std::vector<float> shown = base;
    for (std::size_t t = 0; t < 2; ++t) {
      const std::vector<float> way = floats_of(glb, targets.at(t).at("POSITION"));
      ASSERT_EQ(way.size(), base.size());
      for (std::size_t i = 0; i < shown.size(); ++i) shown[i] += weights[2 * time + t] * way[i];
    }
    for (std::size_t v = 0; v < wanted.size(); ++v) {
      EXPECT_NEAR(shown[3 * v], wanted[v].x / 1000.0, 1e-9);       // to the left
      EXPECT_NEAR(shown[3 * v + 1], wanted[v].z / 1000.0, 1e-9);   // up: the head
      EXPECT_NEAR(shown[3 * v + 2], -wanted[v].y / 1000.0, 1e-9);  // to the front
    }
  }
}

TEST(Gltf, NormalsAreUnitVectors) {
  const Glb glb = write_and_parse(moving_cube());
  const std::vector<float> normals = floats_of(
      glb, glb.document.at("meshes").at(0).at("primitives").at(0).at("attributes").at("NORMAL"));
  for (std::size_t v = 0; v < normals.size(); v += 3)
    EXPECT_NEAR(
        normals[v] * normals[v] + normals[v + 1] * normals[v + 1] + normals[v + 2] * normals[v + 2],
        1.0, 1e-5);
}

TEST(Gltf, TextFileHoldsTheSameScene) {
  const TemporaryFolder folder;
  write_gltf(folder / "scene.gltf", moving_cube());
  json text = json::parse(read_text(folder / "scene.gltf"));
  const Glb glb = write_and_parse(moving_cube());
  EXPECT_EQ(text.at("buffers").at(0).at("uri"),
            "data:application/octet-stream;base64," + base64(glb.bytes));
  text["buffers"][0].erase("uri");
  EXPECT_EQ(text, glb.document);
}

TEST(Gltf, SurfacesComeBackInMetresAtTheirFirstTime) {
  const TemporaryFolder folder;
  GltfScene scene = moving_cube();
  for (const char* name : {"scene.glb", "scene.gltf"}) {
    write_gltf(folder / name, scene);
    const TriangleMesh both = read_surface(folder / name).mesh;
    ASSERT_EQ(both.vertices.size(), 16U) << name;
    EXPECT_EQ(both.triangles.size(), 24U) << name;
    EXPECT_NEAR(enclosed_volume(both), 2e-9, 1e-15) << name;  // outwards, so positive
    for (const TriangleMesh& cube : {make_cube(), make_cube({5, 0, 0})})
      for (const Vec3& p : cube.vertices)
        EXPECT_TRUE(std::ranges::any_of(both.vertices, [&](const Vec3& q) {
          return distance(1e-3 * p, q) < 1e-9;
        })) << name;
  }
}

TEST(Gltf, MeshesAreReadWhereTheirNodesPlaceThem) {
  const TemporaryFolder folder;
  // The triangle (0, 0, 0), (1, 0, 0), (0, 1, 0) in a node twice as large, in one 10 to the left.
  const float points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::string bytes(reinterpret_cast<const char*>(points), sizeof points);
  const auto written = [&](const std::string& more) {
    write_text_atomically(
        folder / "t.gltf",
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[)"
        R"({"translation":[10,0,0],"children":[1]},{"mesh":0,"scale":[2,2,2]}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":4}]}],)"
        R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
        R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":)"
        R"("data:application/octet-stream;base64,)" +
            base64(bytes) + "\"}]" + more + "}");
    return folder / "t.gltf";
  };
  EXPECT_EQ(read_surface(written("")).mesh.vertices,
            (std::vector<Vec3>{{10, 0, 0}, {12, 0, 0}, {10, 0, 2}}));
  EXPECT_THAT(
      [&] { read_surface(written(R"(,"extensionsRequired":["KHR_draco_mesh_compression"])")); },
      testing::ThrowsMessage<InputError>(testing::HasSubstr("compress")));
}

TEST(Gltf, FramesOfDifferentMeshesAreRefusedAndNothingIsWritten) {
  const TemporaryFolder folder;
  GltfScene scene = moving_cube();
  scene.bodies[0].later[1].pop_back();
  EXPECT_THROW(write_gltf(folder / "scene.glb", scene), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "scene.glb"));
}

TEST(ObjFile, ComesBackPointByPoint) {
  const TemporaryFolder folder;
  TriangleMesh mesh = viewer::test::make_tube({});
  write_surface(folder / "tube.obj", {mesh, {}, {}});
  const SurfaceData back = read_surface(folder / "tube.obj");
  EXPECT_EQ(back.mesh.vertices, mesh.vertices);
  EXPECT_EQ(back.mesh.triangles, mesh.triangles);
  EXPECT_EQ(back.unit, LengthUnit::mm);
}

}  // namespace
}  // namespace angio::formats
