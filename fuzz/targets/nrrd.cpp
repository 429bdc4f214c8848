#include "formats/nrrd.hpp"

#include "core/error.hpp"
#include "fuzz/target.hpp"
#include "segmentation/read_volume.hpp"

/// A user's volume, and the same bytes as a file of a case, which has a reader of its own.
ANGIO_FUZZ_TARGET(nrrd) {
  const auto file = angio::fuzz::file_of(bytes, "scan.nrrd");
  try {
    angio::formats::read_nrrd(file);
  } catch (const angio::InputError&) {
    // the other reader may take it
  }
  angio::segmentation::read_volume(file, {});
}
