#include "formats/files.hpp"
#include "fuzz/target.hpp"

ANGIO_FUZZ_TARGET(gltf) {
  const bool is_binary = bytes.size() > 4 && bytes[0] == 'g';
  angio::formats::read_surface(
      angio::fuzz::file_of(bytes, is_binary ? "surface.glb" : "surface.gltf"));
}
