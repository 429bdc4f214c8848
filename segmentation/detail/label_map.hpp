#pragma once

#include <vector>

#include "core/volume.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::segmentation::detail {

/// The labels of a volume that holds numbers of structures and no intensities; empty if it is an
/// image.
///
/// Two values in all make a label map, whatever they are. More, up to 256, do if they are whole
/// numbers, if of neighbours that are both no background nine in ten are alike (noise would make
/// them differ), and if an edge jumps: of places where values change along an axis, in one of
/// twenty at most lies a value between those of its two neighbours (blur puts one into each edge).
/// The background is 0 if it occurs, else the lowest value.
///
/// @return without the background, in the order of their values
std::vector<Label> find_labels(const Volume<float>& volume);

}  // namespace angio::segmentation::detail
