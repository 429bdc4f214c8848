#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cli/candidates.hpp"
#include "pipeline/cli/ranking.hpp"
#include "pipeline/cli/variants.hpp"

namespace angio::pipeline {

/// The lesion that the candidates are for.
struct TreatedLesion {
  LesionSize size;
  int centerline_id = 0;
  double abscissa_mm = 0.0;
};

/// @throws InputError (66, 65) if the folder is no case, is not meshed yet, or has no stenosis to
///         treat
TreatedLesion treated_lesion(const std::filesystem::path& case_folder);

/// A limit that was not kept.
struct Miss {
  std::string limit;  ///< its key: residual_stenosis_percent, balloon_to_artery_ratio,
                      ///< widening_beside_lesion, ffr_after or rated_burst_atm
  std::string text;   ///< "residual stenosis 34 % (at most 30 %)"
};

/// What came of a candidate.
struct CandidateResult {
  Candidate candidate;
  VariantRow row;
  bool is_coronary = false;  ///< the limit of fractional flow reserve holds
  std::vector<Miss> missed;
  std::vector<std::string> notes;  ///< limits that could not be asked, a kink, a shorter balloon
  Standing standing;
  Ranked ranked;
};

/// Judges a candidate by the limits. Numbers are compared as they are printed, whole percents and
/// hundredths: smaller differences are below what the simulation can tell.
///
/// @param metrics  the candidate's metrics.json; null: there is none
CandidateResult judge_candidate(const Candidate& candidate, const VariantRow& row,
                                const nlohmann::json& metrics, const TreatedLesion& lesion);

/// Ranks results, the best first; among equals by balloon, length and pressure.
void rank_results(std::vector<CandidateResult>& results);

/// How they are ranked, for people: the limits with their numbers.
std::string ranking_rule();

/// The table for a terminal; what is to be said beneath it.
std::string recommendation_table(const std::vector<CandidateResult>& results);
std::string recommendation_words(const std::vector<CandidateResult>& results);

/// Writes recommendation.csv, recommendation.json and, where several diameters have results,
/// recommendation.svg.
void write_recommendation(const std::filesystem::path& folder, const TreatedLesion& lesion,
                          const std::vector<CandidateResult>& results);

}  // namespace angio::pipeline
