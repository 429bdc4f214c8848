#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>

#include "core/atomic_file.hpp"
#include "testing/temporary_folder.hpp"
#include "testing/viewer/report_content.hpp"
#include "viewer/detail/report_scene.hpp"
#include "viewer/detail/scene_payload.hpp"
#include "viewer/report.hpp"

namespace angio::viewer::detail {
namespace {
using angio::test::TemporaryFolder;
using nlohmann::json;

/// As viewer/page/scene.js reads it.
struct Read {
  json header;
  std::string planes;

  explicit Read(const std::string& bytes) {
    std::size_t length = 0;
    for (std::size_t byte = 4; byte-- > 0;) length = length << 8 | std::uint8_t(bytes.at(byte));
    header = json::parse(bytes.substr(4, length));
    planes = bytes.substr(4 + length);
  }
  [[nodiscard]] std::vector<std::int32_t> integers(const json& of) const {
    const std::size_t offset = of.at("offset"), count = of.at("count"), stride = of.at("stride");
    std::vector<std::int32_t> out(count);
    for (std::size_t i = 0; i < count; ++i) {
      std::uint32_t word = 0;
      for (std::size_t plane = 4; plane-- > 0;)
        word = word << 8 | std::uint8_t(planes.at(offset + plane * count + i));
      const std::uint32_t step = word >> 1 ^ (~(word & 1u) + 1u);
      out[i] = std::int32_t(i < stride ? step : step + std::uint32_t(out[i - stride]));
    }
    return out;
  }
  [[nodiscard]] Vec3 point(const json& points, std::size_t index) const {
    const std::vector<std::int32_t> whole = integers(points.at("array"));
    const double quantum = points.at("quantum");
    const auto along = [&](std::size_t k) {
      return points.at("at").at(k).get<double>() + quantum * whole.at(3 * index + k);
    };
    return {along(0), along(1), along(2)};
  }
};

std::string from_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  std::uint32_t word = 0;
  int bits = 0;
  for (const char c : text.substr(0, text.find('='))) {
    word = word << 6 | std::uint32_t(digits.find(c));
    if ((bits += 6) >= 8) out += char(word >> (bits -= 8) & 0xffu);
  }
  return out;
}

std::string unpacked(const std::string& text) {
  const std::string in = from_base64(text);
  std::string out(std::size_t(1) << 24, '\0');
  uLongf size = out.size();
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(out.data()), &size,
                       reinterpret_cast<const Bytef*>(in.data()), in.size()),
            Z_OK);
  out.resize(size);
  return out;
}

std::string element(const std::string& page, const std::string& id) {
  const std::string begin = "id=\"" + id + "\">";
  const std::size_t at = page.find(begin) + begin.size();
  return page.substr(at, page.find('<', at) - at);
}

/// Two frames, in the second of which the wall is a tenth of a millimetre wider.
ReportContent content_with_a_course() {
  ReportContent content = test::make_report_content();
  for (int i = 0; i < 2; ++i) {
    CourseFrame frame{0.5 * i, "inflate", 4.0 * i, i == 1, content.moments.front()};
    for (Vec3& v : frame.shape.wall.vertices)
      v = {v.x * (1.0 + 0.2 * i), v.y * (1.0 + 0.2 * i), v.z};
    content.course.push_back(frame);
  }
  return content;
}

TEST(ScenePayload, HoldsEveryIntegerAndEveryPlace) {
  constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min(),
                         kMost = std::numeric_limits<std::int32_t>::max();
  const std::vector<std::int32_t> values{0, -1, 5, kMost, kLeast, 7, kLeast, kMost, 0};
  const std::vector<std::vector<Vec3>> places{{{1.0, -2.0, 300.0}, {1.5, 2.0, -0.003}},
                                              {{1.1, -2.2, 300.4}, {-9.5, 2.1, 0.0}}};
  ScenePayload payload;
  json header;
  for (const std::size_t stride : {1U, 3U, 9U})
    header["values"].push_back(payload.add_integers(values, stride));
  header["points"] = payload.add_points(places);
  const Read read(payload.bytes(header));
  for (const json& of : read.header.at("values")) EXPECT_EQ(read.integers(of), values);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LE(distance(read.point(read.header.at("points"), i), places[i / 2][i % 2]),
              0.51 * std::sqrt(3.0) * ScenePayload::kQuantum);
}

TEST(ReportScene, HoldsTheCourseToTheQuantum) {
  const ReportContent content = content_with_a_course();
  const Read read(unpacked(element(scene_section(content), "scene-data")));
  ASSERT_EQ(read.header.at("frames").size(), content.course.size());
  EXPECT_EQ(read.header.at("frames").at(1).at("pressure_atm"), 4.0);
  const json& wall = read.header.at("wall");
  const std::size_t count = wall.at("vertex_count");
  ASSERT_EQ(count, content.course.front().shape.wall.vertices.size());
  for (const std::size_t frame : {0u, 1u})
    for (const std::size_t v : {std::size_t(0), count / 2, count - 1})
      EXPECT_LE(distance(read.point(wall.at("points"), frame * count + v),
                         content.course[frame].shape.wall.vertices[v]),
                ScenePayload::kQuantum);
  EXPECT_EQ(read.integers(wall.at("triangles")).size(),
            3 * content.course.front().shape.wall.triangles.size());
}

