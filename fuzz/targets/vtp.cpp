#include "core/error.hpp"
#include "formats/files.hpp"
#include "fuzz/target.hpp"

/// As a surface and as lines.
ANGIO_FUZZ_TARGET(vtp) {
  const auto file = angio::fuzz::file_of(bytes, "surface.vtp");
  try {
    angio::formats::read_surface(file);
  } catch (const angio::InputError&) {
    // lines alone
  }
  angio::formats::read_polylines(file);
}
