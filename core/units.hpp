#pragma once

#include <string_view>

/// Units. Inside the code: mm, g, s, hence stress in Pa (1 g/(mm s^2) = 1 Pa), force in uN,
/// energy in nJ. People see atm and kPa for pressure.
namespace angio {

/// What a lumen surface that comes from elsewhere may be measured in.
enum class LengthUnit { mm, cm, m, inch };
inline constexpr const char* kLengthUnitNames[] = {"mm", "cm", "m", "inch"};
inline constexpr double kMillimetresOf[] = {1.0, 10.0, 1000.0, 25.4};
/// What a warning begins with where the unit was told from the size: every length rests on that.
inline constexpr std::string_view kUnitGuessed = "the file does not say its unit";

}  // namespace angio

namespace angio::units {

inline constexpr double kPascalPerAtm = 101325.0;  ///< standard atmosphere, exact (BIPM)
inline constexpr double kPascalPerKilopascal = 1e3;
inline constexpr double kPascalPerMegapascal = 1e6;
inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegreesPerRadian = 180.0 / kPi;

constexpr double pascal_from_atm(double atm) { return atm * kPascalPerAtm; }
constexpr double atm_from_pascal(double pascal) { return pascal / kPascalPerAtm; }
constexpr double pascal_from_kilopascal(double kpa) { return kpa * kPascalPerKilopascal; }
constexpr double kilopascal_from_pascal(double pascal) { return pascal / kPascalPerKilopascal; }
constexpr double pascal_from_megapascal(double mpa) { return mpa * kPascalPerMegapascal; }

}  // namespace angio::units
