#include "viewer/window/view_window.hpp"

#include <vtkCamera.h>
#include <vtkCommand.h>
#include <vtkGenericRenderWindowInteractor.h>
#include <vtkProperty.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "viewer/detail/case_data.hpp"
#include "viewer/detail/rendering.hpp"
#include "viewer/detail/scene.hpp"
#include "viewer/window/closing_signals.hpp"
#include "viewer/window/colors.hpp"
#include "viewer/window/recorder.hpp"

namespace angio::viewer::window {
namespace fs = std::filesystem;
namespace {

constexpr int kTickMs = 40;
constexpr double kPicturesPerSecond = 15.0;  // at least, while something moves

void place(vtkRenderer* renderer, const PixelBox& box, int width, int height) {
  renderer->SetViewport(double(box.left) / width, double(box.bottom) / height,
                        double(box.right()) / width, double(box.top()) / height);
  renderer->SetDraw(box.width > 0 ? 1 : 0);
  renderer->SetInteractive(box.width > 0 ? 1 : 0);
}

vtkSmartPointer<vtkTextActor> make_help() {
  auto text = detail::make_text(help_text(), 13, colors::kInk);
  vtkTextProperty* look = text->GetTextProperty();
  look->SetFontFamilyToCourier();
  look->SetBackgroundColor(0.05, 0.06, 0.08);
  look->SetBackgroundOpacity(0.93);
  look->SetVerticalJustificationToTop();
  text->VisibilityOff();
  return text;
}

std::string case_name(const fs::path& folder) {
  const fs::path path = fs::absolute(folder).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

}  // namespace

ViewWindow::ViewWindow(const fs::path& case_folder, const ViewOptions& options, Place where)
    : folder_(case_folder), options_(options), watch_(case_folder) {
  window_->SetOffScreenRendering(where == Place::off_screen ? 1 : 0);
  window_->SetMultiSamples(where == Place::off_screen ? 4 : 0);
  window_->SetNumberOfLayers(3);
  window_->SetSize(options.width, options.height);
  window_->SetWindowName(("angio: " + case_name(folder_)).c_str());
  ground_->SetBackground(colors::kPanel[0] / 255.0, colors::kPanel[1] / 255.0,
                         colors::kPanel[2] / 255.0);
  ground_->InteractiveOff();
  front_->SetLayer(2);
  front_->InteractiveOff();
  window_->AddRenderer(ground_);
  axes_ = detail::make_axes(1, detail::colors::kLightInk);
  window_->AddRenderer(axes_);
  window_->AddRenderer(front_);
  // VTK's list of X interactors, which its event loop goes through, keeps each for ever.
  if (where == Place::off_screen)
    interactor_ = vtkSmartPointer<vtkGenericRenderWindowInteractor>::New();
  else
    interactor_ = vtkSmartPointer<vtkRenderWindowInteractor>::New();
  interactor_->SetRenderWindow(window_);
  interactor_->SetInteractorStyle(mouse_);
  interactor_->SetDesiredUpdateRate(kPicturesPerSecond);
  controls_ = std::make_unique<ControlPanel>(
      interactor_, front_,
      ControlEvents{
          [this](Action action) { perform(action); },
          [this](Layer layer, double opacity) { views_->scene().set_opacity(layer, opacity); },
          [this](double time_s) {
            is_playing_ = false;
            show_time(time_s);
          }});
  measures_ = std::make_unique<Measures>(
      interactor_, [this](int x, int y) { return view_at(x, y); },
      [this](vtkRenderer* view) {
        return view == views_->scene().renderer() ? views_->scene().surfaces()
                                                  : std::vector<vtkActor*>();
      });
  help_ = make_help();
  front_->AddActor2D(help_);
  open_case();
  if (options.frame >= 0 && !views_->data().frames.empty()) {
    if (const int last = views_->data().frames.back().frame; options.frame > last)
      throw Error(ExitCode::usage, "--frame " + std::to_string(options.frame) +
                                       ": the case's frames end with " + std::to_string(last));
    views_->show_frame(detail::nearest_frame(views_->data().frames, options.frame));
  }
  clip_widget_->AddObserver(vtkCommand::InteractionEvent, this, &ViewWindow::on_clip);
  window_->AddObserver(vtkCommand::StartEvent, this, &ViewWindow::on_draw);
  interactor_->AddObserver(vtkCommand::KeyPressEvent, this, &ViewWindow::on_key);
  interactor_->AddObserver(vtkCommand::TimerEvent, this, &ViewWindow::tick);
  lay_out();
  views_->scene().look_at_lesion(scene_aspect());
  update();
}

ViewWindow::~ViewWindow() {
  measures_.reset();
  controls_.reset();
  close_case();
}

void ViewWindow::open_case() {
  views_ = std::make_unique<Views>(folder_);
  add_views();
  add_mouse();
}

void ViewWindow::close_case() {
  if (!views_) return;
  clip(false);
  if (measures_) measures_->erase();
  for (vtkRenderer* view : {views_->scene().renderer(), views_->slice().renderer(),
                            views_->section().renderer(), views_->curve().renderer()})
    window_->RemoveRenderer(view);
}

void ViewWindow::add_views() {
  for (vtkRenderer* view : {views_->scene().renderer(), views_->slice().renderer(),
                            views_->section().renderer(), views_->curve().renderer()})
    window_->AddRenderer(view);
}

void ViewWindow::add_mouse() {
  mouse_->SetDefaultRenderer(nullptr);
  mouse_->set_panels({{views_->slice().renderer(), views_->section().renderer()},
                      views_->curve().renderer(),
                      [this](int dx, int dy) {
                        views_->change_grey(0.5 * dx, -0.5 * dy);
                        update();
                      },
                      [this](vtkRenderer* panel, int steps) {
                        constexpr double kStepMm = 0.25;
                        if (panel == views_->slice().renderer())
                          views_->scroll_slice(steps);
                        else
                          views_->walk_to(views_->abscissa_mm() + kStepMm * steps);
                        update();
                      },
                      [this](int x) {
                        if (const auto place = views_->curve().abscissa_at(x, layout_.curve))
                          views_->walk_to(*place);
                        update();
                      }});
}

void ViewWindow::lay_out() {
  const int* size = window_->GetSize();
  width_ = std::max(size[0], 1);
  height_ = std::max(size[1], 1);
  layout_ = window::lay_out(width_, height_, panels_);
  place(views_->scene().renderer(), layout_.scene, width_, height_);
  place(views_->slice().renderer(), layout_.slice, width_, height_);
  place(views_->section().renderer(), layout_.section, width_, height_);
  place(views_->curve().renderer(), layout_.curve, width_, height_);
  controls_->lay_out(layout_);
  constexpr int kMargin = 14;
  help_->SetPosition(layout_.scene.left + kMargin, layout_.scene.top() - 4 * kMargin);
}

void ViewWindow::on_draw() {
  // What moves is drawn quickly, what stands still well.
  const bool is_moving = is_playing_ || mouse_->GetState() != VTKIS_NONE;
  views_->scene().renderer()->SetUseFXAA(!is_moving && options_.screenshot.empty());
  if (is_playing_) window_->SetDesiredUpdateRate(kPicturesPerSecond);
  const int* size = window_->GetSize();
  if (size[0] != width_ || size[1] != height_) lay_out();
  views_->scene().update_overlays();
  views_->slice().update_overlays();
  views_->section().update_overlays();
  detail::turn_axes(axes_, views_->scene().renderer(), width_, height_);
  constexpr int kAxesSide = 110;
  place(axes_, {layout_.scene.right() - kAxesSide, layout_.scene.bottom, kAxesSide, kAxesSide},
        width_, height_);
  axes_->InteractiveOff();
}

void ViewWindow::update() {
  const detail::CaseData& data = views_->data();
  std::string words = data.frames.empty()
                          ? "not dilated yet"
                          : detail::describe_frame(data, data.frames[views_->frame()]);
  views_->scene().set_words(message_.empty() ? words : words + "\n" + message_);
  ControlState state;
  state.is_on = [this](Action action) { return is_on(action); };
  state.opacity = [this](Layer layer) { return views_->scene().opacity(layer); };
  if (views_->field()) state.field = views_->fields()[*views_->field()].short_title();
  state.is_playing = is_playing_;
  if (!data.frames.empty()) {
    state.first_time_s = data.frames.front().time_s;
    state.last_time_s = data.frames.back().time_s;
  }
  state.time_s = views_->time_s();
  state.pressure_atm = views_->number("pressure_atm");
  state.highest_atm = views_->highest_pressure_atm();
  state.phase = views_->phase();
  controls_->refresh(state);
  window_->Render();
}

void ViewWindow::run() {
  interactor_->Initialize();
  interactor_->CreateRepeatingTimer(kTickMs);
  window_->Render();
  interactor_->Start();  // VTK forgets a window only where its loop ends: the first tick closes it
}

void ViewWindow::tick() {
  if (ClosingSignals::has_come()) return perform(Action::quit);
  if (!message_.empty() && Clock::now() > message_end_) {
    message_.clear();
    update();
  }
  follow_run();
  play_on();
}

void ViewWindow::follow_run() {
  constexpr std::chrono::milliseconds kEvery(500);
  if (Clock::now() - last_look_ < kEvery) return;
  last_look_ = Clock::now();
  const RunWatch::News news = watch_.look();
  if (news == RunWatch::News::none) return;
  try {
    const bool was_last = views_->frame() + 1 >= views_->data().frames.size();
    if (news == RunWatch::News::lumen || !views_->reload_frames()) {
      std::unique_ptr<Views> fresh = std::make_unique<Views>(folder_);
      fresh->scene().renderer()->GetActiveCamera()->DeepCopy(
          views_->scene().renderer()->GetActiveCamera());
      close_case();
      views_ = std::move(fresh);
      add_views();
      add_mouse();
      lay_out();
    } else if (was_last) {
      views_->show_frame(views_->data().frames.size() - 1);
    }
    say("read again: the run went on");
  } catch (const Error&) {
    // Files were moved while they were read: the next change, or the next look, finds them.
    watch_.forget();
  }
}

void ViewWindow::on_clip() { clip_look_->GetPlane(clip_plane_); }

void ViewWindow::press(const std::string& symbol) {
  interactor_->SetKeySym(symbol.c_str());
  interactor_->InvokeEvent(vtkCommand::KeyPressEvent);
}

void ViewWindow::on_key() {
  const char* symbol = interactor_->GetKeySym();
  if (const auto action = action_of_key(symbol ? symbol : "")) perform(*action);
}

detail::Picture ViewWindow::picture() {
  update();
  return detail::read_pixels(window_);
}

void ViewWindow::save(const fs::path& png) {
  update();
  save_picture(window_, png);
}

void ViewWindow::say(const std::string& message) {
  constexpr std::chrono::seconds kShown(5);
  message_ = message;
  message_end_ = Clock::now() + kShown;
  update();
}

vtkRenderer* ViewWindow::view_at(int x, int y) const {
  if (layout_.slice.contains(x, y)) return views_->slice().renderer();
  if (layout_.section.contains(x, y)) return views_->section().renderer();
  return layout_.scene.contains(x, y) ? views_->scene().renderer() : nullptr;
}

double ViewWindow::scene_aspect() const {
  return double(layout_.scene.width) / std::max(layout_.scene.height, 1);
}

}  // namespace angio::viewer::window
