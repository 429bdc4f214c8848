#include "viewer/window/live_window.hpp"

#include <vtkContextActor.h>
#include <vtkContextScene.h>
#include <vtkDoubleArray.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkPointData.h>
#include <vtkPolyDataNormals.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "formats/case_file.hpp"
#include "formats/text.hpp"
#include "formats/vtk_arrays.hpp"
#include "viewer/detail/rendering.hpp"
#include "viewer/detail/scene.hpp"
#include "viewer/window/closing_signals.hpp"
#include "viewer/window/colors.hpp"
#include "viewer/window/recorder.hpp"

namespace angio::viewer::window {
namespace fs = std::filesystem;
namespace case_file = formats::case_file;
namespace {

constexpr int kTickMs = 30;
constexpr int kBottom = 96;  // of the controls [pixel]
constexpr double kPressureStepAtm = 0.5, kPlaceStepMm = 0.5;
constexpr const char* kHelp =
    "Up Down  pressure      Left Right  along the vessel      Page Up  to the peak\n"
    "Page Down  let down    space  hold here      b  look at the balloon      q  close";

struct Key {
  const char* symbol;
  std::function<void(LiveAim&, const LiveDrive&, const LiveState&)> change;
};

const std::vector<Key>& keys() {
  using Drive = LiveDrive;
  using State = LiveState;
  static const std::vector<Key> kKeys = {
      {"Up", [](LiveAim& a, const Drive&, const State&) { a.pressure_atm += kPressureStepAtm; }},
      {"Down", [](LiveAim& a, const Drive&, const State&) { a.pressure_atm -= kPressureStepAtm; }},
      {"Right", [](LiveAim& a, const Drive&, const State&) { a.place_mm += kPlaceStepMm; }},
      {"Left", [](LiveAim& a, const Drive&, const State&) { a.place_mm -= kPlaceStepMm; }},
      {"Prior",
       [](LiveAim& a, const Drive& d, const State&) { a.pressure_atm = d.most_pressure_atm; }},
      {"Next", [](LiveAim& a, const Drive&, const State&) { a.pressure_atm = 0.0; }},
      {"space",
       [](LiveAim& a, const Drive&, const State& s) {
         a = {s.pressure_atm, s.place_mm};
       }},
  };
  return kKeys;
}

constexpr std::array kOtherKeys{"b", "q", "Escape"};

vtkSmartPointer<vtkPolyData> with_normals(vtkPolyData* surface) {
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(surface);
  normals->SplittingOff();
  normals->ConsistencyOff();
  normals->Update();
  return normals->GetOutput();
}

vtkSmartPointer<vtkPolyData> line_of(const std::vector<Vec3>& points) {
  auto line = vtkSmartPointer<vtkPolyData>::New();
  std::vector<int> all(points.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = int(i);
  line->SetPoints(formats::to_vtk(points));
  line->SetLines(formats::to_vtk_cells(std::vector<std::vector<int>>{all}));
  return line;
}

FrameShapes shapes_of(const Moment& moment) {
  FrameShapes shapes;
  const auto wall = formats::to_vtk(moment.wall);
  vtkNew<vtkDoubleArray> pressure;
  pressure->SetName("contact_pressure");
  for (const double kpa : moment.contact_pressure_kpa) pressure->InsertNextValue(kpa);
  if (moment.contact_pressure_kpa.size() == moment.wall.vertices.size())
    wall->GetPointData()->AddArray(pressure);
  shapes.wall = with_normals(wall);
  shapes.balloon = with_normals(formats::to_vtk(moment.balloon));
  if (moment.guidewire.size() > 1) shapes.wire = line_of(moment.guidewire);
  return shapes;
}

/// The case where the solver starts: its only frame is the meshes.
detail::CaseData start_of(const fs::path& folder) {
  detail::CaseData data = detail::read_case(folder);
  data.frames = {{0,
                  0.0,
                  folder / case_file::kBalloon,
                  folder / case_file::kRegion,
                  folder / case_file::kGuidewire,
                  {}}};
  data.scan.reset();
  return data;
}

std::string number(double value, int decimals, const char* unit) {
  return formats::fixed_text(value, decimals) + unit;
}

}  // namespace

bool LiveWindow::knows_key(const std::string& symbol) {
  return std::find(kOtherKeys.begin(), kOtherKeys.end(), symbol) != kOtherKeys.end() ||
         std::any_of(keys().begin(), keys().end(),
                     [&](const Key& k) { return k.symbol == symbol; });
}

LiveWindow::LiveWindow(const fs::path& case_folder, const LiveDrive& drive,
                       const LiveOptions& options)
    : drive_(drive),
      options_(options),
      data_(start_of(case_folder)),
      line_(read_treated_line(case_folder, data_)),
      scene_(std::make_unique<SceneView>(data_, line_, nullptr)) {
  open_window();
  pressure_ = make_slider(interactor_, front_);
  place_ = make_slider(interactor_, front_);
  for (const PlainSlider& slider : {pressure_, place_})
    slider.widget->AddObserver(vtkCommand::InteractionEvent, this, &LiveWindow::on_slider);
  add_words();
  dial_->set_highest(drive.most_pressure_atm);
  interactor_->AddObserver(vtkCommand::KeyPressEvent, this, &LiveWindow::on_key);
  interactor_->AddObserver(vtkCommand::TimerEvent, this, &LiveWindow::tick);
  const Field pressure{Body::wall, "contact_pressure", false};
  scene_->keep_clear(kBottom);
  scene_->color_by(pressure, {0.0, 100.0 * drive.most_pressure_atm});
  solver_ = std::make_unique<LiveSolver>(drive_);
  shown_ = solver_->latest();
  set_aim({options.pressure_atm, 0.0});
  show(drive.first);
  lay_out();
  scene_->look_at_lesion(double(width_) / std::max(height_ - kBottom, 1));
  start_ = Clock::now();
  draw();
  picture_count_ = 0;
}

LiveWindow::~LiveWindow() { solver_.reset(); }

void LiveWindow::open_window() {
  window_->SetSize(options_.width, options_.height);
  window_->SetWindowName("angio: live");
  window_->SetMultiSamples(0);
  window_->SetNumberOfLayers(2);
  front_->SetLayer(1);
  front_->InteractiveOff();
  window_->AddRenderer(scene_->renderer());
  window_->AddRenderer(front_);
  interactor_->SetRenderWindow(window_);
  interactor_->SetDesiredUpdateRate(15.0);
  vtkNew<vtkInteractorStyleTrackballCamera> style;
  style->SetDefaultRenderer(scene_->renderer());
  interactor_->SetInteractorStyle(style);
}

void LiveWindow::add_words() {
  for (auto* words : {&pressure_words_, &place_words_, &help_}) {
    *words = detail::make_text("", 13, words == &help_ ? colors::kFaintInk : colors::kInk);
    front_->AddActor2D(*words);
  }
  help_->SetInput(kHelp);
  vtkNew<vtkContextActor> actor;
  actor->GetScene()->AddItem(dial_);
  actor->GetScene()->SetRenderer(front_);
  front_->AddActor(actor);
}

void LiveWindow::lay_out() {
  const int* size = window_->GetSize();
  if (size[0] == width_ && size[1] == height_) return;
  width_ = std::max(size[0], 1);
  height_ = std::max(size[1], 1);
  constexpr int kMargin = 16, kWords = 190, kRow = 24, kDial = 96;
  const int left = kMargin + kWords, length = std::max(width_ - left - kDial - 3 * kMargin, 60);
  place(pressure_, {left, 60, length, kRow}, front_);
  place(place_, {left, 34, length, kRow}, front_);
  pressure_words_->SetPosition(kMargin, 64);
  place_words_->SetPosition(kMargin, 38);
  help_->SetPosition(kMargin, 4);
  dial_->place(width_ - kMargin - kDial / 2, kBottom / 2, 0.45 * kDial);
}

void LiveWindow::on_key() {
  const char* name = interactor_->GetKeySym();
  const std::string symbol = name != nullptr ? name : "";
  if (symbol == "q" || symbol == "Escape") return close();
  if (symbol == "b") {
    scene_->look_at_lesion(double(width_) / std::max(height_ - kBottom, 1));
    return draw();
  }
  for (const Key& key : keys()) {
    if (key.symbol != symbol) continue;
    LiveAim aim = aim_;
    key.change(aim, drive_, *shown_);
    set_aim(aim);
  }
}

void LiveWindow::on_slider(vtkObject* widget, unsigned long, void*) {
  LiveAim aim = aim_;
  if (widget == pressure_.widget)
    aim.pressure_atm = pressure_.look->GetValue() * drive_.most_pressure_atm;
  else
    aim.place_mm = drive_.least_place_mm +
                   place_.look->GetValue() * (drive_.most_place_mm - drive_.least_place_mm);
  set_aim(aim);
}

void LiveWindow::set_aim(LiveAim aim) {
  aim.pressure_atm = std::clamp(aim.pressure_atm, 0.0, drive_.most_pressure_atm);
  aim.place_mm = std::clamp(aim.place_mm, drive_.least_place_mm, drive_.most_place_mm);
  aim_ = aim;
  solver_->set_aim(aim);
  pressure_.look->SetValue(aim.pressure_atm / drive_.most_pressure_atm);
  const double way = drive_.most_place_mm - drive_.least_place_mm;
  place_.look->SetValue(way > 0.0 ? (aim.place_mm - drive_.least_place_mm) / way : 0.5);
}

void LiveWindow::show(const LiveState& state) {
  scene_->show_frame(shapes_of(state.shape));
  std::string words = number(state.time_s, 2, " s   balloon ") +
                      number(state.diameter_mm, 2, " mm, ") + number(state.volume_mm3, 1, " mm³");
  if (state.is_stuck) words += "\nthe balloon touches the wall: let it down before you move it";
  if (drive_.rated_burst_atm > 0.0 && state.pressure_atm > drive_.rated_burst_atm)
    words += "\nabove the rated burst pressure, " + number(drive_.rated_burst_atm, 1, " atm");
  scene_->set_words(words);
  dial_->show(state.pressure_atm, "");
}

void LiveWindow::draw() {
  lay_out();
  pressure_words_->SetInput(("pressure wanted " + number(aim_.pressure_atm, 1, " atm")).c_str());
  place_words_->SetInput(("place wanted " + number(aim_.place_mm, 1, " mm")).c_str());
  scene_->update_overlays();
  window_->Render();
  ++picture_count_;
}

void LiveWindow::tick() {
  if (is_closing_) return;
  const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
  if (ClosingSignals::has_come() || (options_.seconds > 0.0 && elapsed >= options_.seconds))
    return close();
  const auto latest = solver_->latest();
  if (latest == shown_) return;
  shown_ = latest;
  show(*shown_);
  draw();
}

void LiveWindow::press(const std::string& symbol) {
  interactor_->SetKeySym(symbol.c_str());
  interactor_->InvokeEvent(vtkCommand::KeyPressEvent);
}

void LiveWindow::close() {
  is_closing_ = true;
  interactor_->TerminateApp();
}

detail::Picture LiveWindow::picture() {
  draw();
  return detail::read_pixels(window_);
}

LiveRates LiveWindow::rates() const {
  LiveRates rates;
  rates.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  rates.frame_count = solver_->frame_count();
  rates.picture_count = picture_count_;
  rates.busy_s = solver_->busy_s();
  rates.last = *solver_->latest();
  return rates;
}

LiveRates LiveWindow::run() {
  interactor_->Initialize();
  interactor_->CreateRepeatingTimer(kTickMs);
  draw();
  const bool is_for_picture = !options_.screenshot.empty() && options_.seconds <= 0.0;
  if (!ClosingSignals::has_come() && !is_closing_ && !is_for_picture) interactor_->Start();
  const LiveRates result = rates();
  solver_->check();
  if (!options_.screenshot.empty()) save_picture(window_, options_.screenshot);
  return result;
}

}  // namespace angio::viewer::window
