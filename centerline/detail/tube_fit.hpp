#pragma once

#include <Eigen/Dense>
#include <vector>

#include "centerline/detail/tube_samples.hpp"

namespace angio::centerline {

inline constexpr double kWindows[] = {0.4, 0.6, 0.9, 1.35, 2.0, 3.0};  ///< half lengths, in radii
inline constexpr int kMostOrder = 8;                                   ///< of the harmonics
inline constexpr double kSignificant = 3.0;  ///< -log 5 %: noise rarely has more times its power
inline constexpr double kConfidence = 2.5;   ///< standard errors that are noise

/// Harmonics round the line times powers along it, fitted to samples of the wall.
struct Fit {
  bool valid = false;
  int order = 0;
  double window = 0.0;
  double noise = 0.0;     // robust sd of the residuals
  double sd = 0.0;        // of the samples: what the terms took up is added
  double score = 0.0;     // penalised, as of AIC
  double count = 0.0;     // independent ones
  Eigen::VectorXd terms;  // m, then cos and sin, then powers of s / window
  Eigen::VectorXd error;  // standard errors of the terms
};

/// How the wall's samples err.
struct WallErrors {
  double correlation = 0.0;  ///< samples nearer than this err together [mm]; 0: each by itself
  double least_sd = 0.0;     ///< known from the vessel around [mm]
};

/// Where a harmonic begins in the terms; harmonic 0 has no sine.
int first_term(int harmonic, bool sine);

/// The radius of the fitted wall at a sample's place (its s and its angle).
double predict(const Fit& fit, const Sample& sample);

/// Weighted least squares, reweighted by Tukey's biweight. The sample weights go in and out.
Fit fit_window(std::vector<Sample>& samples, double window, int order, int passes,
               const WallErrors& errors, double radius);

/// The fit of order 2 in the longest window that agrees with all shorter ones.
Fit choose_window(std::vector<Sample>& samples, double radius, const WallErrors& errors);

/// More harmonics as long as they say more than noise.
Fit choose_order(std::vector<Sample>& samples, Fit best, int most_order, const WallErrors& errors,
                 double radius);

/// Shrinks each harmonic, with its course along the line, by the noise's part in its power
/// (garrote, Breiman, Technometrics 37(4), 1995): a round vessel with a noisy wall stays round, a
/// flat one flat.
void shrink_harmonics(Fit& fit);

}  // namespace angio::centerline
