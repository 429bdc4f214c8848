#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "pipeline/case/dicom_measurements.hpp"

namespace angio::pipeline {
namespace {
using nlohmann::json;

json treated() {
  return {{"status", "done"},
          {"lesion",
           {{"mld_mm", 1.2},
            {"mla_mm2", 1.3},
            {"reference_diameter_mm", 3.0},
            {"reference_rule", "tree"},
            {"diameter_stenosis_percent", 60.0},
            {"area_stenosis_percent", nullptr}}},
          {"balloon", {{"nominal_diameter_mm", 3.0}, {"peak_pressure_atm", 8.0}}},
          {"peak", {{"mld_mm", 2.9}}},
          {"result", {{"mld_mm", 2.4}, {"recoil_mm", 0.5}}},
          {"flow",
           {{"vessel", "coronary"},
            {"ffr_before", 0.7},
            {"ffr_before_range", {0.65, 0.75}},
            {"ffr_after", 0.92}}}};
}

const dicom::Measurement* find(const std::vector<dicom::MeasurementGroup>& groups,
                               const std::string& label, const std::string& code) {
  for (const auto& group : groups)
    for (const auto& measurement : group.measurements)
      if (group.label == label && measurement.name.value == code) return &measurement;
  return nullptr;
}

TEST(DicomMeasurements, AreTheNumbersOfMetricsWithTheirUnits) {
  const auto groups = measurement_groups(treated());
  ASSERT_EQ(groups.size(), 3u);
  const auto* before = find(groups, "Lesion before", "G-0364");
  ASSERT_TRUE(before);
  EXPECT_EQ(before->value, 1.2);
  EXPECT_EQ(before->unit.value, "mm");
  EXPECT_EQ(before->derivation->meaning, "Minimum");
  EXPECT_EQ(find(groups, "Lesion before", "FFR")->value, 0.7);
  EXPECT_EQ(find(groups, "Lesion before", "RATIO_LOW")->value, 0.65);
  EXPECT_EQ(find(groups, "At peak", "BALLOON_PRESSURE")->unit.value, "atm");
  EXPECT_EQ(find(groups, "After", "RECOIL")->value, 0.5);
  EXPECT_EQ(find(groups, "After", "FFR")->value, 0.92);
}

TEST(DicomMeasurements, LeaveOutWhatIsNullOrNoNumber) {
  const auto groups = measurement_groups(treated());
  EXPECT_FALSE(find(groups, "Lesion before", "R-101BA"));
  EXPECT_EQ(groups[0].measurements.size(), 7u);
  EXPECT_TRUE(measurement_groups(json::object()).empty());
}

TEST(DicomMeasurements, TellABoundOfAThroatThatIsNarrowerThanAVoxel) {
  json metrics = treated();
  metrics["lesion"]["stenosis_at_least_percent"] = 80.0;
  const auto groups = measurement_groups(metrics);
  EXPECT_FALSE(find(groups, "Lesion before", "G-0364"));
  EXPECT_FALSE(find(groups, "Lesion before", "FFR"));
  const auto* least = find(groups, "Lesion before", "R-101BB");
  ASSERT_TRUE(least);
  EXPECT_EQ(least->value, 80.0);
  EXPECT_EQ(least->derivation->meaning, "Minimum");
}

TEST(DicomMeasurements, TellNoResultThatIsNone) {
  for (const char* status : {"not_determined", "failed", "stale"}) {
    json metrics = treated();
    metrics["status"] = status;
    const auto groups = measurement_groups(metrics);
    ASSERT_EQ(groups.size(), 1u) << status;
    EXPECT_EQ(groups[0].label, "Lesion before");
  }
}

TEST(DicomMeasurements, FindNoStenosisWhereThereIsNone) {
  json metrics = treated();
  metrics["status"] = "no_lesion";
  for (const auto& group : measurement_groups(metrics)) {
    EXPECT_NE(group.finding.meaning, "Stenosis");
    EXPECT_NE(group.label, "Lesion before");
  }
}

TEST(DicomMeasurements, SayFractionalFlowReserveOfCoronariesOnly) {
  json metrics = treated();
  metrics["flow"]["vessel"] = "other";
  const auto groups = measurement_groups(metrics);
  EXPECT_FALSE(find(groups, "Lesion before", "FFR"));
  EXPECT_TRUE(find(groups, "Lesion before", "PRESSURE_RATIO"));
}

TEST(DicomMeasurements, TermsFitIntoTheirAttributes) {
  json metrics = treated();  // with a number wherever there can be one
  for (const char* group : {"lesion", "balloon", "peak", "result"})
    for (const char* key :
         {"mld_mm", "mla_mm2", "diameter_stenosis_percent", "area_stenosis_percent", "length_mm",
          "abscissa_mm", "rated_burst_atm", "peak_diameter_mm", "balloon_to_artery_ratio",
          "acute_gain_mm", "recoil_percent"})
      metrics[group][key] = 1.0;
  for (const auto& group : measurement_groups(metrics)) {
    std::set<std::string> codes;
    for (const auto& m : group.measurements) {
      EXPECT_TRUE(codes.insert(m.name.value).second) << m.name.value << " twice";
      for (const dicom::Code& code : {m.name, m.unit, group.finding}) {
        EXPECT_LE(code.value.size(), 16u) << code.value;    // SH
        EXPECT_LE(code.meaning.size(), 64u) << code.value;  // LO
      }
    }
  }
}

}  // namespace
}  // namespace angio::pipeline
