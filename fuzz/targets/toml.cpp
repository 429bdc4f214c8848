#include "fuzz/target.hpp"
#include "pipeline/config/config.hpp"

ANGIO_FUZZ_TARGET(toml) {
  angio::pipeline::Config config;
  angio::pipeline::load_config(config, angio::fuzz::file_of(bytes, "options.toml"));
  config.validate();
}
