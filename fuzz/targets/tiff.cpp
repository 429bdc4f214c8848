#include "fuzz/target.hpp"
#include "segmentation/read_volume.hpp"

ANGIO_FUZZ_TARGET(tiff) {
  angio::segmentation::ReadOptions options;
  options.spacing_mm = {0.5, 0.5, 0.5};
  angio::segmentation::read_volume(angio::fuzz::file_of(bytes, "scan.tif"), options);
}
