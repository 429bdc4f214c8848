#include "formats/files.hpp"
#include "fuzz/target.hpp"

ANGIO_FUZZ_TARGET(off) { angio::formats::read_surface(angio::fuzz::file_of(bytes, "surface.off")); }
