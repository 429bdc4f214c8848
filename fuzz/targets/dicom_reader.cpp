#include "fuzz/target.hpp"
#include "segmentation/read_volume.hpp"

/// Pixels, too, with all that an option can allow.
ANGIO_FUZZ_TARGET(dicom_reader) {
  angio::segmentation::ReadOptions options;
  options.allow_lossy = true;
  options.resample = true;
  options.max_memory_gib = 0.25;
  angio::segmentation::read_volume(angio::fuzz::file_of(bytes, "object.dcm"), options);
}
