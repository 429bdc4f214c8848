#include "pipeline/cli/manifest.hpp"

#include "fuzz/target.hpp"

ANGIO_FUZZ_TARGET(manifest) {
  angio::pipeline::read_manifest(angio::fuzz::file_of(bytes, "cohort.csv"), {},
                                 angio::pipeline::InputsAre::not_needed);
}
