// What the keys and buttons of the window do.
#include <vtkCamera.h>
#include <vtkCellPicker.h>
#include <vtkProperty.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "viewer/window/recorder.hpp"
#include "viewer/window/view_window.hpp"

namespace angio::viewer::window {
namespace fs = std::filesystem;
namespace {

constexpr double kWalkMm = 0.5;

constexpr std::array<std::pair<Action, Layer>, kLayerCount> kLayerActions{{
    {Action::show_lumen, Layer::lumen},
    {Action::show_wall, Layer::wall},
    {Action::show_balloon, Layer::balloon},
    {Action::show_wire, Layer::wire},
    {Action::show_line, Layer::line},
    {Action::show_slice, Layer::slice},
    {Action::show_projection, Layer::projection},
}};

constexpr std::array<std::pair<Action, SliceAxis>, 3> kAxisActions{{
    {Action::slice_axial, SliceAxis::axial},
    {Action::slice_coronal, SliceAxis::coronal},
    {Action::slice_sagittal, SliceAxis::sagittal},
}};

}  // namespace

void ViewWindow::perform(Action action) {
  if (action == Action::quit) {
    is_closing_ = true;
    return interactor_->TerminateApp();
  }
  [[maybe_unused]] const bool is_done = perform_player(action) || perform_layer(action) ||
                                        perform_camera(action) || perform_slices(action) ||
                                        perform_tool(action);
  ANGIO_EXPECT(is_done);
  update();
}

bool ViewWindow::is_on(Action action) const {
  for (const auto& [switch_action, layer] : kLayerActions)
    if (action == switch_action) return views_->scene().is_visible(layer);
  for (const auto& [axis_action, axis] : kAxisActions)
    if (action == axis_action) return views_->slice_axis() == axis;
  switch (action) {
    case Action::play:
      return is_playing_;
    case Action::loop:
      return loops_;
    case Action::no_field:
      return views_->field().has_value();
    case Action::slab:
      return views_->is_slab();
    case Action::clip:
      return is_clipped_;
    case Action::measure_distance:
      return measures_->is_waiting(MeasureKind::distance);
    case Action::measure_angle:
      return measures_->is_waiting(MeasureKind::angle);
    case Action::as_wireframe:
      return is_wireframe_;
    case Action::as_surface:
      return !is_wireframe_;
    case Action::help:
      return help_->GetVisibility() != 0;
    default:
      return false;
  }
}

// ---- time
// ----------------------------------------------------------------------------------------

bool ViewWindow::perform_player(Action action) {
  const std::size_t count = views_->data().frames.size(), now = views_->frame();
  switch (action) {
    case Action::play:
      is_playing_ = !is_playing_ && count > 1;
      if (is_playing_ && now + 1 == count) views_->show_frame(0);
      play_from_s_ = views_->time_s();
      play_start_ = Clock::now();
      if (!is_playing_) window_->SetDesiredUpdateRate(interactor_->GetStillUpdateRate());
      return true;
    case Action::loop:
      loops_ = !loops_;
      return true;
    case Action::step_back:
      show(now == 0 ? 0 : now - 1);
      return true;
    case Action::step_on:
      show(now + 1);
      return true;
    case Action::first_frame:
      show(0);
      return true;
    case Action::last_frame:
      show(count == 0 ? 0 : count - 1);
      return true;
    default:
      return false;
  }
}

void ViewWindow::show(std::size_t frame) {
  is_playing_ = false;
  views_->show_frame(frame);
}

void ViewWindow::show_time(double time_s) {
  const std::size_t frame = views_->frame_at(time_s);
  if (frame == views_->frame()) return;
  views_->show_frame(frame);
  update();
}

void ViewWindow::play_on() {
  if (!is_playing_) return;
  const auto& frames = views_->data().frames;
  const double played_s = std::chrono::duration<double>(Clock::now() - play_start_).count();
  const double time_s = play_from_s_ + played_s;
  if (time_s <= frames.back().time_s) return show_time(time_s);
  if (loops_) {
    play_from_s_ = frames.front().time_s;
    play_start_ = Clock::now();
    return show_time(play_from_s_);
  }
  is_playing_ = false;
  views_->show_frame(frames.size() - 1);
  update();
}

// ---- what is shown
// -------------------------------------------------------------------------------

bool ViewWindow::perform_layer(Action action) {
  SceneView& scene = views_->scene();
  for (const auto& [switch_action, layer] : kLayerActions) {
    if (action != switch_action) continue;
    scene.set_visible(layer, !scene.is_visible(layer));
    return true;
  }
  switch (action) {
    case Action::next_field:
      choose_field(1);
      return true;
    case Action::previous_field:
      choose_field(-1);
      return true;
    case Action::no_field:
      views_->color_by(std::nullopt);
      return true;
    case Action::as_wireframe:
    case Action::as_surface:
      is_wireframe_ = action == Action::as_wireframe;
      scene.set_drawn(is_wireframe_ ? Drawn::as_wireframe : Drawn::as_surface);
      return true;
    default:
      return false;
  }
}

/// Round and round: plain, the first field, the next ...
void ViewWindow::choose_field(int step) {
  const int count = int(views_->fields().size()) + 1;
  const int now = views_->field() ? int(*views_->field()) + 1 : 0;
  const int next = (now + step + count) % count;
  views_->color_by(next == 0 ? std::nullopt : std::optional(std::size_t(next - 1)));
}

// ---- from where
// ----------------------------------------------------------------------------------

bool ViewWindow::perform_camera(Action action) {
  switch (action) {
    case Action::look_at_lesion:
      views_->scene().look_at_lesion(scene_aspect());
      return true;
    case Action::look_at_tree:
      views_->scene().look_at_tree(scene_aspect());
      return true;
    case Action::reset_camera: {
      const int* place = interactor_->GetEventPosition();
      vtkRenderer* view = view_at(place[0], place[1]);
      if (!view) view = views_->scene().renderer();
      if (view == views_->scene().renderer())
        view->ResetCamera();
      else
        views_->center_panels();
      return true;
    }
    case Action::go_to_pick:
    case Action::fly_to_pick:
      pick(action);
      return true;
    default:
      return false;
  }
}

void ViewWindow::pick(Action action) {
  const int* place = interactor_->GetEventPosition();
  vtkRenderer* view = view_at(place[0], place[1]);
  if (!view) return;
  const bool is_scene = view == views_->scene().renderer();
  vtkNew<vtkCellPicker> picker;
  if (is_scene) {
    picker->PickFromListOn();
    for (vtkActor* surface : views_->scene().surfaces()) picker->AddPickList(surface);
  }
  if (!picker->Pick(place[0], place[1], 0.0, view)) return say("nothing lies under the pointer");
  Vec3 point;
  picker->GetPickPosition(&point.x);
  if (action == Action::go_to_pick) return views_->walk_to_point(point);
  if (is_scene) {
    vtkCamera* camera = view->GetActiveCamera();
    double direction[3];
    camera->GetDirectionOfProjection(direction);
    const double distance = camera->GetDistance();
    camera->SetFocalPoint(&point.x);
    camera->SetPosition(point.x - distance * direction[0], point.y - distance * direction[1],
                        point.z - distance * direction[2]);
    view->ResetCameraClippingRange();
  }
}

bool ViewWindow::perform_slices(Action action) {
  for (const auto& [axis_action, axis] : kAxisActions) {
    if (action != axis_action) continue;
    views_->set_slice_axis(axis);
    return true;
  }
  switch (action) {
    case Action::walk_back:
      views_->walk_to(views_->abscissa_mm() - kWalkMm);
      return true;
    case Action::walk_on:
      views_->walk_to(views_->abscissa_mm() + kWalkMm);
      return true;
    case Action::walk_to_lesion:
      views_->walk_to(views_->line().start_mm());
      return true;
    case Action::slab:
      views_->set_slab(!views_->is_slab());
      return true;
    case Action::reset_grey:
      views_->reset_grey();
      return true;
    default:
      return false;
  }
}

// ---- tools
// ---------------------------------------------------------------------------------------

bool ViewWindow::perform_tool(Action action) {
  switch (action) {
    case Action::clip:
      clip(!is_clipped_);
      return true;
    case Action::measure_distance:
      measures_->start(MeasureKind::distance);
      return true;
    case Action::measure_angle:
      measures_->start(MeasureKind::angle);
      return true;
    case Action::erase_measures:
      measures_->erase();
      return true;
    case Action::save_picture: {
      const fs::path path = free_name(options_.save_folder, "angio_view", ".png");
      save(path);
      say("saved " + path.string());
      return true;
    }
    case Action::save_film:
      film();
      return true;
    case Action::toggle_panels:
      panels_ = panels_ == Panels::shown ? Panels::hidden : Panels::shown;
      lay_out();
      return true;
    case Action::help:
      help_->SetVisibility(help_->GetVisibility() ? 0 : 1);
      return true;
    default:
      return false;
  }
}

void ViewWindow::clip(bool is_clipped) {
  is_clipped_ = is_clipped;
  SceneView& scene = views_->scene();
  scene.set_clipping(is_clipped ? clip_plane_.Get() : nullptr);
  if (!is_clipped) return clip_widget_->Off();
  double direction[3];
  scene.renderer()->GetActiveCamera()->GetDirectionOfProjection(direction);
  const Vec3 middle = scene.point_of_interest();
  const double reach = scene.reach_mm();
  double box[6] = {middle.x - reach, middle.x + reach, middle.y - reach,
                   middle.y + reach, middle.z - reach, middle.z + reach};
  clip_look_->SetPlaceFactor(1.0);
  clip_look_->PlaceWidget(box);
  clip_look_->SetOrigin(middle.x, middle.y, middle.z);
  clip_look_->SetNormal(direction);  // what lies nearer than the plane goes
  clip_look_->DrawPlaneOff();
  clip_look_->OutlineTranslationOff();
  clip_look_->ScaleEnabledOff();
  clip_look_->GetOutlineProperty()->SetColor(0.45, 0.48, 0.55);
  clip_look_->GetPlane(clip_plane_);
  clip_widget_->SetInteractor(interactor_);
  clip_widget_->SetDefaultRenderer(scene.renderer());
  clip_widget_->SetCurrentRenderer(scene.renderer());
  clip_widget_->SetRepresentation(clip_look_);
  clip_widget_->On();
}

/// In real time, from the first frame to the last.
void ViewWindow::film() {
  constexpr int kPicturesPerSecond = 25;
  const auto& frames = views_->data().frames;
  if (frames.size() < 2) return say("no frames to film");
  const double length_s = frames.back().time_s - frames.front().time_s;
  const fs::path path = free_name(options_.save_folder, "angio_view", ".ogv");
  const std::size_t before = views_->frame();
  const int count = int(std::ceil(length_s * kPicturesPerSecond)) + 1;
  save_film(window_, path, count, kPicturesPerSecond, [&](int picture) {
    const std::size_t frame =
        views_->frame_at(frames.front().time_s + double(picture) / kPicturesPerSecond);
    if (picture > 0 && frame == views_->frame()) return false;
    views_->show_frame(frame);
    update();
    return true;
  });
  show(before);
  say("saved " + path.string());
}

}  // namespace angio::viewer::window
