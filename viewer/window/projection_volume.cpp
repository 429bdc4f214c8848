#include "viewer/window/projection_volume.hpp"

#include <vtkColorTransferFunction.h>
#include <vtkFixedPointVolumeRayCastMapper.h>
#include <vtkImageResample.h>
#include <vtkImageShiftScale.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>
#include <vtkVolumeProperty.h>

#include <algorithm>

namespace angio::viewer::window {
namespace {

constexpr double kWhite = 1000.0;  // grey levels of the thinned voxels

}  // namespace

vtkSmartPointer<vtkVolume> make_projection_volume(const ScanImage& scan) {
  constexpr double kMostVoxels = 160.0;
  vtkNew<vtkImageShiftScale> grey;
  grey->SetInputData(scan.image);
  grey->SetShift(-scan.black);
  grey->SetScale(kWhite / (scan.white - scan.black));
  grey->SetOutputScalarTypeToUnsignedShort();
  grey->ClampOverflowOn();
  vtkNew<vtkImageResample> thin;
  thin->SetInputConnection(grey->GetOutputPort());
  for (int axis = 0; axis < 3; ++axis)
    thin->SetAxisMagnificationFactor(
        axis, std::min(1.0, kMostVoxels / scan.image->GetDimensions()[axis]));
  vtkNew<vtkFixedPointVolumeRayCastMapper> mapper;
  mapper->SetInputConnection(thin->GetOutputPort());
  mapper->SetBlendModeToMaximumIntensity();
  mapper->AutoAdjustSampleDistancesOn();
  mapper->SetMaximumImageSampleDistance(4.0);

  vtkNew<vtkColorTransferFunction> color;
  color->AddRGBPoint(0.0, 0.0, 0.0, 0.0);
  color->AddRGBPoint(kWhite, 1.0, 1.0, 1.0);
  auto projection = vtkSmartPointer<vtkVolume>::New();
  projection->SetMapper(mapper);
  projection->GetProperty()->SetColor(color);
  projection->GetProperty()->SetInterpolationTypeToLinear();
  projection->SetUserMatrix(scan.lps_from_image);
  set_projection_opacity(projection, 1.0);
  return projection;
}

void set_projection_opacity(vtkVolume* projection, double opacity) {
  vtkNew<vtkPiecewiseFunction> ramp;
  ramp->AddPoint(0.0, 0.0);
  ramp->AddPoint(0.35 * kWhite, 0.0);
  ramp->AddPoint(kWhite, opacity);
  projection->GetProperty()->SetScalarOpacity(ramp);
}

}  // namespace angio::viewer::window
