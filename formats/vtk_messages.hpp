#pragma once

namespace angio::formats {

/// While it lives, VTK's messages are kept here instead of being printed, so that a failure can be
/// told in one line of our own. Several threads may each have one; an error is told to the newest
/// of the thread that it happens in, to all where that thread has none.
class VtkMessages {
 public:
  VtkMessages();
  ~VtkMessages();
  VtkMessages(const VtkMessages&) = delete;
  VtkMessages& operator=(const VtkMessages&) = delete;

  [[nodiscard]] bool has_error() const;

 private:
  class Window;
  bool has_error_ = false;
  int strays_before_;   ///< errors of threads without messages
  VtkMessages* outer_;  ///< of the same thread; null: none
};

}  // namespace angio::formats
