#include "formats/files.hpp"
#include "fuzz/target.hpp"

ANGIO_FUZZ_TARGET(ply) { angio::formats::read_surface(angio::fuzz::file_of(bytes, "surface.ply")); }
