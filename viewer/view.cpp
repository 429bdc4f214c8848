#include "viewer/view.hpp"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkProperty2D.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkSliderRepresentation2D.h>
#include <vtkSliderWidget.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/vtk_messages.hpp"
#include "viewer/detail/case_data.hpp"
#include "viewer/detail/case_scene.hpp"
#include "viewer/detail/offscreen.hpp"
#include "viewer/detail/scene.hpp"

namespace angio::viewer {
namespace fs = std::filesystem;
using detail::CaseData;
using detail::CaseScene;
using detail::ScenePart;
namespace {

constexpr int kTimerMs = 40;

std::string display_name() {
  const char* display = std::getenv("DISPLAY");
  return display ? display : "";
}

/// The mouse as in VTK's own style; the letter keys are ours.
class MouseStyle : public vtkInteractorStyleTrackballCamera {
 public:
  static MouseStyle* New();
  vtkTypeMacro(MouseStyle, vtkInteractorStyleTrackballCamera);
  void OnChar() override {}
};
vtkStandardNewMacro(MouseStyle);

std::size_t first_frame(const CaseData& data, const ViewOptions& options) {
  return options.frame < 0 ? detail::peak_frame(data)
                           : detail::nearest_frame(data.frames, options.frame);
}

vtkSmartPointer<vtkSliderRepresentation2D> make_slider(const CaseData& data, int scale) {
  auto slider = vtkSmartPointer<vtkSliderRepresentation2D>::New();
  slider->SetMinimumValue(data.frames.front().time_s);
  slider->SetMaximumValue(std::max(data.frames.back().time_s, data.frames.front().time_s + 1e-9));
  slider->SetTitleText("time [s]");
  slider->SetLabelFormat("%.2f");
  slider->GetPoint1Coordinate()->SetCoordinateSystemToNormalizedViewport();
  slider->GetPoint1Coordinate()->SetValue(0.3, 0.075);
  slider->GetPoint2Coordinate()->SetCoordinateSystemToNormalizedViewport();
  slider->GetPoint2Coordinate()->SetValue(0.8, 0.075);
  slider->SetSliderLength(0.012);
  slider->SetSliderWidth(0.03);
  slider->SetTubeWidth(0.006);
  slider->SetEndCapLength(0.004);
  slider->SetEndCapWidth(0.016);
  slider->GetSliderProperty()->SetColor(0.18, 0.51, 0.88);
  slider->GetTubeProperty()->SetColor(0.6, 0.62, 0.66);
  slider->GetCapProperty()->SetColor(0.6, 0.62, 0.66);
  for (vtkTextProperty* text : {slider->GetTitleProperty(), slider->GetLabelProperty()}) {
    text->SetColor(0.87, 0.89, 0.91);
    text->ShadowOff();
    text->BoldOff();
    text->SetFontSize(14 * scale);
  }
  slider->SetTitleHeight(0.018);
  slider->SetLabelHeight(0.018);
  return slider;
}

void write_screenshot(const CaseData& data, const ViewOptions& options) {
  const detail::OffscreenDisplay display;
  CaseScene scene(data, detail::kSupersampling);
  scene.show_frame(first_frame(data, options));
  scene.look_at_lesion(double(options.width) / options.height);
  vtkSmartPointer<vtkSliderRepresentation2D> slider;
  if (!data.frames.empty()) {
    slider = make_slider(data, detail::kSupersampling);
    slider->SetValue(data.frames[scene.frame()].time_s);
    scene.layers().front()->AddViewProp(slider);
    slider->SetRenderer(scene.layers().front());
  }
  const detail::Picture picture =
      detail::render_offscreen(scene.layers(), options.width, options.height, [&] {
        scene.update_overlays();
        if (slider) slider->BuildRepresentation();
      });
  write_text_atomically(options.screenshot, detail::png_bytes(picture));
}

/// The open window: keys, slider and clock move the scene.
class CaseWindow {
 public:
  CaseWindow(const CaseData& data, const ViewOptions& options)
      : data_(data), scene_(data, 1), aspect_(double(options.width) / options.height) {
    window_->SetNumberOfLayers(2);
    window_->SetSize(options.width, options.height);
    window_->SetWindowName("angio");
    window_->SetMultiSamples(0);  // with multisampling VTK would leave out what is peeled
    window_->SetAlphaBitPlanes(1);
    for (vtkRenderer* layer : scene_.layers()) window_->AddRenderer(layer);
    vtkRenderer* front = scene_.layers().front();
    front->SetUseFXAA(true);
    front->SetUseDepthPeeling(1);
    front->SetMaximumNumberOfPeels(8);
    front->SetOcclusionRatio(0.05);
    interactor_->SetRenderWindow(window_);
    vtkNew<MouseStyle> style;
    style->SetDefaultRenderer(front);
    interactor_->SetInteractorStyle(style);
    scene_.show_frame(first_frame(data, options));
    scene_.look_at_lesion(aspect_);
    add_slider();
    connect(window_, vtkCommand::StartEvent, &CaseWindow::on_draw);
    connect(interactor_, vtkCommand::KeyPressEvent, &CaseWindow::on_key);
    connect(interactor_, vtkCommand::TimerEvent, &CaseWindow::on_timer);
  }

  /// Returns when the user closes the window.
  void run() {
    interactor_->Initialize();
    interactor_->CreateRepeatingTimer(kTimerMs);
    window_->Render();
    interactor_->Start();
  }

