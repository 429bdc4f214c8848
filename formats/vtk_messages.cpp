#include "formats/vtk_messages.hpp"

#include <vtkLogger.h>
#include <vtkObjectFactory.h>

namespace angio::formats {

class VtkMessages::Window : public vtkOutputWindow {
 public:
  static Window* New();
  vtkTypeMacro(Window, vtkOutputWindow);

  void DisplayText(const char*) override {}
  void DisplayErrorText(const char*) override { has_error = true; }
  void DisplayWarningText(const char*) override {}
  void DisplayGenericWarningText(const char*) override {}
  void DisplayDebugText(const char*) override {}

  bool has_error = false;
};
vtkStandardNewMacro(VtkMessages::Window);

VtkMessages::VtkMessages()
    : window_(vtkSmartPointer<Window>::New()), previous_(vtkOutputWindow::GetInstance()) {
  vtkOutputWindow::SetInstance(window_);
  // The logger prints every message to standard error a second time.
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
}

VtkMessages::~VtkMessages() { vtkOutputWindow::SetInstance(previous_); }

bool VtkMessages::has_error() const { return window_->has_error; }

}  // namespace angio::formats
