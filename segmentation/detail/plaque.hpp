#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/volume.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/tube_axes.hpp"

/// Calcified plaque: bright as bone, in the wall of a vessel, and no lumen.
namespace angio::segmentation::detail {

/// Blood that plaque lies in.
struct PlaqueLevel {
  float blood = 0.0f;
  float contrast = 0.0f;  ///< of blood against its surroundings
  bool is_sure = false;   ///< told by blood's even vessels or pools, and bones are kept out
  [[nodiscard]] float half() const { return blood - 0.5f * contrast; }
  [[nodiscard]] float surroundings() const { return blood - contrast; }
};

/// The bright pieces that lie in a vessel's wall: half of it brighter than blood by half the
/// contrast, 40 mm long and 5 mm thick at most, with a fifth of their border at tissue and a fifth
/// at blood, an edge towards that, a tube of blood near, and blood beside them (within four voxels)
/// along their whole length. A denser vessel has its own wall all around, or a shorter piece of
/// blood that it crosses; blood that has not mixed has no edge. Plaque bends a tube's axis away, or
/// breaks it: where blood's level is sure, no axis is asked for. Near an axis a twentieth of the
/// border at blood is enough: a throat of three voxels leaves no more.
///
/// @param pieces      of what is brighter than blood
/// @param boxes       around each, shape [piece_count + 1]
/// @param candidates  to be looked at, the same shape
/// @param axes        of the volume: near is 4 mm or more of one as bright as blood within 4 mm, or
///                    2 mm beyond its radius
std::vector<bool> find_plaque(const Components& pieces, const std::vector<VoxelBox>& boxes,
                              const std::vector<bool>& candidates,
                              const std::vector<TubeAxis>& axes, const Volume<float>& denoised,
                              const PlaqueLevel& level);

/// Darkens plaque, so that the lumen ends at it as at any wall: with a peak P around, what lies
/// between it and blood L becomes L - (L - T) (v - L) / (P - L), with T of the tissue around. So
/// the edge between blood and plaque, half way from L to P, is at the half level of the lumen's
/// other edges, and as blurred. Where plaque falls to tissue it passes through blood's level, too;
/// there, it becomes tissue.
///
/// @param pieces    of what is brighter than blood
/// @param is_plaque which are darkened, shape [piece_count + 1]
void darken_plaque(const Components& pieces, const std::vector<VoxelBox>& boxes,
                   const std::vector<bool>& is_plaque, const Volume<float>& denoised,
                   const PlaqueLevel& level, Volume<float>& image);

}  // namespace angio::segmentation::detail
