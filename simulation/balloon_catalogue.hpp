#pragma once

#include <string>
#include <vector>

#include "simulation/chart.hpp"

namespace angio::simulation {

/// An entry of the balloon catalogue, balloons.toml.
struct CatalogueBalloon {
  std::string name;  ///< a word of letters, digits, '.', '-' and '_'
  std::string description;
  double nominal_diameter_mm = 3.0;        ///< [0.5, 50]
  double length_mm = 15.0;                 ///< of the cylindrical part, [0.5, 500]
  double wall_mm = 0.02;                   ///< membrane thickness before inflation, [0.001, 1]
  std::string material = "pa12";           ///< "pa12", "pet" or "polyurethane"
  double nominal_pressure_atm = 8.0;       ///< (0, 100]
  double rated_burst_pressure_atm = 14.0;  ///< no less than the nominal one, (0, 100]
  std::vector<ChartPoint> chart;           ///< empty: the material alone decides
  double crossing_profile_mm = 1.0;        ///< greatest diameter when folded, (0, nominal)
  int folds = 3;                           ///< 0 (starts unfolded), 2, 3 or 5
  double shaft_diameter_mm = 0.65;         ///< (0, crossing profile]
  std::string source;                      ///< where the figures come from
  bool representative = true;              ///< not a product's figures

  /// @throws InputError that names the balloon and the field
  void validate() const;
};

/// The entry of that name.
///
/// @throws InputError (78) that lists the names there are and says which one is near
const CatalogueBalloon& find_balloon(const std::vector<CatalogueBalloon>& catalogue,
                                     const std::string& name);

/// The unloaded diameter of the mid-surface [mm]: the chart's, else the nominal one.
double rest_diameter_mm(const CatalogueBalloon& balloon);

}  // namespace angio::simulation
