#include <gtest/gtest.h>

#include <set>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "pipeline/case/stage.hpp"
#include "pipeline/config/balloon_file.hpp"
#include "pipeline/config/config.hpp"
#include "run_program.hpp"

namespace angio::pipeline {
namespace {

std::string message_of(const std::function<void()>& act, ExitCode expected) {
  try {
    act();
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), expected) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

TEST(Config, DefaultsAreValid) {
  const Config config;
  EXPECT_NO_THROW(config.validate());
}

TEST(Config, EveryKeyIsUniqueAndExplained) {
  Config config;
  std::set<std::string> keys;
  for (const Setting& setting : settings(config)) {
    EXPECT_TRUE(keys.insert(setting.key).second) << setting.key;
    EXPECT_FALSE(setting.help.empty()) << setting.key;
  }
}

TEST(Config, WhatIsWrittenAsTomlReadsBackTheSame) {
  test::CommandFolder folder;
  Config config;
  apply_setting(config, "segmentation.seeds_lps_mm=[[1.5, -2.25, 3], [0.1, 0.2, 0.3]]");
  apply_setting(config, "segmentation.region_lps_mm=[[-1.5, -2, -3], [4, 5, 6.5]]");
  apply_setting(config, "segmentation.intensity_min=120.5");
  apply_setting(config, "centerline.inlet_lps_mm=[1, 2, 3]");
  apply_setting(config, "balloon.material=polyurethane");
  apply_setting(config, "inflation.peak_pressure_atm=11.1");
  apply_setting(config, "simulation.sweeps=33");
  const std::string text = to_toml(config);
  write_text_atomically(folder / "case.toml", text);
  Config again;
  load_config(again, folder / "case.toml");
  EXPECT_EQ(to_toml(again), text);
  EXPECT_EQ(again.segmentation.seeds_lps_mm.at(1), (Vec3{0.1, 0.2, 0.3}));
  ASSERT_TRUE(again.segmentation.region_lps_mm);
  EXPECT_EQ(again.segmentation.region_lps_mm->low, (Vec3{-1.5, -2, -3}));
  EXPECT_EQ(again.segmentation.region_lps_mm->high, (Vec3{4, 5, 6.5}));
  EXPECT_EQ(again.segmentation.intensity_min, 120.5);
  EXPECT_EQ(again.simulation.balloon.name, "polyurethane");
}

TEST(Config, AnUnknownKeyNamesTheNearestOne) {
  Config config;
  EXPECT_NE(message_of([&] { apply_setting(config, "ballon.length_mm=20"); }, ExitCode::bad_config)
                .find("did you mean balloon.length_mm?"),
            std::string::npos);
}

TEST(Config, AFileWithAnUnknownKeyIsRefusedAsAWhole) {
  test::CommandFolder folder;
  for (const char* text : {"[balloon]\nlenth_mm = 3.0\n", "length_mm = 3.0\n",
                           "[balloon]\nlength_mm = [1\n", "[baloon]\nlength_mm = 3.0\n"}) {
    write_text_atomically(folder / "bad.toml", text);
    Config config;
    message_of([&] { load_config(config, folder / "bad.toml"); }, ExitCode::bad_config);
  }
}

TEST(Config, ValuesOfTheWrongKindAreRefused) {
  for (const char* assignment :
       {"balloon.length_mm=long", "simulation.sweeps=2.5", "segmentation.seeds_lps_mm=[1, 2]",
        "input.allow_lossy=3", "balloon.length_mm=nan", "centerline.inlet_lps_mm=[1, 2]"}) {
    Config config;
    message_of([&] { apply_setting(config, assignment); }, ExitCode::bad_config);
  }
}

TEST(Config, ValuesOutsideTheirRangeAreRefused) {
  for (const char* assignment :
       {"balloon.ring_count=1", "simulation.frame_s=-1", "mesh.edges_per_circumference=1",
        "segmentation.scale_count=0", "lesion.min_stenosis_percent=200", "simulation.write_every=0",
        "inflation.peak_pressure_atm=1000", "inflation.peak_pressure_atm=-3", "balloon.wall_mm=-1",
        "simulation.contact_distance_mm=-1", "inflation.rated_burst_atm=-1"}) {
    Config config;
    apply_setting(config, assignment);
    message_of([&] { config.validate(); }, ExitCode::bad_config);
  }
}

TEST(Config, ABalloonOfAnotherSizeThanItsChartIsRefused) {
  Config config;
  apply_balloon(config, balloon_catalogue("").front());
  EXPECT_NO_THROW(config.validate());
  const double nominal = config.balloon.nominal_diameter_mm;
  for (const double other : {0.6 * nominal, 1.5 * nominal}) {
    config.balloon.nominal_diameter_mm = other;
    EXPECT_NE(message_of([&] { config.validate(); }, ExitCode::bad_config)
                  .find("is that of another balloon"),
              std::string::npos);
  }
  config.simulation.balloon.chart.clear();
  EXPECT_NO_THROW(config.validate());
}

TEST(Config, EndsThatAreNotOfAllViewsThatAreNamedAreRefused) {
  Config config;
  config.view_ends = {1, 2, 3, 4, 5, 6, 7, 8};
  EXPECT_NO_THROW(config.validate());
  config.input.views = "2,1";
  EXPECT_NO_THROW(config.validate());
  config.input.views = "2,1,3";
  EXPECT_NE(message_of([&] { config.validate(); }, ExitCode::bad_config)
                .find("8 numbers for the 3 views"),
            std::string::npos);
}

TEST(Config, PresetsHoldKnownKeysOnly) {
  for (const std::string& preset : preset_names()) {
    Config config;
    EXPECT_NO_THROW(apply_preset(config, preset)) << preset;
    EXPECT_NO_THROW(config.validate()) << preset;
  }
  Config config;
  message_of([&] { apply_preset(config, "no-such-preset"); }, ExitCode::bad_config);
}

TEST(Stages, AWrongNameIsAUsageErrorThatHelps) {
  for (const auto& [word, stage] : {std::pair{"mesh", "meshing"},
                                    {"segment", "segmentation"},
                                    {"simulate", "simulation"},
                                    {"reprot", "report"}})
    EXPECT_NE(message_of([word = word] { parse_stage(word); }, ExitCode::usage)
                  .find(std::string("did you mean ") + stage + "?"),
              std::string::npos)
        << word;
  EXPECT_EQ(message_of([] { parse_stage("balloon"); }, ExitCode::usage).find("did you mean"),
            std::string::npos);
  EXPECT_EQ(parse_stage("simulation"), Stage::simulation);
}

}  // namespace
}  // namespace angio::pipeline
