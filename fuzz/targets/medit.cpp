#include "formats/files.hpp"
#include "fuzz/target.hpp"

ANGIO_FUZZ_TARGET(medit) {
  angio::formats::read_surface(angio::fuzz::file_of(bytes, "surface.mesh"));
}
