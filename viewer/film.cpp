#include "viewer/film.hpp"

#include <vtkNew.h>
#include <vtkProperty.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/text.hpp"
#include "viewer/detail/course.hpp"
#include "viewer/detail/film_file.hpp"
#include "viewer/detail/offscreen.hpp"
#include "viewer/detail/pictures_3d.hpp"
#include "viewer/detail/rendering.hpp"
#include "viewer/detail/scene.hpp"
#include "viewer/detail/sheet.hpp"

namespace angio::viewer {
namespace fs = std::filesystem;
using namespace detail;
namespace {

constexpr double kStripShare = 0.11;  // of the picture's height, above and below, for words

/// What all pictures of a film share.
struct Set {
  const Course& course;
  ViewFrame frame;
  TriangleMesh context;  ///< the lumen around the wall
  vtkSmartPointer<vtkColorTransferFunction> colors;

  explicit Set(const Course& from) : course(from), frame(balloon_frame(from.content)) {
    const Moment& first = from.content.moments.front();
    const Bounds around = bounds(first.wall);
    context = surroundings(from.content.lumen, first.wall, around.center, 1.4 * around.radius_mm);
    colors = make_pressure_colors(usual_peak(from.content.moments));
    frame.half_height_mm /= 1.0 - 2.0 * kStripShare;
  }
};

/// "1.250 s    6.0 atm    lumen 2.31 mm"; what the time series does not know is left out.
std::string caption_of(const Course& course, const FrameFiles& files) {
  std::string text = formats::fixed_text(files.time_s, 3) + " s";
  const double pressure = value_at(course, files, "pressure_atm");
  if (std::isfinite(pressure)) text += "    " + formats::fixed_text(pressure, 1) + " atm";
  const double diameter = value_at(course, files, "lumen_mld_mm");
  if (std::isfinite(diameter))
    text += "    narrowest lumen " + formats::fixed_text(diameter, 2) + " mm";
  return text;
}

/// Adds surfaces that lie in each other, the outermost first, each as its far and its near side, so
/// that they blend in this order: far sides inwards, near sides outwards.
void add_nested(vtkRenderer* renderer, const std::vector<vtkSmartPointer<vtkActor>>& surfaces) {
  for (const auto& near : surfaces) {
    if (near->HasTranslucentPolygonalGeometry() == 0) continue;
    vtkNew<vtkActor> far;
    vtkNew<vtkProperty> look;
    look->DeepCopy(near->GetProperty());
    look->FrontfaceCullingOn();
    far->SetMapper(near->GetMapper());
    far->SetProperty(look);
    far->SetForceTranslucent(near->GetForceTranslucent());
    renderer->AddActor(far);
    near->GetProperty()->BackfaceCullingOn();
  }
  for (auto near = surfaces.rbegin(); near != surfaces.rend(); ++near) renderer->AddActor(*near);
}

Picture draw_picture(const Set& set, const FrameFiles& files, const FilmOptions& options) {
  const Moment moment = read_moment(files);
  const auto renderer = make_stage();
  std::vector<vtkSmartPointer<vtkActor>> nested;  // the outermost first
  if (!set.context.triangles.empty())
    nested.push_back(make_surface(set.context, {colors::kSurroundings, 0.25}));
  nested.push_back(make_surface(moment.wall, {colors::kLumen, 1.0}));
  color_by_translucent(nested.back(), moment.contact_pressure_kpa, set.colors);
  for (const auto& actor : make_balloon(moment.balloon, moment.guidewire)) nested.push_back(actor);
  add_nested(renderer, nested);
  aim(renderer, set.frame, double(options.width) / options.height);

  const double strip = kStripShare * options.height;
  const auto text = make_text(caption_of(set.course, files), int(0.45 * strip), colors::kInk);
  text->SetPosition(0.35 * strip, options.height - 0.75 * strip);
  text->GetTextProperty()->SetBackgroundColor(1.0, 1.0, 1.0);
  text->GetTextProperty()->SetBackgroundOpacity(0.85);
  renderer->AddActor2D(text);
  const double width = options.width;
  add_color_bar(renderer, set.colors, "contact pressure [kPa]",
                {0.62 * width, 24.0, 0.34 * width, 12.0}, 1, colors::kInk);
  ScaleBar bar(renderer, 1, colors::kInk);
  return render_offscreen(
      {renderer}, options.width, options.height, [&] { bar.update(); }, PictureFor::film);
}

/// The place of the written frame nearest to a time [s].
std::size_t frame_at(const std::vector<FrameFiles>& frames, double time_s) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < frames.size(); ++i)
    if (std::abs(frames[i].time_s - time_s) < std::abs(frames[nearest].time_s - time_s))
      nearest = i;
  return nearest;
}

void require_range(const char* name, int value, int least, int most, const char* also = "") {
  if (value < least || value > most || (*also != '\0' && value % 2 != 0))
    throw OptionError(std::string("the film's ") + name + " is " + std::to_string(value) +
                      " (codecs and memory allow" + also + " numbers from " +
                      std::to_string(least) + " to " + std::to_string(most) + "). Give another");
}

}  // namespace

void FilmOptions::validate() const {
  require_range("width", width, 160, 3840, " even");
  require_range("height", height, 120, 2160, " even");
  require_range("rate", pictures_per_second, 1, 60);
}

int write_film(const fs::path& case_folder, const fs::path& film, const FilmOptions& options,
               const Progress& progress) {
  options.validate();
  film_kind(film);
  const Course course = read_course(case_folder);
  const OffscreenDisplay display;
  const Set set(course);
  const auto& frames = course.data.frames;
  const double start = frames.front().time_s, duration = frames.back().time_s - start;
  const int count = int(std::floor(duration * options.pictures_per_second + 1e-9)) + 1;
  write_atomically(film, [&](const fs::path& temporary) {
    FilmFile file(temporary, film, options.width, options.height, options.pictures_per_second);
    Picture picture;
    std::optional<std::size_t> shown;
    for (int i = 0; i < count; ++i) {
      progress.report(double(i) / count, "drawing");
      const std::size_t place = frame_at(frames, start + double(i) / options.pictures_per_second);
      if (shown != place) picture = draw_picture(set, frames[place], options);
      shown = place;
      file.add(picture);
    }
    file.close();
  });
  progress.report(1.0);
  return count;
}

}  // namespace angio::viewer
