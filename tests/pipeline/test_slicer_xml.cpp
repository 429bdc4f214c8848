#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tinyxml2.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "run_program.hpp"

// The rules of the Slicer Execution Model's schema, on what each command says of itself.
namespace angio::test {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

const std::vector<std::string> kCommands{
    "run",   "inspect", "segment",   "centerline", "mesh",    "simulate", "report",     "view",
    "live",  "film",    "figure",    "convert",    "phantom", "inflate",  "experiment", "batch",
    "sweep", "verify",  "recommend", "fit",        "send",    "fetch",    "doctor"};

const std::set<std::string> kTypes{
    "integer",   "double", "boolean",       "string",         "string-enumeration", "file",
    "directory", "image",  "double-vector", "integer-vector", "string-vector"};

std::string text_of(const tinyxml2::XMLElement* parent, const char* name) {
  const tinyxml2::XMLElement* child = parent->FirstChildElement(name);
  return child != nullptr && child->GetText() != nullptr ? child->GetText() : "";
}

struct Parameter {
  std::string type, name, flag, longflag, index, value;
};

std::vector<Parameter> parameters_of(const std::string& xml) {
  tinyxml2::XMLDocument document;
  EXPECT_EQ(document.Parse(xml.c_str()), tinyxml2::XML_SUCCESS) << xml.substr(0, 400);
  const tinyxml2::XMLElement* root = document.RootElement();
  if (root == nullptr) return {};
  EXPECT_STREQ(root->Name(), "executable");
  for (const char* needed : {"category", "title", "description", "version", "license"})
    EXPECT_NE(text_of(root, needed), "") << needed;
  std::vector<Parameter> found;
  for (const auto* group = root->FirstChildElement("parameters"); group != nullptr;
       group = group->NextSiblingElement("parameters")) {
    EXPECT_NE(text_of(group, "label"), "");
    for (const auto* item = group->FirstChildElement(); item != nullptr;
         item = item->NextSiblingElement()) {
      const std::string type = item->Name();
      if (type == "label" || type == "description") continue;
      EXPECT_TRUE(kTypes.contains(type)) << type;
      Parameter one{type,
                    text_of(item, "name"),
                    text_of(item, "flag"),
                    text_of(item, "longflag"),
                    text_of(item, "index"),
                    text_of(item, "default")};
      EXPECT_NE(text_of(item, "label"), "") << one.name;
      EXPECT_NE(text_of(item, "description"), "") << one.name;
      if (type == "file" || type == "directory" || type == "image") {
        EXPECT_THAT((std::vector<std::string>{"input", "output"}),
                    testing::Contains(text_of(item, "channel")))
            << one.name;
      }
      std::set<std::string> elements;
      for (const auto* e = item->FirstChildElement("element"); e != nullptr;
           e = e->NextSiblingElement("element"))
        elements.insert(e->GetText());
      EXPECT_EQ(type == "string-enumeration", !elements.empty()) << one.name;
      if (type == "string-enumeration" && !one.value.empty()) {
        EXPECT_TRUE(elements.contains(one.value)) << one.name << " is " << one.value;
      }
      if (type == "string-enumeration" && one.value.empty()) one.value = *elements.begin();
      if (const auto* range = item->FirstChildElement("constraints"); range != nullptr) {
        EXPECT_LT(std::stod(text_of(range, "minimum")), std::stod(text_of(range, "maximum")));
        if (one.value.empty()) one.value = text_of(range, "maximum");
      }
      found.push_back(one);
    }
  }
  return found;
}

class SlicerXml : public testing::TestWithParam<std::string> {};

TEST_P(SlicerXml, IsWellFormedAndNamesEachParameterOnce) {
  const ProgramResult result = run_program(GetParam() + " --xml");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error, "");
  std::set<std::string> names, flags;
  int positional_count = 0;
  for (const Parameter& one : parameters_of(result.out)) {
    EXPECT_EQ(one.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_"),
              std::string::npos)
        << one.name;
    EXPECT_TRUE(names.insert(one.name).second) << one.name << " twice";
    for (const std::string& flag : {one.flag, one.longflag})
      if (!flag.empty()) {
        EXPECT_TRUE(flags.insert(flag).second) << flag << " twice";
      }
    EXPECT_NE(one.index.empty(), one.flag.empty() && one.longflag.empty())
        << one.name << " has a place or flags, not both";
    if (!one.index.empty()) {
      EXPECT_EQ(one.index, std::to_string(positional_count++));
    }
  }
}

TEST_P(SlicerXml, EveryFlagIsOneThatTheCommandTakes) {
  const std::string help = run_program(GetParam() + " --help").out;
  std::string all;
  for (const Parameter& one : parameters_of(run_program(GetParam() + " --xml").out)) {
    if (!one.index.empty()) continue;
    const std::string flag = one.longflag.empty() ? one.flag : one.longflag;
    EXPECT_THAT(help, HasSubstr(flag)) << "of " << GetParam();
    std::string value;
    if (one.type == "integer" || one.type == "double") value = one.value.empty() ? "3" : one.value;
    if (one.type.ends_with("-vector")) value = "1,2";
    if (one.type == "string-enumeration") value = one.value;
    if (one.type == "string" || one.type == "file" || one.type == "directory")
      value = one.value.empty() ? "x" : one.value;
    all += flag + (value.empty() ? " " : " '" + value + "' ");
  }
  const ProgramResult result = run_program(GetParam() + " " + all + "--help");
  EXPECT_EQ(result.exit_code, 0) << GetParam() << " " << all << ": " << result.error;
}

INSTANTIATE_TEST_SUITE_P(Commands, SlicerXml, testing::ValuesIn(kCommands),
                         [](const auto& tested) { return tested.param; });

TEST(SlicerModules, AreLinksNamedAfterTheirCommand) {
  const CommandFolder folder;
  fs::create_symlink(ANGIO_PROGRAM, folder.path() / "angio-inspect");
  const std::string link = folder / "angio-inspect";
  const std::string command = link + " --xml > " + (folder / "xml") + " 2> " + (folder / "error");
  ASSERT_EQ(std::system(command.c_str()), 0) << file_text(folder.path() / "error");
  EXPECT_EQ(file_text(folder.path() / "xml"), run_program("inspect --xml").out);
  const int status =
      std::system((link + " " + (folder / "nothing") + " 2> " + (folder / "error")).c_str());
  EXPECT_EQ(WEXITSTATUS(status), 66) << file_text(folder.path() / "error");
}

TEST(SlicerXmlOption, AloneIsNotForTheWholeProgram) {
  EXPECT_EQ(run_program("--xml").exit_code, 64);
  EXPECT_EQ(run_program("nothing --xml").exit_code, 64);
}

}  // namespace
}  // namespace angio::test
