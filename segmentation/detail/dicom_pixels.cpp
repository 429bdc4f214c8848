#include "segmentation/detail/dicom_pixels.hpp"

#include <dcmtk/dcmdata/dcpixel.h>
#include <dcmtk/dcmdata/dcpixseq.h>
#include <dcmtk/dcmdata/dcpxitem.h>
#include <dcmtk/dcmdata/dcrledrg.h>
#include <dcmtk/dcmjpeg/djdecode.h>
#include <dcmtk/dcmjpls/djdecode.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <mutex>
#include <system_error>

#include "core/child_process.hpp"
#include "core/error.hpp"
#include "segmentation/detail/dicom_load.hpp"
#include "segmentation/detail/jpeg_2000.hpp"

namespace angio::segmentation::detail {
namespace {

[[noreturn]] void fail(const DicomHeader& header, const std::string& why) {
  throw InputError("cannot decode the pixels of a file (" + header.transfer_syntax_name + ": " +
                   why + "). Export the series uncompressed (Explicit VR Little Endian)");
}

/// Registers DCMTK's own decoders, once.
void register_decoders() {
  static std::once_flag once;
  std::call_once(once, [] {
    DcmRLEDecoderRegistration::registerCodecs();
    DJDecoderRegistration::registerCodecs();
    DJLSDecoderRegistration::registerCodecs();
  });
}

/// What the frames of an object take as they are stored, one number per pixel [bytes].
std::size_t stored_bytes(const DicomHeader& header) {
  return header.pixels.per_frame() * header.frames.size() * sizeof(std::uint16_t);
}

/// The frames of one object as they are stored, not yet masked or signed.
class StoredFrames {
 public:
  StoredFrames(DicomLoader& loader, const DicomHeader& header);
  /// Fills `out` with one frame.
  void get(int frame, std::vector<std::uint16_t>& out);

 private:
  [[nodiscard]] std::size_t frame_bytes() const;
  /// A frame's bytes, 8 or 16 bits a pixel, to numbers.
  void widen(std::vector<std::uint16_t>& out) const;
  bool decode_alone(int frame);
  void take_all();

