#include "fuzz/target.hpp"
#include "pipeline/config/balloon_file.hpp"

ANGIO_FUZZ_TARGET(catalogue) {
  for (const auto& balloon :
       angio::pipeline::read_balloon_file(angio::fuzz::file_of(bytes, "balloons.toml"))) {
    angio::pipeline::Config config;
    angio::pipeline::apply_balloon(config, balloon);
  }
}
