#include <algorithm>

#include "core/available_memory.hpp"
#include "core/child_process.hpp"
#include "core/error.hpp"
#include "segmentation/detail/dicom_parse.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr std::size_t kBatchSize = 512;  ///< files per child, whose time is limited
constexpr int kMaxTimeouts = 5;  ///< after which the input is given up: each costs the user minutes
/// A header takes little, but a packed file is unpacked for it as a whole.
ChildLimits header_limits() {
  constexpr std::uint64_t kLeast = std::uint64_t(1) << 28;
  constexpr std::uint64_t kMost = std::uint64_t(1) << 32;
  ChildLimits limits;
  limits.memory_bytes = std::size_t(std::clamp(available_memory_bytes() / 2, kLeast, kMost));
  limits.cpu_seconds = 300;
  limits.silent_seconds = 60;
  return limits;
}

/// Every field that crosses from the child; `side` puts or gets one.
template <class Run, class Side>
void cross_run(Run& run, const Side& side) {
  side(run.primary_angles_degrees);
  side(run.secondary_angles_degrees);
  side(run.base_angles_degrees);
  side(run.has_base_angle);
  side(run.source_to_detector_mm);
  side(run.source_to_isocentre_mm);
  side(run.magnification);
  side(run.spacing_mm);
  side(run.spacing_plane);
  side(run.frame_time_ms);
  side(run.frame_times_ms);
  side(run.r_wave_times_ms);
  side(run.mask_frames);
  side(run.mask_operation);
  side(run.open_field);
  side(run.burned_in_text);
  side(run.positioner_motion);
  side(run.pixel_relation);
  side(run.is_inverted);
  side(run.has_contrast_medium);
  side(run.table_travel_mm);
  side(run.detector_spacing_mm);
  side(run.picture_turn_degrees);
  side(run.picture_is_mirrored);
  side(run.middle_offset_mm);
}

template <class Header, class Side>
void cross_header(Header& header, const Side& side) {
  side(header.sop_class_uid);
  side(header.sop_class_name);
  side(header.kind);
  side(header.series_uid);
  side(header.instance_uid);
  side(header.concatenation_uid);
  side(header.transfer_syntax_name);
  side(header.compressed);
  side(header.jpeg_2000);
  side(header.lossy);
  side(header.multi_frame_object);
  side(header.is_of_the_heart);
  side(header.burned_in);
  side(header.instance_number);
  side(header.pixels.rows);
  side(header.pixels.columns);
  side(header.pixels.bits_allocated);
  side(header.pixels.bits_stored);
  side(header.pixels.high_bit);
  side(header.pixels.is_signed);
  side(header.pixels.is_monochrome1);
  side(header.pixels.has_modality_lut);
  side(header.pixels.has_padding);
  side(header.pixels.padding_first);
  side(header.pixels.padding_last);
  side(header.frames);
  side(header.problem);
}

void send(const DicomHeader& header, ChildOutput& output) {
  const auto put = [&](const auto& field) { output.put(field); };
  cross_header(header, put);
  output.put(header.projection.has_value());
  if (!header.projection) return;
  cross_run(*header.projection, put);
  output.put(std::uint64_t(header.projection->open_shapes.size()));
  for (const auto& corners : header.projection->open_shapes) output.put(corners);
  output.put(std::uint64_t(header.projection->notes.size()));
  for (const auto& note : header.projection->notes) output.put(note);
}

DicomHeader receive(ChildInput& input) {
  const auto get = [&](auto& field) { input.get(field); };
  DicomHeader header;
  cross_header(header, get);
  bool has_run = false;
  input.get(has_run);
  if (!has_run) return header;
  ProjectionRun& run = header.projection.emplace();
  cross_run(run, get);
  std::uint64_t shape_count = 0;
  input.get(shape_count);
  for (std::uint64_t n = 0; n < shape_count; ++n) input.get(run.open_shapes.emplace_back());
  std::uint64_t note_count = 0;
  input.get(note_count);
  for (std::uint64_t n = 0; n < note_count; ++n) input.get(run.notes.emplace_back());
  return header;
}

/// A file whose header ended the child.
DicomHeader broken_header(const DicomSource& source, const ChildResult& result) {
  DicomHeader header;
  header.source = source;
  switch (result.end) {
    case ChildEnd::refused:
      header.problem = result.message;
      break;
    case ChildEnd::out_of_memory:
      header.problem =
          source.entry < 0
              ? "its header asks for gigabytes of memory (it is damaged). Copy or export it again"
              : "it is too large to be unpacked in memory. Unpack the archive, and give the folder";
      break;
    case ChildEnd::timed_out:
      header.problem =
          "its header takes minutes to read (it is damaged, or on a slow disk). Copy it again";
      break;
    default:
      header.problem = "its header is damaged beyond reading. Copy or export it again";
  }
  return header;
}

}  // namespace

std::vector<DicomHeader> read_dicom_headers(const std::vector<DicomSource>& sources,
                                            const Progress& progress) {
  std::vector<DicomHeader> headers;
  prepare_dcmtk();
  std::size_t next = 0;
  int timeouts = 0;
  while (next < sources.size()) {
    const std::size_t first = next;
    const std::size_t end = std::min(sources.size(), first + kBatchSize);
    const auto parse_all = [&](ChildOutput& output) {
      DicomLoader loader;
      for (std::size_t f = first; f < end; ++f) {
        const auto header = parse_header(loader, sources[f]);
        output.put(header.has_value());
        if (header) send(*header, output);
        output.flush();
      }
    };
    const auto take_all = [&](ChildInput& input) {
      for (; next < end; ++next) {
        if (next % 16 == 0)
          progress.report(0.5 * double(next) / double(sources.size()), "reading headers");
        bool is_dicom = false;
        input.get(is_dicom);
        if (!is_dicom) continue;
        headers.push_back(receive(input));
        headers.back().source = sources[next];
      }
    };
    ChildLimits limits = header_limits();
    for (std::size_t f = first; f < end; ++f) limits.reach.read.push_back(sources[f].path);
    const ChildResult result = run_guarded(limits, parse_all, take_all);
    if (next == end) continue;
    if (result.end == ChildEnd::timed_out && ++timeouts == kMaxTimeouts)
      throw InputError(
          "the input takes too long to read (damaged files, or a slow disk). Copy the series alone "
          "into a folder on this computer");
    headers.push_back(broken_header(sources[next++], result));
  }
  return headers;
}

}  // namespace angio::segmentation::detail
