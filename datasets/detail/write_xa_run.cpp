#include <cmath>
#include <limits>

#include "datasets/detail/phantom_dicom.hpp"

namespace angio::datasets::detail {
namespace {

/// X-Ray Angiographic Image Storage, a run of the C-arm in one object (PS3.3, A.14).
class XaRun : PhantomDicom {
 public:
  XaRun(const RotationalRunOfPhantom& run, std::string_view name, std::string_view fingerprint,
        int number, std::size_t first_frame)
      : PhantomDicom(run.phantom.volume, name, fingerprint),
        run_(run),
        number_(number),
        first_(first_frame) {}

  void write(const std::vector<std::uint16_t>& pixels, bool has_contrast_medium,
             const std::filesystem::path& path) const {
    DcmFileFormat file;
    DcmDataset& dataset = *file.getDataset();
    put_patient_and_study(dataset);
    put_series_and_equipment(dataset, "XA");
    put(dataset, DCM_SeriesInstanceUID, uid("series " + std::to_string(number_)));
    put(dataset, DCM_SeriesNumber, std::to_string(number_));
    put_image(dataset, has_contrast_medium);
    put_positioner(dataset);
    put_frames(dataset, pixels);
    save(file, path);
  }

 private:
  void put_image(DcmItem& dataset, bool has_contrast_medium) const {
    put(dataset, DCM_SOPClassUID, UID_XRayAngiographicImageStorage);
    put(dataset, DCM_SOPInstanceUID, uid("instance " + std::to_string(number_)));
    put(dataset, DCM_ImageType, "ORIGINAL\\PRIMARY\\SINGLE PLANE");
    put(dataset, DCM_InstanceNumber, "1");
    put(dataset, DCM_AcquisitionNumber, std::to_string(number_));
    put(dataset, DCM_ContentDate, kDate);
    put(dataset, DCM_ContentTime, kTime);
    put(dataset, DCM_PixelIntensityRelationship, "LIN");
    put(dataset, DCM_RadiationSetting, "GR");
    put(dataset, DCM_LossyImageCompression, "00");
    put(dataset, DCM_BurnedInAnnotation, "NO");
    put(dataset, DCM_KVP, "");
    if (has_contrast_medium) put(dataset, DCM_ContrastBolusAgent, "Iodine");
  }

  void put_positioner(DcmItem& dataset) const {
    const angiogram::CArmMount& mount = run_.mount;
    put(dataset, DCM_DistanceSourceToDetector, decimal(mount.source_to_detector_mm));
    put(dataset, DCM_DistanceSourceToPatient, decimal(mount.source_to_isocentre_mm));
    put(dataset, DCM_EstimatedRadiographicMagnificationFactor,
        decimal(mount.source_to_detector_mm / mount.source_to_isocentre_mm));
    put(dataset, DCM_ImagerPixelSpacing,
        decimal(mount.row_spacing_mm) + "\\" + decimal(mount.column_spacing_mm));
    const bool stands = !run_.options.views.empty();
    put(dataset, DCM_PositionerMotion, stands ? "STATIC" : "DYNAMIC");
    put(dataset, DCM_TableMotion, "STATIC");
    const double base = run_.primary_angles_degrees[first_];
    put(dataset, DCM_PositionerPrimaryAngle, decimal(base));
    put(dataset, DCM_PositionerSecondaryAngle, decimal(run_.secondary_angles_degrees[first_]));
    if (stands) return;
    std::string primary, secondary;
    for (const double angle : run_.primary_angles_degrees) {
      primary += (primary.empty() ? "" : "\\") + decimal(angle - base);
      secondary += secondary.empty() ? "0" : "\\0";
    }
    put(dataset, DCM_PositionerPrimaryAngleIncrement, primary);
    put(dataset, DCM_PositionerSecondaryAngleIncrement, secondary);
  }

  /// The frames of the R waves, numbered from 1 (PS3.3, C.8.7.1, X-Ray Image Module).
  void put_heart(DcmItem& dataset) const {
    const std::vector<int>& frames = run_.motion.r_wave_frames;
    if (frames.empty() || !run_.options.tells_r_waves) return;
    std::vector<Uint16> numbers;
    for (const int frame : frames) numbers.push_back(Uint16(frame + 1));
    if (dataset
            .putAndInsertUint16Array(DCM_RWavePointer, numbers.data(),
                                     static_cast<unsigned long>(numbers.size()))
            .bad())
      throw InternalError("DCMTK refuses the R waves of a run");
    put(dataset, DCM_HeartRate, std::to_string(int(std::lround(run_.options.heart_rate_per_min))));
  }

  void put_frames(DcmItem& dataset, const std::vector<std::uint16_t>& pixels) const {
    const std::size_t count = std::size_t(run_.options.frames);
    const std::size_t per_frame = std::size_t(run_.mount.columns) * std::size_t(run_.mount.rows);
    put(dataset, DCM_NumberOfFrames, std::to_string(count));
    if (dataset.putAndInsertTagKey(DCM_FrameIncrementPointer, DCM_FrameTime).bad())
      throw InternalError("DCMTK refuses a frame pointer");
    put(dataset, DCM_FrameTime, decimal(run_.options.frame_time_ms));
    put_heart(dataset);
    put(dataset, DCM_SamplesPerPixel, 1);
    put(dataset, DCM_PhotometricInterpretation, "MONOCHROME2");
    put(dataset, DCM_Rows, run_.mount.rows);
    put(dataset, DCM_Columns, run_.mount.columns);
    put(dataset, DCM_BitsAllocated, 16);
    put(dataset, DCM_BitsStored, 16);
    put(dataset, DCM_HighBit, 15);
    put(dataset, DCM_PixelRepresentation, 0);
    if (dataset
            .putAndInsertUint16Array(DCM_PixelData, pixels.data() + first_ * per_frame,
                                     static_cast<unsigned long>(count * per_frame))
            .bad())
      throw InternalError("DCMTK refuses the pixels of a run");
  }

  const RotationalRunOfPhantom& run_;
  int number_;
  std::size_t first_;  ///< frame
};

}  // namespace

void write_xa_run(const RotationalRunOfPhantom& run, const std::vector<std::uint16_t>& pixels,
                  std::string_view name, std::string_view fingerprint, int number,
                  bool has_contrast_medium, const std::filesystem::path& path,
                  std::size_t first_frame) {
  XaRun(run, name, std::string(fingerprint) + " XA", number, first_frame)
      .write(pixels, has_contrast_medium, path);
}

}  // namespace angio::datasets::detail
