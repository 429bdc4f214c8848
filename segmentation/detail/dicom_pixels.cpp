#include "segmentation/detail/dicom_pixels.hpp"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcpixel.h>
#include <dcmtk/dcmdata/dcpixseq.h>
#include <dcmtk/dcmdata/dcpxitem.h>
#include <dcmtk/dcmdata/dcrledrg.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmjpeg/djdecode.h>
#include <dcmtk/dcmjpls/djdecode.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <limits>
#include <mutex>

#include "core/error.hpp"
#include "segmentation/detail/jpeg_2000.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr rlim_t kDecodeSeconds = 600;  ///< CPU time after which a damaged stream is given up

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

std::size_t frame_size(const DicomHeader& header) {
  return std::size_t(header.rows) * std::size_t(header.columns);
}

/// Stored pixels as they lie in the file, one number per pixel, not yet masked or signed.
void copy_native(DcmDataset& dataset, const DicomHeader& header, std::uint16_t* out) {
  const std::size_t count = frame_size(header) * header.frames.size();
  unsigned long available = 0;
  if (header.bits_allocated == 8) {
    const Uint8* pixels = nullptr;
    if (dataset.findAndGetUint8Array(DCM_PixelData, pixels, &available).bad() || !pixels ||
        available < count)
      fail(header, "the pixel data are truncated or damaged");
    std::copy(pixels, pixels + count, out);
  } else {
    const Uint16* pixels = nullptr;
    if (dataset.findAndGetUint16Array(DCM_PixelData, pixels, &available).bad() || !pixels ||
        available < count)
      fail(header, "the pixel data are truncated or damaged");
    std::copy(pixels, pixels + count, out);
  }
}

/// The bytes of each frame's compressed stream. One item per frame, or all items one frame.
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
  const std::size_t item_count = sequence->card() > 0 ? sequence->card() - 1 : 0;
  const std::size_t frame_count = header.frames.size();
  if (item_count != frame_count && frame_count != 1)
    fail(header, "its frames are cut into fragments");
  std::vector<std::vector<std::uint8_t>> streams(frame_count);
  for (std::size_t item = 0; item < item_count; ++item) {
    DcmPixelItem* fragment = nullptr;
    Uint8* bytes = nullptr;
    if (sequence->getItem(fragment, static_cast<unsigned long>(item + 1)).bad() || !fragment ||
        fragment->getUint8Array(bytes).bad() || !bytes)
      fail(header, "a fragment cannot be read");
    auto& stream = streams[frame_count == 1 ? 0 : item];
    stream.insert(stream.end(), bytes, bytes + fragment->getLength());
  }
  return streams;
}

void decode_stored(const DicomHeader& header, std::uint16_t* out) {
  DcmFileFormat file;
  if (file.loadFile(header.path.c_str()).bad()) fail(header, "the file is truncated or damaged");
  DcmDataset& dataset = *file.getDataset();
  if (header.jpeg_2000) {
    const auto streams = frame_streams(dataset, header);
    for (std::size_t f = 0; f < streams.size(); ++f) {
      const std::string problem =
          decode_jpeg_2000(streams[f], header.columns, header.rows, out + f * frame_size(header));
      if (!problem.empty()) fail(header, problem);
    }
    return;
  }
  if (header.compressed) {
    register_decoders();
    if (dataset.chooseRepresentation(EXS_LittleEndianExplicit, nullptr).bad())
      fail(header, "the stream is damaged, or of a kind that is not supported");
  }
  copy_native(dataset, header, out);
}

/// Takes the stored bits out of a pixel, with their sign.
int stored_value(std::uint16_t raw, const DicomHeader& header) {
  const int shift = header.high_bit + 1 - header.bits_stored;
  const int mask = (1 << header.bits_stored) - 1;
  const int value = (int(raw) >> shift) & mask;
  const int sign = 1 << (header.bits_stored - 1);
  return header.is_signed && (value & sign) ? value - mask - 1 : value;
}

void rescale(const DicomHeader& header, const std::uint16_t* raw, float* out) {
  const int least = header.is_signed ? -(1 << (header.bits_stored - 1)) : 0;
  const int most = least + (1 << header.bits_stored) - 1;
  const std::size_t count = frame_size(header);
  for (std::size_t f = 0; f < header.frames.size(); ++f) {
    const DicomFrame& frame = header.frames[f];
    float lowest = std::numeric_limits<float>::infinity();
    std::vector<std::size_t> padded;
    for (std::size_t p = f * count; p < (f + 1) * count; ++p) {
      const int stored = stored_value(raw[p], header);
      const int shown = header.is_monochrome1 ? least + most - stored : stored;
      out[p] = float(frame.slope * double(shown) + frame.intercept);
      if (header.padding_value && stored == *header.padding_value)
        padded.push_back(p);
      else
        lowest = std::min(lowest, out[p]);
    }
    if (padded.size() < count)
      for (std::size_t p : padded) out[p] = lowest;
  }
}

