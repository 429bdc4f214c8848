#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/atomic_file.hpp"
#include "testing/temporary_folder.hpp"
#include "testing/viewer/report_content.hpp"
#include "viewer/report.hpp"

// The page as Chromium shows it, in a frame as wide as a desktop's or a phone's.
namespace angio::viewer {
namespace {
using angio::test::TemporaryFolder;
using nlohmann::json;

constexpr int kDesktop = 1100, kPhone = 375;  // [px]

/// What the page says by `say(value)`.
json ask(const std::string& page, const std::string& script, int width,
         const std::string& flags = "") {
  const TemporaryFolder folder;
  write_text_atomically(folder / "page.html",
                        page +
                            "<script>const say = (value) => parent.postMessage("
                            "JSON.stringify(value).replace(/[^\\x20-\\x7e]/g, \"?\"), \"*\");" +
                            script + "</script>");
  write_text_atomically(folder / "frame.html",
                        "<pre id=\"answer\"></pre><iframe src=\"page.html\" height=\"900\" "
                        "style=\"border:0\" width=\"" +
                            std::to_string(width) +
                            "\"></iframe><script>addEventListener(\"message\", (event) => {"
                            "document.getElementById(\"answer\").textContent = btoa("
                            "event.data); });</script>");
  const std::string command = "cd '" + folder.path().string() +
                              "' && timeout 120 chromium --headless --no-sandbox "
                              "--user-data-dir=profile --use-gl=angle --use-angle=swiftshader "
                              "--enable-unsafe-swiftshader --window-size=1300,1000 "
                              "--virtual-time-budget=20000 " +
                              flags +
                              " --dump-dom frame.html 2> log | sed -n "
                              "'s/.*<pre id=\"answer\">\\([^<]*\\)<.*/\\1/p' | base64 -d > answer";
  EXPECT_EQ(std::system(command.c_str()), 0) << read_text(folder / "log");
  return json::parse(read_text(folder / "answer"), nullptr, false);
}

class ReportAccess : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const TemporaryFolder folder;
    write_report(folder.path(), test::make_report_content());
    page() = read_text(folder / "index.html");
  }
  void SetUp() override {
    if (std::system("command -v chromium > /dev/null") != 0)
      GTEST_SKIP() << "there is no chromium (apt install chromium)";
  }
  static std::string& page() {
    static std::string text;
    return text;
  }
  static std::string checks() { return read_text(ANGIO_PAGE_CHECKS); }
};

TEST_F(ReportAccess, NothingStandsInTheWayOnADesktopOrAPhoneInLightOrDark) {
  for (const int width : {kDesktop, kPhone})
    for (const std::string flags : {"", "--blink-settings=preferredColorScheme=0"}) {
      const json said = ask(page(),
                            checks() +
                                "say({dark: matchMedia(\"(prefers-color-scheme:dark)\").matches, "
                                "width: innerWidth, faults: pageFaults()});",
                            width, flags);
      ASSERT_TRUE(said.is_object()) << said;
      EXPECT_EQ(said.at("dark"), !flags.empty());
      EXPECT_EQ(said.at("width"), width);
      EXPECT_EQ(said.at("faults"), json::array()) << width << " px " << flags;
    }
}

TEST_F(ReportAccess, TheScenesControlsHaveNamesAndAreReachedByKeys) {
  const json said = ask(page(), checks() + R"js(
    document.getElementById("scene-open").click();
    const wait = setInterval(() => {
      const state = document.getElementById("scene").dataset.state;
      if (!state) return;
      clearInterval(wait);
      say({state, controls: document.querySelectorAll("#scene button, #scene input").length,
           faults: pageFaults()});
    }, 50);)js",
                        kPhone);
  ASSERT_TRUE(said.is_object()) << said;
  EXPECT_EQ(said.at("state"), "open");
  EXPECT_GE(said.at("controls"), 5);
  EXPECT_EQ(said.at("faults"), json::array());
}

TEST_F(ReportAccess, TheSliderWalksAlongTheSections) {
  const json said = ask(page(), R"js(
    const slider = document.getElementById("section-place");
    const shown = () => [...document.querySelectorAll("#section-view g")].map((g, i) => (g.hasAttribute("display") ? -1 : i)).filter((i) => i >= 0);
    const before = shown(), text = document.getElementById("section-text").textContent;
    slider.value = 3;
    slider.dispatchEvent(new Event("input"));
    say({hidden: document.getElementById("section-slider").hidden, before, after: shown(),
         changed: text !== document.getElementById("section-text").textContent,
         y: Number(document.querySelector("#section-view image").getAttribute("y")),
         size: Number(document.getElementById("section-view").dataset.size)});)js",
                        kDesktop);
  ASSERT_TRUE(said.is_object()) << said;
  EXPECT_EQ(said.at("hidden"), false);
  EXPECT_EQ(said.at("before"), json::array({16}));
  EXPECT_EQ(said.at("after"), json::array({3}));
  EXPECT_EQ(said.at("changed"), true);
  EXPECT_NEAR(said.at("y").get<double>(), -3.5 * said.at("size").get<double>(), 0.02);
}

TEST_F(ReportAccess, TheChecksFindWhatIsWrong) {
  const json said =
      ask("<!DOCTYPE html><h1>a</h1><h3 style=\"color:#999\">b</h3><img src=\"data:,\">"
          "<button></button><p id=\"c\"></p><p id=\"c\"></p><svg></svg>"
          "<div style=\"width:2000px\">d</div><input aria-label=\"e\" tabindex=\"2\" "
          "style=\"outline:none\">",
          checks() + "say(pageFaults());", kPhone);
  ASSERT_TRUE(said.is_array()) << said;
  for (const std::string fault : {"no name: <button", "no name: <svg", "no alt", "twice: id c",
                                  "a level is left out before: b", "contrast 2.85: b",
                                  "scrolls sideways", "not in the order", "focus is not seen"})
    EXPECT_NE(said.dump().find(fault), std::string::npos) << fault << " in " << said;
}

}  // namespace
}  // namespace angio::viewer
