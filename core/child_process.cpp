#include "core/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <mutex>
#include <new>
#include <thread>
#include <utility>

#include "core/error.hpp"
#include "core/system_call.hpp"

namespace angio {
namespace {

constexpr std::size_t kMessageSize = 1024;
// Not 1 and 2, with which libraries end a program.
constexpr int kRefusedStatus = 101;
constexpr int kMemoryStatus = 102;
constexpr int kOtherStatus = 103;

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

int wait_for(pid_t id) {
  int status = 0;
  repeat([&] { return waitpid(id, &status, 0); });
  return status;
}

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
    const int status = wait_for(id_);
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
  int release() { return std::exchange(file_, -1); }
  [[nodiscard]] int file() const { return file_; }

 private:
  int file_;
};

struct Pipe {
  PipeEnd from;
  PipeEnd into;
};

[[noreturn]] void fail_to_start(const std::string& what, int error) {
  throw IoError("cannot start " + what + " (" + std::strerror(error) + ")");
}

Pipe make_pipe(const std::string& what) {
  std::array<int, 2> files{};
  if (pipe2(files.data(), O_CLOEXEC) != 0) fail_to_start(what, errno);
  constexpr int kPipeBytes = 1 << 20;  // fewer turns with pixels; what is not granted stays small
  fcntl(files[1], F_SETPIPE_SZ, kPipeBytes);
  return {PipeEnd(files[0]), PipeEnd(files[1])};
}

/// Held from the making of a pipe until the parent has closed the child's end: a child that another
/// thread forks meanwhile would hold this end open, and the pipe would not tell that the child
/// died.
std::mutex& start_mutex() {
  static std::mutex mutex;
  return mutex;
}

/// In the child: it gets `signal` when its parent dies, and ends if the parent has died already.
void die_with(pid_t parent, int signal) {
  prctl(PR_SET_PDEATHSIG, signal);
  if (getppid() != parent) _exit(kOtherStatus);
}

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

void apply(const ChildLimits& limits, [[maybe_unused]] int file) {
  for (const int crash : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE}) signal(crash, SIG_DFL);
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
  if (limits.confinement == Confinement::none) return;
  const rlimit written{limits.written_bytes, limits.written_bytes};
  setrlimit(RLIMIT_FSIZE, &written);
  signal(SIGXFSZ, SIG_IGN);  // such a write fails instead
  enter_sandbox(limits.reach, file);
#endif
}

