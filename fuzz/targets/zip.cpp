#include "fuzz/target.hpp"
#include "segmentation/read_volume.hpp"

ANGIO_FUZZ_TARGET(zip) {
  angio::segmentation::inspect(angio::fuzz::file_of(bytes, "scans.zip"), {});
}
