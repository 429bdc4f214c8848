#include "fuzz/target.hpp"
#include "segmentation/read_volume.hpp"

/// What `angio inspect` says: headers alone.
ANGIO_FUZZ_TARGET(dicom_gate) {
  angio::segmentation::inspect(angio::fuzz::file_of(bytes, "object.dcm"), {});
}
