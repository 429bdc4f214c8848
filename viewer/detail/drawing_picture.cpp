#include "viewer/detail/drawing_picture.hpp"

#include <cairo.h>
#include <librsvg/rsvg.h>

#include <cmath>
#include <cstdint>
#include <memory>

#include "core/error.hpp"

namespace angio::viewer::detail {
namespace {

struct Release {
  void operator()(RsvgHandle* handle) const { g_object_unref(handle); }
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_t* cairo) const { cairo_destroy(cairo); }
};
template <class Thing>
using Owned = std::unique_ptr<Thing, Release>;

/// cairo's opaque pixels: 32 bits each, red in the third byte of the number.
Picture picture_of(cairo_surface_t* surface, int width, int height) {
  cairo_surface_flush(surface);
  const unsigned char* rows = cairo_image_surface_get_data(surface);
  const auto stride = std::size_t(cairo_image_surface_get_stride(surface));
  Picture picture = blank_picture(width, height);
  for (std::size_t y = 0, at = 0; y < std::size_t(height); ++y) {
    const auto* row = reinterpret_cast<const std::uint32_t*>(rows + y * stride);
    for (std::size_t x = 0; x < std::size_t(width); ++x)
      for (const unsigned shift : {16U, 8U, 0U})
        picture.rgb[at++] = std::uint8_t(row[x] >> shift & 0xFFU);
  }
  return picture;
}

}  // namespace

Picture drawing_picture(const std::string& svg, int scale) {
  const Owned<RsvgHandle> drawing(
      rsvg_handle_new_from_data(reinterpret_cast<const guint8*>(svg.data()), svg.size(), nullptr));
  double width = 0.0, height = 0.0;
  if (!drawing || !rsvg_handle_get_intrinsic_size_in_pixels(drawing.get(), &width, &height))
    throw Error(ExitCode::internal, "a drawing of this program is no SVG");
  const RsvgRectangle place{0.0, 0.0, scale * width, scale * height};
  const int columns = int(std::lround(place.width)), rows = int(std::lround(place.height));
  const Owned<cairo_surface_t> surface(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, columns, rows));
  const Owned<cairo_t> cairo(cairo_create(surface.get()));
  cairo_set_source_rgb(cairo.get(), 1.0, 1.0, 1.0);
  cairo_paint(cairo.get());
  if (!rsvg_handle_render_document(drawing.get(), cairo.get(), &place, nullptr) ||
      cairo_status(cairo.get()) != CAIRO_STATUS_SUCCESS)
    throw Error(ExitCode::unavailable, "a plot could not be drawn (is memory short?)");
  return picture_of(surface.get(), columns, rows);
}

}  // namespace angio::viewer::detail
