#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/error.hpp"
#include "datasets/detail/anatomy.hpp"
#include "datasets/phantom.hpp"

namespace angio::datasets {
namespace {

using ::testing::HasSubstr;

std::string refusal_of(std::string_view description) {
  try {
    parse_phantom(description);
  } catch (const OptionError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(PhantomOptions, DefaultsAreValid) { EXPECT_NO_THROW(PhantomOptions().validate()); }

TEST(PhantomOptions, EveryNameOfTheContractIsKnown) {
  for (const char* name : {"straight", "unilateral", "bilateral", "ytype", "coronary", "cloth",
                           "concentric", "tandem", "helix", "torus", "trifurcation", "aneurysm"})
    EXPECT_NO_THROW(parse_phantom(name)) << name;
}

TEST(PhantomOptions, ADescriptionFillsEveryField) {
  const PhantomOptions options = parse_phantom(
      "phantom:unilateral,stenosis=70,radius=1.25,length=35,spacing=0.25,noise=0.05,blur=0.4,"
      "oblique=30,"
      "seed=18446744073709551615");
  EXPECT_EQ(options.name, "unilateral");
  EXPECT_EQ(options.stenosis_percent, 70.0);
  EXPECT_EQ(options.radius_mm, 1.25);
  EXPECT_EQ(options.length_mm, 35.0);
  EXPECT_EQ(options.spacing_mm, 0.25);
  EXPECT_EQ(options.noise_sd, 0.05);
  EXPECT_EQ(options.blur_mm, 0.4);
  EXPECT_EQ(options.oblique_degrees, 30.0);
  EXPECT_EQ(options.seed, 18446744073709551615ULL);
}

TEST(PhantomOptions, ThePrefixMayBeLeftOut) {
  EXPECT_EQ(parse_phantom("ytype,seed=3").seed, parse_phantom("phantom:ytype,seed=3").seed);
}

TEST(PhantomOptions, AMisspeltNameOrKeyIsAnsweredWithTheNearest) {
  EXPECT_THAT(refusal_of("coronery"), HasSubstr("Did you mean \"coronary\"?"));
  EXPECT_THAT(refusal_of("coronary,stenossis=3"), HasSubstr("Did you mean \"stenosis\"?"));
}

TEST(PhantomOptions, AStenosisThatIsNoNumberIsAskedForInPercent) {
  EXPECT_THAT(refusal_of("coronary,stenosis=sixty"), HasSubstr("percentage"));
  EXPECT_THAT(refusal_of("coronary,stenosis=sixty"), HasSubstr("stenosis=60"));
  EXPECT_THAT(refusal_of("coronary,radius=wide"), HasSubstr("radius=0.5"));
}

TEST(PhantomOptions, NoiseGivenInPercentIsRefusedWithTheRightUnit) {
  EXPECT_THAT(refusal_of("coronary,noise=10"), HasSubstr("0.1 means 10 %"));
}

TEST(PhantomOptions, WhatIsNotANumberOrOutOfRangeIsRefused) {
  for (const char* bad :
       {"coronary,stenosis=", "coronary,stenosis=abc", "coronary,stenosis=60x", "coronary,stenosis",
        "coronary,", "coronary,stenosis=96", "coronary,stenosis=-1", "coronary,stenosis=nan",
        "coronary,spacing=0", "coronary,spacing=inf", "coronary,radius=100", "coronary,length=1",
        "coronary,seed=-1", "coronary,seed=1.5", "coronary,blur=9", "coronary,oblique=91", "",
        "phantom:"})
    EXPECT_NE(refusal_of(bad), "accepted") << bad;
}

TEST(PhantomOptions, ALengthTooShortForTheRadiusIsRefusedWithTheLeastOne) {
  EXPECT_THAT(refusal_of("unilateral,radius=3,length=20"), HasSubstr("at least 27"));
}

TEST(PhantomOptions, AWideVesselAloneGetsALengthThatSuitsIt) {
  for (const char* name : {"straight", "unilateral", "bilateral", "ytype", "coronary", "tandem",
                           "helix", "torus", "trifurcation", "aneurysm"})
    for (const char* size : {",radius=6", ",length=20", ",radius=0.5", ",length=150"})
      EXPECT_NO_THROW(
          datasets::detail::make_anatomy(parse_phantom(std::string(name) + ",stenosis=30" + size)))
          << name << size;
}

}  // namespace
}  // namespace angio::datasets
