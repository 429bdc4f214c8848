#include "formats/vtk_messages.hpp"

#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <atomic>
#include <mutex>

namespace angio::formats {
namespace {

thread_local VtkMessages* newest = nullptr;
std::atomic<int> strays = 0;

/// VTK has one window for all threads: it is exchanged for ours while any of them has messages.
struct Exchange {
  std::mutex mutex;
  int count = 0;
  vtkSmartPointer<vtkOutputWindow> previous;
} exchange;

}  // namespace

class VtkMessages::Window : public vtkOutputWindow {
 public:
  static Window* New();
  vtkTypeMacro(Window, vtkOutputWindow);

  void DisplayText(const char*) override {}
  void DisplayErrorText(const char*) override {
    if (newest != nullptr)
      newest->has_error_ = true;
    else
      ++strays;
  }
  void DisplayWarningText(const char*) override {}
  void DisplayGenericWarningText(const char*) override {}
  void DisplayDebugText(const char*) override {}
};
vtkStandardNewMacro(VtkMessages::Window);

VtkMessages::VtkMessages() : strays_before_(strays), outer_(newest) {
  newest = this;
  const std::lock_guard lock(exchange.mutex);
  if (++exchange.count > 1) return;
  exchange.previous = vtkOutputWindow::GetInstance();
  vtkOutputWindow::SetInstance(vtkSmartPointer<Window>::New());
  // The logger prints every message to standard error a second time.
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
}

bool VtkMessages::has_error() const { return has_error_ || strays != strays_before_; }

VtkMessages::~VtkMessages() {
  newest = outer_;
  const std::lock_guard lock(exchange.mutex);
  if (--exchange.count > 0) return;
  vtkOutputWindow::SetInstance(exchange.previous);
  exchange.previous = nullptr;
}

}  // namespace angio::formats