[[noreturn]] void run_child(const ChildLimits& limits, int file, char* message,
                            const std::function<void(ChildOutput&)>& work) {
  int status = 0;
  try {
    apply(limits, file);
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

/// How a child ended, by what waitpid told.
ChildResult judge(int status) {
  ChildResult result;
  if (WIFEXITED(status)) result.exit_status = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  if (result.signal == SIGXCPU)
    result.end = ChildEnd::timed_out;
  else if (result.signal != 0 || result.exit_status != 0)
    result.end = ChildEnd::broke_down;
  return result;
}

/// The same for a child of run_child's.
ChildResult judge(int status, const char* message) {
  ChildResult result = judge(status);
  if (result.exit_status == kMemoryStatus) result.end = ChildEnd::out_of_memory;
  if (result.exit_status == kRefusedStatus) {
    result.end = ChildEnd::refused;
    result.message = message;
  }
  return result;
}

/// What the child needs of the program's call; no memory may be taken in it after the fork.
struct ProgramImage {
  std::vector<std::string> words;
  std::vector<char*> argv;
  std::string log;

  explicit ProgramImage(const ProgramCall& call)
      : log(call.log.empty() ? "/dev/null" : call.log.string()) {
    words.push_back(call.file.string());
    words.insert(words.end(), call.arguments.begin(), call.arguments.end());
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
  }
};

/// Becomes the program; never returns. Only async-signal-safe calls: other threads may live.
/// @param line    becomes kLineFile
/// @param failed  gets errno if the program cannot be started; starting it closes this file
[[noreturn]] void become(const ProgramImage& image, Session session, int line, int failed) {
  const int nowhere = open("/dev/null", O_RDONLY | O_CLOEXEC);
  const int log = open(image.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  // Neither may be overwritten below.
  const int line_copy = fcntl(line, F_DUPFD_CLOEXEC, ChildProgram::kLineFile + 1);
  const int failed_copy = fcntl(failed, F_DUPFD_CLOEXEC, ChildProgram::kLineFile + 1);
  if (session == Session::its_own) setsid();
  if (nowhere >= 0 && log >= 0 && line_copy >= 0) {
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    dup2(nowhere, STDIN_FILENO);
    dup2(line_copy, ChildProgram::kLineFile);
    execv(image.argv[0], image.argv.data());
  }
  const int error = errno;
  _exit(write(failed_copy, &error, sizeof error) < 0 ? kOtherStatus : kRefusedStatus);
}

}  // namespace

#if defined(ANGIO_FUZZ)
// A fuzzer sees what is done in its own process alone: there the work writes into a file, which is
// then read.
ChildResult run_guarded(const ChildLimits& limits, const std::function<void(ChildOutput&)>& work,
                        const std::function<void(ChildInput&)>& receive) {
  const PipeEnd file(memfd_create("child", MFD_CLOEXEC));
  try {
    ChildOutput output(file.file());
    work(output);
    output.flush();
  } catch (const std::bad_alloc&) {
    return {ChildEnd::out_of_memory, {}};
  } catch (const Error& error) {
    return {ChildEnd::refused, error.what()};
  }
  lseek(file.file(), 0, SEEK_SET);
  try {
    ChildInput input(file.file(), limits.silent_seconds, limits.handed_bytes);
    receive(input);
  } catch (const EndOfChild&) {
    return {ChildEnd::broke_down, {}};
  }
  return {};
}
#else
ChildResult run_guarded(const ChildLimits& limits, const std::function<void(ChildOutput&)>& work,
                        const std::function<void(ChildInput&)>& receive) {
  const SharedPage page;
  std::unique_lock<std::mutex> lock(start_mutex());
  Pipe pipe = make_pipe("a child process");
  const pid_t parent = getpid();
  const pid_t id = fork();
  if (id < 0) fail_to_start("a child process", errno);
  if (id == 0) {
    die_with(parent, SIGKILL);
    lock.unlock();  // the child may start children of its own
    pipe.from.close();
    run_child(limits, pipe.into.file(), page.text(), work);
  }
  Child child(id);
  pipe.into.close();
  lock.unlock();
  bool ended_early = false;
  try {
    ChildInput input(pipe.from.file(), limits.silent_seconds, limits.handed_bytes);
    receive(input);
  } catch (const EndOfChild& end) {
    if (end.timed_out) return {ChildEnd::timed_out, {}};
    ended_early = true;
  }
  pipe.from.close();
  ChildResult result = judge(child.wait(), page.text());
  if (ended_early && result.end == ChildEnd::done) result.end = ChildEnd::broke_down;
  return result;
}

#endif

ChildProgram::ChildProgram(const ProgramCall& call) {
  const ProgramImage image(call);
  const std::string name = call.file.filename().string();
  std::unique_lock<std::mutex> lock(start_mutex());
  Pipe line = make_pipe(name);
  Pipe failed = make_pipe(name);
  const pid_t parent = getpid();
  id_ = fork();
  if (id_ < 0) fail_to_start(name, errno);
  if (id_ == 0) {
    die_with(parent, SIGTERM);
    become(image, call.session, line.into.file(), failed.into.file());
  }
  line.into.close();
  failed.into.close();
  lock.unlock();
  int error = 0;
  ssize_t count = 0;
  do count = read(failed.from.file(), &error, sizeof error);
  while (count < 0 && errno == EINTR);
  if (count == ssize_t(sizeof error)) {
    wait();
    fail_to_start(name, error);
  }
  line_file_ = line.from.release();
}

ChildProgram::ChildProgram(ChildProgram&& other) noexcept
    : id_(std::exchange(other.id_, -1)),
      line_file_(std::exchange(other.line_file_, -1)),
      result_(std::move(other.result_)) {}

ChildProgram::~ChildProgram() {
  end();
  if (line_file_ >= 0) close(line_file_);
}

std::string ChildProgram::read_line(int timeout_ms) const {
  std::string line;
  while (is_ready(line_file_, timeout_ms)) {
    char letter = 0;
    if (repeat([&] { return read(line_file_, &letter, 1); }) <= 0) return {};
    if (letter == '\n') return line;
    line += letter;
  }
  return {};
}

std::optional<ChildResult> ChildProgram::result() {
  if (id_ <= 0) return result_;
  int status = 0;
  if (waitpid(id_, &status, WNOHANG) != id_) return std::nullopt;
  id_ = -1;
  return result_ = judge(status);
}

void ChildProgram::ask_to_end() const {
  if (id_ > 0) kill(id_, SIGTERM);
}

ChildResult ChildProgram::end(int patience_ms) {
  using Clock = std::chrono::steady_clock;
  ask_to_end();
  const auto last = Clock::now() + std::chrono::milliseconds(patience_ms);
  while (!result() && Clock::now() < last)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  if (id_ > 0) kill(id_, SIGKILL);
  return wait();
}

ChildResult ChildProgram::wait() {
  if (id_ > 0) result_ = judge(wait_for(id_));
  id_ = -1;
  return result_;
}

}  // namespace angio
