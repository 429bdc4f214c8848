#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/progress.hpp"
#include "dicom/archive.hpp"

namespace angio::dicom::detail {

/// Tells the parent how far the child is. @param fraction  [0, 1]
using TellFraction = std::function<void(double fraction)>;

/// Runs what speaks with an archive in a guarded child: what comes over the network may break a
/// parser, and a thread that waits for an answer cannot be stopped otherwise. A heartbeat lets the
/// parent look for Ctrl-C several times a second.
///
/// @param step  for people, "sending to PACS"
/// @param work  in the child; what it throws is thrown here. Returns what the parent gets
std::vector<std::int64_t> run_session(
    const ArchiveAddress& address, const std::string& step, const Progress& progress,
    const std::function<std::vector<std::int64_t>(const TellFraction&)>& work);

}  // namespace angio::dicom::detail
