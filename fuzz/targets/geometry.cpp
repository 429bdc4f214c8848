#include "core/error.hpp"
#include "fuzz/target.hpp"
#include "reconstruction/geometry_file.hpp"

/// RTK's XML, and CSV.
ANGIO_FUZZ_TARGET(geometry) {
  for (const char* name : {"geometry.xml", "geometry.csv"}) try {
      angio::reconstruction::read_geometry(angio::fuzz::file_of(bytes, name),
                                           {{16, 16}, {0.5, 0.5}});
    } catch (const angio::InputError&) {
      // the other kind
    }
}
