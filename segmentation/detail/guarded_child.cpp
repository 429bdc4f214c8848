#include "segmentation/detail/guarded_child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <new>

#include "core/error.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr std::size_t kMessageSize = 1024;
constexpr std::size_t kGatherBytes = std::size_t(1) << 16;
constexpr std::uint64_t kMaxCountedBytes = std::uint64_t(1) << 28;  ///< pixels come uncounted
// Not 1 and 2, with which libraries end a program.
constexpr int kRefusedStatus = 101;
constexpr int kMemoryStatus = 102;
constexpr int kOtherStatus = 103;

/// The child has sent all that it will.
struct EndOfChild {
  bool timed_out = false;
};

/// A page that the child leaves its last words in.
class SharedPage {
 public:
  SharedPage()
      : memory_(mmap(nullptr, kMessageSize, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1,
                     0)) {
    if (memory_ == MAP_FAILED) throw IoError("not enough memory to read a file. Close programs");
  }
  ~SharedPage() { munmap(memory_, kMessageSize); }
  SharedPage(const SharedPage&) = delete;
  SharedPage& operator=(const SharedPage&) = delete;
  [[nodiscard]] char* text() const { return static_cast<char*>(memory_); }

 private:
  void* memory_;
};

/// Ends and buries the child, whatever happens on the way.
class Child {
 public:
  explicit Child(pid_t id) : id_(id) {}
  ~Child() {
    if (id_ <= 0) return;
    kill(id_, SIGKILL);
    wait();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  int wait() {
    int status = 0;
    while (waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    id_ = 0;
    return status;
  }

 private:
  pid_t id_;
};

class PipeEnd {
 public:
  explicit PipeEnd(int file) : file_(file) {}
  ~PipeEnd() { close(); }
  PipeEnd(const PipeEnd&) = delete;
  PipeEnd& operator=(const PipeEnd&) = delete;
  void close() {
    if (file_ >= 0) ::close(file_);
    file_ = -1;
  }
  [[nodiscard]] int file() const { return file_; }

 private:
  int file_;
};

/// The address space in use, which a child inherits.
std::size_t address_space_bytes() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * std::size_t(sysconf(_SC_PAGESIZE));
}

/// Libraries print what they find wrong, and with it what a header says of the patient.
void silence() {
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere < 0) return;
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
}

void apply(const ChildLimits& limits) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // it must not outlive the program
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  const auto cpu = rlim_t(limits.cpu_seconds);
  const rlimit time{cpu, cpu + 1};
  setrlimit(RLIMIT_CPU, &time);
  const rlimit no_core{0, 0};  // a core file would hold the patient's data
  setrlimit(RLIMIT_CORE, &no_core);
#if !defined(__SANITIZE_ADDRESS__)  // its shadow memory takes terabytes, and it has to be heard
  silence();
  const std::size_t held = address_space_bytes();
  const rlimit space{held + limits.memory_bytes, held + limits.memory_bytes};
  if (held > 0) setrlimit(RLIMIT_AS, &space);
#endif
}

[[noreturn]] void run_child(const ChildLimits& limits, int file, char* message,
                            const std::function<void(ChildOutput&)>& work) {
  int status = 0;
  try {
    apply(limits);
    ChildOutput output(file);
    work(output);
    output.flush();
  } catch (const std::bad_alloc&) {
    status = kMemoryStatus;
  } catch (const Error& error) {
    std::strncpy(message, error.what(), kMessageSize - 1);
    status = kRefusedStatus;
  } catch (...) {
    status = kOtherStatus;
  }
  _exit(status);  // no destructors: what they would end belongs to the parent
}

ChildResult judge(int status, const char* message) {
  if (WIFEXITED(status)) {
    switch (WEXITSTATUS(status)) {
      case 0:
        return {};
      case kRefusedStatus:
        return {ChildEnd::refused, message};
      case kMemoryStatus:
        return {ChildEnd::out_of_memory, {}};
      default:
        return {ChildEnd::broke_down, {}};
    }
  }
  const bool out_of_time = WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU;
  return {out_of_time ? ChildEnd::timed_out : ChildEnd::broke_down, {}};
}

}  // namespace

void ChildOutput::write(const void* bytes, std::size_t size) {
  const auto* begin = static_cast<const char*>(bytes);
  if (gathered_.size() + size >= kGatherBytes) flush();
  if (size >= kGatherBytes)
    send(begin, size);
  else
    gathered_.insert(gathered_.end(), begin, begin + size);
}

void ChildOutput::put(const std::string& text) {
  put(std::uint64_t(text.size()));
  write(text.data(), text.size());
}

void ChildOutput::flush() {
  send(gathered_.data(), gathered_.size());
  gathered_.clear();
}

void ChildOutput::send(const char* bytes, std::size_t size) const {
  while (size > 0) {
    const ssize_t count = ::write(file_, bytes, size);
    if (count < 0 && errno != EINTR) _exit(kOtherStatus);  // nobody listens any more
    if (count <= 0) continue;
    bytes += count;
    size -= std::size_t(count);
  }
}

void ChildInput::read(void* bytes, std::size_t size) {
  auto* begin = static_cast<char*>(bytes);
  while (size > 0) {
    pollfd ready{file_, POLLIN, 0};
    const int count = poll(&ready, 1, silent_seconds_ * 1000);
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) throw EndOfChild{true};
    const ssize_t got = ::read(file_, begin, size);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw EndOfChild{false};
    begin += got;
    size -= std::size_t(got);
  }
}

std::size_t ChildInput::count_of(std::size_t item_size) {
  std::uint64_t count = 0;
  get(count);
  // A child that a hostile file has taken over must not make the parent take any memory.
  if (count > kMaxCountedBytes / item_size) throw EndOfChild{false};
  return std::size_t(count);
}

void ChildInput::get(std::string& text) {
  text.resize(count_of(1));
  read(text.data(), text.size());
}

ChildResult run_guarded(const ChildLimits& limits, const std::function<void(ChildOutput&)>& work,
                        const std::function<void(ChildInput&)>& receive) {
  const SharedPage page;
  int files[2];
  if (pipe2(files, O_CLOEXEC) != 0)
    throw IoError("cannot start a reader (" + std::string(std::strerror(errno)) + ")");
  PipeEnd from(files[0]);
  PipeEnd into(files[1]);
  const pid_t id = fork();
  if (id < 0) throw IoError("cannot start a reader (" + std::string(std::strerror(errno)) + ")");
  if (id == 0) {
    from.close();
    run_child(limits, into.file(), page.text(), work);
  }
  Child child(id);
  into.close();
  bool ended_early = false;
  try {
    ChildInput input(from.file(), limits.silent_seconds);
    receive(input);
  } catch (const EndOfChild& end) {
    if (end.timed_out) return {ChildEnd::timed_out, {}};
    ended_early = true;
  }
  from.close();
  ChildResult result = judge(child.wait(), page.text());
  if (ended_early && result.end == ChildEnd::done) return {ChildEnd::broke_down, {}};
  return result;
}

}  // namespace angio::segmentation::detail
