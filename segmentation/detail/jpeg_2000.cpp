#include "segmentation/detail/jpeg_2000.hpp"

#include <openjpeg.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace angio::segmentation::detail {
namespace {

struct Reader {
  const std::vector<std::uint8_t>* bytes;
  std::size_t position = 0;
};

OPJ_SIZE_T read(void* buffer, OPJ_SIZE_T size, void* user) {
  auto* reader = static_cast<Reader*>(user);
  const std::size_t count = std::min<std::size_t>(size, reader->bytes->size() - reader->position);
  if (count == 0) return static_cast<OPJ_SIZE_T>(-1);
  std::memcpy(buffer, reader->bytes->data() + reader->position, count);
  reader->position += count;
  return count;
}

OPJ_OFF_T skip(OPJ_OFF_T size, void* user) {
  auto* reader = static_cast<Reader*>(user);
  const auto left = OPJ_OFF_T(reader->bytes->size() - reader->position);
  const OPJ_OFF_T step = std::clamp<OPJ_OFF_T>(size, 0, left);
  reader->position += std::size_t(step);
  return step;
}

OPJ_BOOL seek(OPJ_OFF_T position, void* user) {
  auto* reader = static_cast<Reader*>(user);
  if (position < 0 || std::size_t(position) > reader->bytes->size()) return OPJ_FALSE;
  reader->position = std::size_t(position);
  return OPJ_TRUE;
}

/// OpenJPEG's streams and codecs are both void*, so each needs its own end.
template <class Handle, void (*destroy)(Handle*)>
struct Destroy {
  void operator()(Handle* handle) const { destroy(handle); }
};
using Stream = std::unique_ptr<opj_stream_t, Destroy<opj_stream_t, opj_stream_destroy>>;
using Codec = std::unique_ptr<opj_codec_t, Destroy<opj_codec_t, opj_destroy_codec>>;
using Image = std::unique_ptr<opj_image_t, Destroy<opj_image_t, opj_image_destroy>>;

}  // namespace

std::string decode_jpeg_2000(const std::vector<std::uint8_t>& bytes, int columns, int rows,
                             std::uint16_t* out) {
  const bool raw = bytes.size() > 2 && bytes[0] == 0xff && bytes[1] == 0x4f;
  Reader reader{&bytes};
  const Stream stream(opj_stream_default_create(OPJ_TRUE));
  const Codec codec(opj_create_decompress(raw ? OPJ_CODEC_J2K : OPJ_CODEC_JP2));
  opj_stream_set_user_data(stream.get(), &reader, nullptr);
  opj_stream_set_user_data_length(stream.get(), bytes.size());
  opj_stream_set_read_function(stream.get(), read);
  opj_stream_set_skip_function(stream.get(), skip);
  opj_stream_set_seek_function(stream.get(), seek);
  opj_dparameters_t parameters;
  opj_set_default_decoder_parameters(&parameters);
  opj_image_t* header = nullptr;
  if (!opj_setup_decoder(codec.get(), &parameters) ||
      !opj_read_header(stream.get(), codec.get(), &header))
    return "the stream's header is damaged";
  const Image image(header);
  // Strict: a stream that ends early must not come back as a picture.
  opj_decoder_set_strict_mode(codec.get(), OPJ_TRUE);
  if (image->numcomps != 1 || image->x1 - image->x0 != OPJ_UINT32(columns) ||
      image->y1 - image->y0 != OPJ_UINT32(rows))
    return "the stream's size is not the header's";
  if (!opj_decode(codec.get(), stream.get(), image.get()) ||
      !opj_end_decompress(codec.get(), stream.get()))
    return "the stream is truncated or damaged";
  const opj_image_comp_t& component = image->comps[0];
  if (!component.data || component.w != OPJ_UINT32(columns) || component.h != OPJ_UINT32(rows))
    return "the stream is truncated or damaged";
  const std::size_t count = std::size_t(columns) * std::size_t(rows);
  for (std::size_t p = 0; p < count; ++p) out[p] = std::uint16_t(component.data[p]);
  return {};
}

}  // namespace angio::segmentation::detail
