#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataReader.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "core/frames.hpp"
#include "segmentation/detail/bright_objects.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/tube_axes.hpp"
#include "segmentation/read_volume.hpp"
#include "segmentation/segmentation.hpp"
#include "testing/with_data.hpp"

namespace angio::segmentation {
namespace {
namespace fs = std::filesystem;

using RealData = angio::test::WithData;

TEST_F(RealData, AortaAgreesWithVmtksSurfaceOfIt) {
  const auto volume = read_volume(data("mra-aorta-vmtk/aorta.mha"), {}).volume;
  const auto result = segment_vessels(volume, {});
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(data("mra-aorta-vmtk/aorta-surface.vtp").c_str());
  reader->Update();
  vtkPolyData& surface = *reader->GetOutput();
  ASSERT_GT(surface.GetNumberOfPoints(), 1000);
  double signed_sum = 0.0, sum = 0.0;
  int count = 0;
  // VMTK writes RAS.
  for (vtkIdType p = 0; p < surface.GetNumberOfPoints(); ++p) {
    double x[3];
    surface.GetPoint(p, x);
    const double d = interpolate(result.level_set, lps_from_ras({x[0], x[1], x[2]}));
    if (std::abs(d) > 4.0) continue;  // a branch that only one of the two has
    signed_sum += d;
    sum += std::abs(d);
    ++count;
  }
  std::cout << "aorta against VMTK's surface: " << count << " of " << surface.GetNumberOfPoints()
            << " points within 4 mm, mean distance " << sum / count << " mm, signed "
            << signed_sum / count << " mm\n";
  EXPECT_GT(count, 0.9 * double(surface.GetNumberOfPoints()));
  EXPECT_LT(sum / count, 0.5);  // voxels: 0.88 mm in the slices, 1.5 mm across
}

TEST_F(RealData, RotationalAngiographyGivesOneTree) {
  const auto volume = read_volume(data("3dra-aneurism/dicom"), {}).volume;
  const auto result = segment_vessels(volume, {});
  EXPECT_EQ(detail::label_components(result.mask, detail::Connectivity::faces).count(), 1);
  // The tree spans most of the half head that was filled, and stays thin: 1 % of it or less.
  const Vec3 h = result.mask.geometry.spacing;
  double lumen = 0.0;
  for (auto v : result.mask.values) lumen += v * h.x * h.y * h.z;
  const auto& size = result.mask.geometry.size;
  EXPECT_GT(size[2] * h.z, 0.6 * 256 * 0.32);
  EXPECT_GT(lumen, 1000.0);
  EXPECT_LT(lumen, 0.01 * std::pow(256 * 0.32, 3));
}

TEST_F(RealData, NothingIsTakenForBoneWhereThereIsNone) {
  for (const char* name : {"mra-aorta-vmtk/aorta.mha", "3dra-aneurism/dicom"}) {
    const auto volume = read_volume(data(name), {}).volume;
    EXPECT_THAT(
        detail::find_bright_objects(volume, detail::find_tube_axes(volume), {}, {}).warnings,
        testing::IsEmpty())
        << name;
  }
}

}  // namespace
}  // namespace angio::segmentation
