#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/config/config.hpp"
#include "simulation/balloon_catalogue.hpp"

namespace angio::pipeline {

/// The entries of a catalogue file: TOML, a table [[balloon]] each, keys as the fields of
/// CatalogueBalloon, `chart` a list of [atm, mm].
/// @throws InputError (66 no such file, 65 otherwise) naming file, balloon and key
std::vector<simulation::CatalogueBalloon> read_balloon_file(const std::filesystem::path& file);

/// The catalogue that comes with the program (simulation/balloons.toml), and before it the entries
/// of `file`, if one is given: of two entries with the same name the user's counts.
std::vector<simulation::CatalogueBalloon> balloon_catalogue(const std::filesystem::path& file = {});

/// Takes over a balloon's measures, material, chart and crossing profile, and its nominal pressure
/// as the peak. Folds stay as they are set.
void apply_balloon(Config& config, const simulation::CatalogueBalloon& balloon);

}  // namespace angio::pipeline