TEST(ReportScene, IsOfTheTreeAloneBeforeTheSimulation) {
  ReportContent content = test::make_report_content();
  content.course.clear();
  const Read read(unpacked(element(scene_section(content), "scene-data")));
  EXPECT_FALSE(read.header.contains("wall"));
  EXPECT_EQ(read.integers(read.header.at("tree").at("triangles")).size(),
            3 * content.lumen.triangles.size());
  content.lumen = {};
  EXPECT_EQ(scene_section(content), "");
}

/// What a page says about itself once a script has been added to it, as Chromium runs it.
std::string run_in_chromium(const std::string& page, const std::string& script) {
  const TemporaryFolder folder;
  write_text_atomically(folder / "page.html", page + "<script>" + script + "</script>");
  const std::string command = "cd '" + folder.path().string() +
                              "' && timeout 120 chromium --headless --no-sandbox "
                              "--user-data-dir=profile --use-gl=angle --use-angle=swiftshader "
                              "--enable-unsafe-swiftshader --virtual-time-budget=60000 "
                              "--dump-dom page.html > dom.html 2> log";
  EXPECT_EQ(std::system(command.c_str()), 0) << read_text(folder / "log");
  return element(read_text(folder / "dom.html"), "answer");
}

TEST(ReportScene, IsDrawnAndFollowsTheTimeInABrowser) {
  if (std::system("command -v chromium > /dev/null") != 0)
    GTEST_SKIP() << "there is no chromium (apt install chromium)";
  const TemporaryFolder folder;
  write_report(folder.path(), content_with_a_course());
  const std::string answer = run_in_chromium(read_text(folder / "index.html"), R"js(
    const faults = [];
    addEventListener("error", (event) => faults.push(event.message));
    addEventListener("securitypolicyviolation", (event) => faults.push(event.violatedDirective));
    console.error = console.warn = (...words) => faults.push(words.join(" "));
    const say = (text) => {
      const out = document.createElement("p");
      out.id = "answer";
      out.textContent = text;
      document.body.prepend(out);
    };
    const picture = (scene) => {
      scene.render();
      const canvas = document.querySelector(".scene-view canvas");
      const copy = document.createElement("canvas");
      [copy.width, copy.height] = [canvas.width, canvas.height];
      const pen = copy.getContext("2d");
      pen.drawImage(canvas, 0, 0);
      return pen.getImageData(0, 0, copy.width, copy.height).data;
    };
    const changed = (a, b) => {
      let count = 0;
      for (let i = 0; i < a.length; i += 4) count += a[i] !== b[i] || a[i + 1] !== b[i + 1];
      return count;
    };
    document.getElementById("scene-open").click();
    const wait = setInterval(() => {
      const state = document.getElementById("scene").dataset.state;
      if (!state) return;
      clearInterval(wait);
      if (state !== "open") return say(document.getElementById("scene").textContent);
      const scene = window.angioSceneView;
      scene.showFrame(0);
      const first = picture(scene), again = picture(scene);
      scene.showFrame(1);
      const second = picture(scene);
      scene.setVisible("balloon", false);
      scene.setVisible("wall", false);
      scene.setVisible("tree", false);
      const less = picture(scene);
      say(JSON.stringify({ same: changed(first, again), time: changed(first, second),
                           layers: changed(second, less), faults }));
    }, 50);
  )js");
  const json said = json::parse(answer, nullptr, false);
  ASSERT_FALSE(said.is_discarded()) << answer;
  EXPECT_EQ(said.at("same"), 0);
  EXPECT_GT(said.at("time"), 1000);
  EXPECT_GT(said.at("layers"), 10000);
  EXPECT_EQ(said.at("faults"), json::array());
}

TEST(ReportScene, ItsProgramIsMadeOfTheseSources) {
  const std::filesystem::path page = ANGIO_PAGE_FOLDER;
  const TemporaryFolder folder;
  const std::string command = "cat '" + (page / "index.js").string() + "' '" +
                              (page / "scene.js").string() + "' | sha256sum > '" +
                              (folder / "sum").string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string sum = read_text(folder / "sum").substr(0, 64);
  EXPECT_NE(read_text(page / "scene.min.js").substr(0, 300).find(sum), std::string::npos)
      << "make it anew: npm ci && npm run build, in viewer/page";
}

}  // namespace
}  // namespace angio::viewer::detail