 private:
  using Handler = void (CaseWindow::*)();
  struct Connection {
    CaseWindow* window;
    Handler handler;
  };

  void connect(vtkObject* sender, unsigned long event, Handler handler) {
    connections_.push_back(std::make_unique<Connection>(Connection{this, handler}));
    vtkNew<vtkCallbackCommand> command;
    command->SetClientData(connections_.back().get());
    command->SetCallback([](vtkObject*, unsigned long, void* data, void*) {
      auto* connection = static_cast<Connection*>(data);
      (connection->window->*connection->handler)();
    });
    sender->AddObserver(event, command);
  }

  void add_slider() {
    if (data_.frames.size() < 2) return;
    slider_ = make_slider(data_, 1);
    slider_->SetValue(data_.frames[scene_.frame()].time_s);
    slider_widget_->SetInteractor(interactor_);
    slider_widget_->SetDefaultRenderer(scene_.layers().front());
    slider_widget_->SetCurrentRenderer(scene_.layers().front());
    slider_widget_->SetRepresentation(slider_);
    slider_widget_->SetAnimationModeToAnimate();
    slider_widget_->EnabledOn();
    connect(slider_widget_, vtkCommand::InteractionEvent, &CaseWindow::on_slider);
  }

  void on_draw() { scene_.update_overlays(); }

  void on_slider() {
    is_playing_ = false;
    show(frame_at(slider_->GetValue()), false);
  }

  void on_timer() {
    if (!is_playing_ || data_.frames.empty()) return;
    play_time_s_ += 1e-3 * kTimerMs;
    if (play_time_s_ > data_.frames.back().time_s) play_time_s_ = data_.frames.front().time_s;
    const std::size_t next = frame_at(play_time_s_);
    if (next != scene_.frame()) show(next, true);
  }

  void on_key() {
    const std::string key = interactor_->GetKeySym() ? interactor_->GetKeySym() : "";
    const std::size_t last = data_.frames.empty() ? 0 : data_.frames.size() - 1;
    const std::size_t now = scene_.frame();
    if (key == "q" || key == "Escape") return interactor_->TerminateApp();
    if (key == "space") {
      is_playing_ = !is_playing_;
      play_time_s_ = data_.frames.empty() ? 0.0 : data_.frames[now].time_s;
    }
    if (key == "Right") return show(std::min(now + 1, last), true);
    if (key == "Left") return show(now == 0 ? 0 : now - 1, true);
    if (key == "Home") return show(0, true);
    if (key == "End") return show(last, true);
    if (key == "s") scene_.toggle(ScenePart::scan);
    if (key == "l") scene_.toggle(ScenePart::lumen);
    if (key == "c") scene_.toggle(ScenePart::centerline);
    if (key == "p") scene_.toggle(ScenePart::pressure);
    if (key == "b") scene_.look_at_lesion(aspect_);
    if (key == "t") scene_.look_at_tree(aspect_);
    window_->Render();
  }

  /// The last written frame that is not later.
  [[nodiscard]] std::size_t frame_at(double time_s) const {
    std::size_t index = 0;
    while (index + 1 < data_.frames.size() && data_.frames[index + 1].time_s <= time_s + 1e-9)
      ++index;
    return index;
  }

  void show(std::size_t index, bool moves_slider) {
    if (data_.frames.empty()) return;
    scene_.show_frame(index);
    if (moves_slider && slider_) slider_->SetValue(data_.frames[index].time_s);
    window_->Render();
  }

  const CaseData& data_;
  vtkNew<vtkRenderWindow> window_;
  vtkNew<vtkRenderWindowInteractor> interactor_;
  CaseScene scene_;
  vtkSmartPointer<vtkSliderRepresentation2D> slider_;
  vtkNew<vtkSliderWidget> slider_widget_;
  std::vector<std::unique_ptr<Connection>> connections_;
  double aspect_;
  double play_time_s_ = 0.0;
  bool is_playing_ = false;
};

}  // namespace

void view_case(const fs::path& case_folder, const ViewOptions& options) {
  const CaseData data = detail::read_case(case_folder);
  if (!options.screenshot.empty()) return write_screenshot(data, options);
  const DisplayStatus status = display_status();
  if (!status.window)
    throw Error(ExitCode::unavailable,
                "cannot open a window (" + status.description +
                    "). Use --screenshot FILE.png, or open report/index.html");
  const formats::VtkMessages messages;
  CaseWindow(data, options).run();
}

DisplayStatus display_status() {
  DisplayStatus status;
  const std::string name = display_name();
  const detail::XServerStatus server = detail::probe_x_server(name);
  const auto xvfb = detail::find_xvfb();
  status.window = server.answers && server.has_gl;
  status.offscreen = status.window || xvfb.has_value();
  if (status.window)
    status.description = "display " + name + " with OpenGL";
  else if (server.answers)
    status.description = "display " + name + " answers but has no OpenGL (install libgl1-mesa-dri)";
  else if (name.empty())
    status.description = "no display: $DISPLAY is not set";
  else
    status.description = "no display: " + name + " does not answer";
  status.description +=
      xvfb ? "; pictures are rendered by Xvfb" : "; Xvfb is not installed (package xvfb)";
  return status;
}

}  // namespace angio::viewer