  const DicomHeader* header_;
  DcmFileFormat file_;
  DcmElement* on_disk_ = nullptr;                   ///< read frame by frame
  DcmPixelData* packed_ = nullptr;                  ///< decoded frame by frame
  const Uint8* bytes_ = nullptr;                    ///< of all frames, if they have 8 bits
  const Uint16* words_ = nullptr;                   ///< of all frames, if they have 16
  std::vector<std::vector<std::uint8_t>> streams_;  ///< of JPEG 2000, one per frame
  std::vector<Uint8> frame_;                        ///< of one frame
};

/// Whether a fragment begins a JPEG 2000 code stream or file.
bool begins_jpeg_2000(const Uint8* bytes, Uint32 size) {
  return size > 12 && ((bytes[0] == 0xff && bytes[1] == 0x4f) ||
                       (bytes[4] == 'j' && bytes[5] == 'P' && bytes[6] == ' '));
}

/// The bytes of each frame's JPEG 2000 stream, which may be cut into several fragments.
std::vector<std::vector<std::uint8_t>> frame_streams(DcmDataset& dataset,
                                                     const DicomHeader& header) {
  DcmElement* element = nullptr;
  dataset.findAndGetElement(DCM_PixelData, element);
  auto* pixels = dynamic_cast<DcmPixelData*>(element);
  E_TransferSyntax syntax = EXS_Unknown;
  const DcmRepresentationParameter* parameter = nullptr;
  DcmPixelSequence* sequence = nullptr;
  if (pixels) pixels->getOriginalRepresentationKey(syntax, parameter);
  if (!pixels || pixels->getEncapsulatedRepresentation(syntax, parameter, sequence).bad() ||
      !sequence)
    fail(header, "no compressed stream was found");
  std::vector<std::vector<std::uint8_t>> streams;
  for (unsigned long item = 1; item < sequence->card(); ++item) {  // the first is a table
    DcmPixelItem* fragment = nullptr;
    Uint8* bytes = nullptr;
    if (sequence->getItem(fragment, item).bad() || !fragment ||
        fragment->getUint8Array(bytes).bad() || !bytes)
      fail(header, "a fragment cannot be read");
    if (streams.empty() || begins_jpeg_2000(bytes, fragment->getLength())) streams.emplace_back();
    streams.back().insert(streams.back().end(), bytes, bytes + fragment->getLength());
  }
  if (streams.size() != header.frames.size())
    fail(header, "it holds " + std::to_string(streams.size()) + " streams for " +
                     std::to_string(header.frames.size()) + " frames");
  return streams;
}

StoredFrames::StoredFrames(DicomLoader& loader, const DicomHeader& header) : header_(&header) {
  if (loader.load(header.source, DCM_MaxReadLength, file_).bad())
    fail(header, "the file is truncated or damaged");
  DcmDataset& dataset = *file_.getDataset();
  if (header.jpeg_2000) {
    streams_ = frame_streams(dataset, header);
    return;
  }
  DcmElement* pixels = nullptr;
  dataset.findAndGetElement(DCM_PixelData, pixels);
  if (header.compressed) {
    register_decoders();
    packed_ = dynamic_cast<DcmPixelData*>(pixels);
  } else if (header.source.entry < 0 && pixels && frame_bytes() % 2 == 0 &&
             pixels->getLength() >= frame_bytes() * header.frames.size()) {
    on_disk_ = pixels;
  }
  if (!packed_ && !on_disk_) take_all();
}

std::size_t StoredFrames::frame_bytes() const {
  return header_->pixels.per_frame() * (header_->pixels.bits_allocated == 8 ? 1 : 2);
}

/// A run of hundreds of frames is read some at a time: the others need not be decoded with them.
bool StoredFrames::decode_alone(int frame) {
  frame_.resize(frame_bytes() + frame_bytes() % 2);
  Uint32 fragment = 0;  // it is looked for
  OFString colors;
  return packed_
      ->getUncompressedFrame(file_.getDataset(), Uint32(frame), fragment, frame_.data(),
                             Uint32(frame_.size()), colors)
      .good();
}

void StoredFrames::take_all() {
  DcmDataset& dataset = *file_.getDataset();
  if (header_->compressed && dataset.chooseRepresentation(EXS_LittleEndianExplicit, nullptr).bad())
    fail(*header_, "the stream is damaged, or of a kind that is not supported");
  unsigned long count = 0;
  const OFCondition status = header_->pixels.bits_allocated == 8
                                 ? dataset.findAndGetUint8Array(DCM_PixelData, bytes_, &count)
                                 : dataset.findAndGetUint16Array(DCM_PixelData, words_, &count);
  if (status.bad() || (!bytes_ && !words_) ||
      count < header_->pixels.per_frame() * header_->frames.size())
    fail(*header_, "the pixel data are truncated or damaged");
}

void StoredFrames::widen(std::vector<std::uint16_t>& out) const {
  if (header_->pixels.bits_allocated == 8)
    std::copy_n(frame_.begin(), out.size(), out.begin());
  else
    std::memcpy(out.data(), frame_.data(), out.size() * sizeof(std::uint16_t));
}

void StoredFrames::get(int frame, std::vector<std::uint16_t>& out) {
  const std::size_t count = header_->pixels.per_frame();
  const std::size_t first = std::size_t(frame) * count;
  out.resize(count);
  if (on_disk_) {
    frame_.resize(frame_bytes());
    const auto size = Uint32(frame_bytes());
    if (on_disk_->getPartialValue(frame_.data(), Uint32(frame) * size, size).bad())
      fail(*header_, "the pixel data are truncated or damaged");
    return widen(out);
  }
  if (packed_) {
    if (decode_alone(frame)) return widen(out);
    packed_ = nullptr;  // its fragments do not say which frame they are of
    take_all();
  }
  if (bytes_) {
    std::copy_n(bytes_ + first, count, out.begin());
  } else if (words_) {
    std::copy_n(words_ + first, count, out.begin());
  } else {
    const std::string problem = decode_jpeg_2000(
        streams_[std::size_t(frame)], header_->pixels.columns, header_->pixels.rows, out.data());
    if (!problem.empty()) fail(*header_, problem);
  }
}

/// Takes the stored bits out of a pixel, with their sign.
int stored_value(std::uint16_t raw, const DicomHeader& header) {
  const int shift = header.pixels.high_bit + 1 - header.pixels.bits_stored;
  const int mask = (1 << header.pixels.bits_stored) - 1;
  const int value = (int(raw) >> shift) & mask;
  const int sign = 1 << (header.pixels.bits_stored - 1);
  return header.pixels.is_signed && (value & sign) ? value - mask - 1 : value;
}

/// Decoders ask for the memory that a header claims before they have seen a stream. PackBits (RLE)
/// makes 128 bytes of two; the other codecs, and deflation, pack a picture that shows anything less
/// than two thousand times.
///
/// @throws InputError if a file is too short for its pixels
void check_packed_size(const DicomHeader& header) {
  constexpr std::uint64_t kMostOfRle = 64, kMostOfOthers = 2000, kMostOfZip = 1032;
  std::error_code ignored;
  const std::uint64_t file_size = std::filesystem::file_size(header.source.path, ignored);
  if (ignored) return;  // its reader says so
  const bool is_rle = header.transfer_syntax_name.find("RLE") != std::string::npos;
  const std::uint64_t most = (is_rle ? kMostOfRle : kMostOfOthers) *
                             (header.source.entry >= 0 ? kMostOfZip : 1) * file_size;
  if (std::uint64_t(stored_bytes(header)) > most)
    fail(header, "the file is far too short for the pixels that its header claims");
}

/// Time and memory that decoding takes at the worst, with much to spare.
ChildLimits decode_limits(const std::vector<DicomHeader>& headers) {
  std::size_t total = 0;
  std::size_t largest = 0;
  for (const auto& header : headers) {
    std::error_code ignored;
    const auto file_size = std::filesystem::file_size(header.source.path, ignored);
    const std::size_t packed = ignored || header.source.entry >= 0 ? 0 : std::size_t(file_size);
    total += stored_bytes(header);
    largest = std::max(largest, 8 * stored_bytes(header) + 2 * packed);
  }
  constexpr std::size_t kBytesPerSecond = std::size_t(1) << 20;
  const int seconds = 60 + int(std::min<std::size_t>(total / kBytesPerSecond, 86400));
  ChildLimits limits{(std::size_t(512) << 20) + largest, seconds, double(seconds)};
  for (const auto& header : headers) limits.reach.read.push_back(header.source.path);
  return limits;
}

[[noreturn]] void fail_by(const ChildResult& result, const DicomHeader& header) {
  switch (result.end) {
    case ChildEnd::refused:
      throw InputError(result.message);
    case ChildEnd::out_of_memory:
      fail(header, "a damaged stream asks for more memory than its pixels could take");
    case ChildEnd::timed_out:
      fail(header, "a damaged stream, or one on a very slow disk, takes too long");
    default:
      fail(header, "the decoder broke down on a damaged stream in this series");
  }
}

}  // namespace

void rescale(const DicomHeader& header, int index, const StoredPixels& raw, float* out) {
  const DicomFrame& frame = header.frames[std::size_t(index)];
  const int least = header.pixels.is_signed ? -(1 << (header.pixels.bits_stored - 1)) : 0;
  const int most = least + (1 << header.pixels.bits_stored) - 1;
  const int sense = header.pixels.is_monochrome1 ? -1 : 1;
  const int from = header.pixels.is_monochrome1 ? least + most : 0;
  for (std::size_t p = 0; p < raw.size(); ++p)
    out[p] =
        float(frame.slope * double(from + sense * stored_value(raw[p], header)) + frame.intercept);
  if (!header.pixels.has_padding) return;
  const auto is_padding = [&](std::uint16_t pixel) {
    const int stored = stored_value(pixel, header);
    return stored >= header.pixels.padding_first && stored <= header.pixels.padding_last;
  };
  float lowest = std::numeric_limits<float>::infinity();
  for (std::size_t p = 0; p < raw.size(); ++p)
    if (!is_padding(raw[p])) lowest = std::min(lowest, out[p]);
  if (!std::isfinite(lowest)) return;
  for (std::size_t p = 0; p < raw.size(); ++p)
    if (is_padding(raw[p])) out[p] = lowest;
}

void decode_each(const std::vector<DicomHeader>& headers,
                 const std::vector<SliceReference>& members,
                 const std::function<void(std::size_t member, const StoredPixels& pixels)>& use) {
  std::vector<std::vector<std::size_t>> wanted(headers.size());
  for (std::size_t m = 0; m < members.size(); ++m)
    wanted[std::size_t(members[m].header)].push_back(m);
  const auto decode = [&](ChildOutput& output) {
    DicomLoader loader;
    StoredPixels raw;
    for (std::size_t h = 0; h < headers.size(); ++h) {
      if (wanted[h].empty()) continue;
      StoredFrames frames(loader, headers[h]);
      for (std::size_t m : wanted[h]) {
        frames.get(members[m].frame, raw);
        output.write(raw.data(), raw.size() * sizeof(std::uint16_t));
      }
    }
  };
  const auto take = [&](ChildInput& input) {
    StoredPixels raw;
    for (std::size_t h = 0; h < headers.size(); ++h)
      for (std::size_t m : wanted[h]) {
        raw.resize(headers[h].pixels.per_frame());
        input.read(raw.data(), raw.size() * sizeof(std::uint16_t));
        use(m, raw);
      }
  };
  for (std::size_t h = 0; h < headers.size(); ++h)
    if (!wanted[h].empty()) check_packed_size(headers[h]);
  prepare_dcmtk();
  const ChildResult result = run_guarded(decode_limits(headers), decode, take);
  if (result.end != ChildEnd::done) fail_by(result, headers.front());
}

std::vector<float> decode_frames(const std::vector<DicomHeader>& headers,
                                 const std::vector<SliceReference>& members,
                                 const Progress& progress) {
  if (members.empty()) return {};
  const std::size_t slice_size = headers[std::size_t(members.front().header)].pixels.per_frame();
  std::vector<float> values;  // take memory when the first frame has come
  std::size_t done = 0;
  decode_each(headers, members, [&](std::size_t m, const StoredPixels& raw) {
    const auto [h, f] = members[m];
    values.resize(slice_size * members.size());
    rescale(headers[std::size_t(h)], f, raw, values.data() + m * slice_size);
    if (++done % 16 == 0)
      progress.report(0.5 + 0.5 * double(done) / double(members.size()), "reading pixels");
  });
  return values;
}

std::vector<std::uint64_t> hash_frames(const std::vector<DicomHeader>& headers,
                                       const std::vector<SliceReference>& members) {
  std::vector<std::uint64_t> hashes(members.size());
  decode_each(headers, members, [&](std::size_t m, const StoredPixels& raw) {
    std::uint64_t hash = 14695981039346656037u;  // FNV-1a
    for (const std::uint16_t pixel : raw) hash = (hash ^ pixel) * 1099511628211u;
    hashes[m] = hash;
  });
  return hashes;
}

}  // namespace angio::segmentation::detail
