#include "fuzz/target.hpp"
#include "segmentation/read_volume.hpp"

ANGIO_FUZZ_TARGET(vtk_image) {
  angio::segmentation::read_volume(angio::fuzz::file_of(bytes, "scan.vtk"), {});
}
