#pragma once

#include "centerline/centerline.hpp"
#include "centerline/detail/reference.hpp"

/// What is measured at a narrow place of a path.
namespace angio::centerline {

/// A lesion is as long as the stretch around its tightest place with at least this stenosis.
inline constexpr double kShoulderPercent = 20.0;

/// Everything that is known of one path.
struct Known {
  const CenterlinePath& path;
  const TreeReference& tree;
  const ReferenceDiameter& reference;

  [[nodiscard]] bool is_measured(std::size_t i) const { return reference.measured[i] > 0.0; }
  /// Is anything measured at the points [first, end)?
  [[nodiscard]] bool is_measured_within(std::size_t first, std::size_t end) const {
    for (std::size_t i = first; i < end; ++i)
      if (is_measured(i)) return true;
    return false;
  }
  /// Diameter stenosis; 0 where nothing is measured.
  [[nodiscard]] double percent(std::size_t i) const {
    if (!is_measured(i)) return 0.0;
    return 100.0 * (1.0 - reference.measured[i] / reference.diameter[i]);
  }
};

/// A stretch of a path: points [first, last].
struct Vessel {
  std::size_t path = 0, first = 0, last = 0;
};

/// Points [first, last] around a place of a vessel, narrowed by at least the shoulder's stenosis
/// wherever they are measured, and the tightest of them. Where the place is not narrow, itself.
struct Dip {
  std::size_t first, last, tightest;
};
Dip grow_dip(const Known& known, const Vessel& vessel, std::size_t at);

/// Diameters, references, edges and length of a dip. Its place is the narrowest, where the MLD is:
/// reference and percent stenosis are of that place. The least section may lie beside it.
///
/// @param least_percent  of the place, where any of the dip is narrowed so much: what is listed for
///                       a stenosis is one where it is said to be
Lesion describe_dip(const Known& known, const Vessel& vessel, const Dip& dip,
                    double least_percent = kShoulderPercent);

/// Whether no section is narrowed, whatever its largest circle says: the line runs off the middle,
/// or the section holds two vessels.
bool is_no_neck(const Lesion& lesion);
/// Whether a neck has the shape of a bridge, by which two vessels that touch are joined: it is
/// shorter than half its reference diameter, or the line turns round it and it is no longer than a
/// bridge may be.
bool looks_like_a_bridge(const CenterlinePath& path, const Lesion& lesion);
/// Whether a neck may be a bridge: it looks like one, and a vessel that it joins passes it by. Near
/// it (1.25 diameters) the lines part, and what parts is at least 0.6 times as wide as the vessel
/// before the parting, where that lies before the neck, or as the one that the line goes on in,
/// where it lies behind. A coarctation is as short, and may lie in as sharp a bend, but no aorta
/// passes it by.
bool may_be_a_bridge(const Known& known, const Vessel& vessel, const Dip& dip,
                     const Lesion& lesion);
/// Whether a line turns out of one vessel and into another around s: the angles before and behind,
/// told by chords of a diameter, are more than 80 degrees together, and each more than 25. Into a
/// side branch a line turns once.
bool turns_like_a_bridge(const CenterlinePath& path, double s, double diameter);

}  // namespace angio::centerline
