#include "core/error.hpp"
#include "formats/files.hpp"
#include "fuzz/target.hpp"

/// As tetrahedra and as wedges.
ANGIO_FUZZ_TARGET(vtu) {
  const auto file = angio::fuzz::file_of(bytes, "mesh.vtu");
  try {
    angio::formats::read_tets(file);
  } catch (const angio::InputError&) {
    // wedges
  }
  angio::formats::read_wedges(file);
}
