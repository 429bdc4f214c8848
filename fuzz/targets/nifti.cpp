#include "fuzz/target.hpp"
#include "segmentation/read_volume.hpp"

ANGIO_FUZZ_TARGET(nifti) {
  angio::segmentation::read_volume(angio::fuzz::file_of(bytes, "scan.nii"), {});
}