/// Memory that a child process fills for its parent.
class SharedMemory {
 public:
  explicit SharedMemory(std::size_t size)
      : size_(size),
        memory_(mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
    if (memory_ == MAP_FAILED)
      throw IoError("not enough memory to decode the pixels. Crop the series, or close programs");
  }
  ~SharedMemory() { munmap(memory_, size_); }
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  [[nodiscard]] void* data() const { return memory_; }

 private:
  std::size_t size_;
  void* memory_;
};

/// Runs decode_stored on each object in one child process; out is shared memory.
void decode_in_child(const std::vector<const DicomHeader*>& headers, std::uint16_t* out) {
  constexpr std::size_t kMessageSize = 512;
  SharedMemory message(kMessageSize);
  auto* text = static_cast<char*>(message.data());
  const pid_t child = fork();
  if (child < 0) throw IoError("cannot start the decoder (" + std::string(strerror(errno)) + ")");
  if (child == 0) {
    const rlimit cpu{kDecodeSeconds, kDecodeSeconds};
    setrlimit(RLIMIT_CPU, &cpu);
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    int status = 0;
    try {
      for (const DicomHeader* header : headers) {
        decode_stored(*header, out);
        out += frame_size(*header) * header->frames.size();
      }
    } catch (const std::exception& error) {
      std::strncpy(text, error.what(), kMessageSize - 1);
      status = 1;
    }
    _exit(status);  // no destructors: they belong to the parent
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  if (text[0] != '\0') throw InputError(text);
  fail(*headers.front(), "the decoder broke down on a damaged stream in this series");
}

/// Stored pixels of some objects, one after another.
template <class Use>
void decode_objects(const std::vector<const DicomHeader*>& headers, const Use& use) {
  std::size_t count = 0;
  for (const DicomHeader* header : headers) count += frame_size(*header) * header->frames.size();
  const bool compressed = std::any_of(headers.begin(), headers.end(),
                                      [](const DicomHeader* header) { return header->compressed; });
  if (compressed) {
    SharedMemory memory(count * sizeof(std::uint16_t));
    auto* raw = static_cast<std::uint16_t*>(memory.data());
    decode_in_child(headers, raw);
    for (std::size_t h = 0; h < headers.size(); ++h) {
      use(h, raw);
      raw += frame_size(*headers[h]) * headers[h]->frames.size();
    }
    return;
  }
  std::vector<std::uint16_t> raw;
  for (std::size_t h = 0; h < headers.size(); ++h) {
    raw.resize(frame_size(*headers[h]) * headers[h]->frames.size());
    decode_stored(*headers[h], raw.data());
    use(h, raw.data());
  }
}

}  // namespace

std::vector<float> decode_frames(const DicomHeader& header) {
  std::vector<float> values(frame_size(header) * header.frames.size());
  decode_objects({&header}, [&](std::size_t, const std::uint16_t* raw) {
    rescale(header, raw, values.data());
  });
  return values;
}

std::vector<float> decode_series(const DicomSeries& series, const Progress& progress) {
  std::vector<const DicomHeader*> headers;
  for (const auto& header : series.headers) headers.push_back(&header);
  std::vector<std::vector<std::size_t>> slice_of(series.headers.size());
  for (std::size_t h = 0; h < slice_of.size(); ++h)
    slice_of[h].resize(series.headers[h].frames.size());
  for (std::size_t k = 0; k < series.slices.size(); ++k) {
    const auto [h, f] = series.slices[k];
    slice_of[std::size_t(h)][std::size_t(f)] = k;
  }
  const std::size_t slice_size = frame_size(series.headers.front());
  std::vector<float> values(slice_size * series.slices.size());
  std::vector<float> object;
  decode_objects(headers, [&](std::size_t h, const std::uint16_t* raw) {
    object.resize(slice_size * slice_of[h].size());
    rescale(*headers[h], raw, object.data());
    for (std::size_t f = 0; f < slice_of[h].size(); ++f)
      std::copy_n(object.begin() + std::ptrdiff_t(f * slice_size), slice_size,
                  values.begin() + std::ptrdiff_t(slice_of[h][f] * slice_size));
    if (h % 16 == 0)
      progress.report(0.5 + 0.5 * double(h) / double(headers.size()), "reading pixels");
  });
  return values;
}

}  // namespace angio::segmentation::detail
