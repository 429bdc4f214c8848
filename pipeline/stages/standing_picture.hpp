#pragma once

#include <vector>

#include "angiogram/cone_beam.hpp"

namespace angio::pipeline {

/// A picture of a C-arm that stood still, and where it was taken.
struct StandingPicture {
  angiogram::ConeBeamFrame frame;
  std::vector<float> pixels;       ///< shape [rows, columns]
  std::vector<char> covered = {};  ///< 1: no picture, but shutter or border; empty: none
};

/// Makes pictures of different detectors alike: blocks of pixels become one, so that all have about
/// the coarsest's, and no side more than 1,024; then all are widened to the largest's size by what
/// their borders have. A block is covered if a pixel of it is, and what is widened is covered.
/// @throws InputError  what is left of a picture has a side of less than 32 pixels
void even_out(std::vector<StandingPicture>& pictures);

}  // namespace angio::pipeline
