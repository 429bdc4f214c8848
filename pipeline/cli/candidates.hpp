#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cli/manifest.hpp"
#include "pipeline/config/config.hpp"

namespace angio::pipeline {

/// Which balloons are compared, as on the command line; what is left empty is chosen by the lesion.
struct CandidateRequest {
  std::vector<std::string> balloons = {};   ///< names of the catalogue, instead of diameters
  std::filesystem::path catalogue = {};     ///< the user's own
  std::vector<std::string> diameters = {};  ///< nominal [mm]
  std::vector<std::string> lengths = {};    ///< [mm]
  std::vector<std::string> pressures = {};  ///< [atm], "nominal" or "rated"
};

/// What the choice depends on.
struct LesionSize {
  double reference_diameter_mm = 0.0;
  double length_mm = 0.0;
};

/// A balloon, its length, and how far it is inflated.
struct Candidate {
  std::string balloon;  ///< of the catalogue; empty: the representative one of its diameter
  double diameter_mm = 0.0, length_mm = 0.0, pressure_atm = 0.0;
  std::string pressure;  ///< "nominal", "rated", or empty
  BatchCase variant;
};

/// Without a request: the diameters in which balloons are sold next to 0.9, 1.0 and 1.1 times the
/// reference diameter; the shortest length sold that reaches past the lesion as a balloon does by
/// default (meshing::usual_balloon_length_mm), at nominal and at rated burst pressure; and the next
/// length at nominal pressure: at most nine. With lengths or pressures, every combination.
///
/// @param config  of the case; a balloon of its own in it gives way to the candidates
/// @return by balloon, length, pressure
/// @throws Error (64) for what is no number, or more than kMostVariants; OptionError (78) outside a
///         setting's range, or for an unknown balloon
std::vector<Candidate> make_candidates(const CandidateRequest& request, const LesionSize& lesion,
                                       const Config& config);

}  // namespace angio::pipeline
