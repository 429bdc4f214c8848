#pragma once

#include <filesystem>
#include <string>
#include <vector>

/// What a process may reach: it shuts itself in before it touches data that nobody has checked.
namespace angio {

/// Files, and folders with all that is in them; links in their names are followed once.
struct ReachableFiles {
  std::vector<std::filesystem::path> read;
  std::vector<std::filesystem::path> write;  ///< folders; may be read, too
};

/// What this kernel can hold back.
struct SandboxSupport {
  int landlock_version = 0;  ///< of its interface; 0: files cannot be held back one by one
  bool system_calls = false;
};
SandboxSupport sandbox_support();
/// The same as a sentence for people.
std::string to_text(const SandboxSupport& support);

/// Takes from this process, and from all that it starts, for good:
///
/// - files: all but `reach` (Landlock). Without Landlock it may still read what its user may, but
///   creates, opens for writing, renames and removes nothing, unless reach.write names a folder;
/// - network, other programs, other processes, mounts, the kernel's own interfaces (seccomp: such
///   calls fail with EPERM);
/// - signals to processes outside (Landlock 6);
/// - new privileges, and capabilities: all but the one to read what only root's power makes
///   readable (or writable), where `reach` holds such files;
/// - open files but standard input, output and error and `kept`;
/// - core files, also those that are handed to a program.
///
/// What the kernel cannot do is left out: see sandbox_support(). To be called with one thread.
void enter_sandbox(const ReachableFiles& reach, int kept);

}  // namespace angio
