#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <string>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "testing/temporary_folder.hpp"

namespace angio {
namespace {
namespace fs = std::filesystem;

class AtomicFile : public testing::Test {
 protected:
  [[nodiscard]] std::ptrdiff_t file_count() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }

  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

/// The exit code of the Error that `action` throws; done if it throws none.
template <class Action>
ExitCode exit_code_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.exit_code();
  }
  return ExitCode::done;
}

/// While it lives, no file of this process grows beyond `bytes`: a disk that is full.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST_F(AtomicFile, ReadsBackWhatWasWrittenByteForByte) {
  const std::string text("line\n\0\r\n\xff end", 13);
  write_text_atomically(folder_ / "a.bin", text);
  EXPECT_EQ(read_text(folder_ / "a.bin"), text);
  EXPECT_EQ(file_count(), 1);
}

TEST_F(AtomicFile, WritesAnEmptyFile) {
  write_text_atomically(folder_ / "empty.txt", "");
  EXPECT_EQ(read_text(folder_ / "empty.txt"), "");
}

TEST_F(AtomicFile, MakesTheFoldersThatAreMissing) {
  write_text_atomically(folder_ / "b" / "c" / "d.txt", "x");
  EXPECT_EQ(read_text(folder_ / "b" / "c" / "d.txt"), "x");
}

TEST_F(AtomicFile, TakesARelativeNameWithoutAFolder) {
  const fs::path before = fs::current_path();
  fs::current_path(folder_);
  write_text_atomically("plain.txt", "x");
  fs::current_path(before);
  EXPECT_EQ(read_text(folder_ / "plain.txt"), "x");
}

TEST_F(AtomicFile, TemporaryLiesInTheSameFolderHiddenAndKeepsTheExtension) {
  write_atomically(folder_ / "lumen.vtp", [&](const fs::path& temporary) {
    EXPECT_EQ(temporary.parent_path(), folder_);
    EXPECT_EQ(temporary.extension(), ".vtp");
    EXPECT_EQ(temporary.filename().string().front(), '.');
    std::ofstream(temporary) << "x";
    EXPECT_FALSE(fs::exists(folder_ / "lumen.vtp"));
  });
  EXPECT_EQ(file_count(), 1);
}

TEST_F(AtomicFile, KeepsTheOldFileAndLeavesNothingElseWhenWritingFails) {
  write_text_atomically(folder_ / "a.txt", "old");
  EXPECT_THROW(write_atomically(folder_ / "a.txt",
                                [](const fs::path& temporary) {
                                  std::ofstream(temporary) << "half";
                                  throw InputError("no");
                                }),
               InputError);
  EXPECT_EQ(read_text(folder_ / "a.txt"), "old");
  EXPECT_EQ(file_count(), 1);
}

TEST_F(AtomicFile, ReportsAFullDiskAsIoErrorAndLeavesNothing) {
  const std::string megabyte(1 << 20, 'x');
  const FileSizeLimit full(4096);
  EXPECT_EQ(exit_code_of([&] { write_text_atomically(folder_ / "big.txt", megabyte); }),
            ExitCode::io);
  EXPECT_EQ(file_count(), 0);
}

TEST_F(AtomicFile, ReportsAWriterThatWroteNothing) {
  EXPECT_EQ(exit_code_of([&] { write_atomically(folder_ / "a.txt", [](const fs::path&) {}); }),
            ExitCode::io);
  EXPECT_EQ(file_count(), 0);
}

TEST_F(AtomicFile, CannotCreateBelowAFile) {
  write_text_atomically(folder_ / "file", "x");
  EXPECT_EQ(exit_code_of([&] { write_text_atomically(folder_ / "file" / "a.txt", "x"); }),
            ExitCode::cannot_create);
  EXPECT_EQ(exit_code_of([&] { make_folder(folder_ / "file"); }), ExitCode::cannot_create);
}

TEST_F(AtomicFile, CannotCreateWhereAFolderIsInTheWay) {
  make_folder(folder_ / "a.txt" / "inside");
  EXPECT_EQ(exit_code_of([&] { write_text_atomically(folder_ / "a.txt", "x"); }),
            ExitCode::cannot_create);
  EXPECT_EQ(file_count(), 1);
}

TEST_F(AtomicFile, CannotCreateInAFolderThatForbidsIt) {
  if (geteuid() == 0) GTEST_SKIP() << "permissions do not bind root";
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_EQ(exit_code_of([&] { write_text_atomically(folder_ / "a.txt", "x"); }),
            ExitCode::cannot_create);
  fs::permissions(folder_, fs::perms::owner_all);
}

TEST_F(AtomicFile, CannotCreateInTheKernelsFileSystem) {
  if (!fs::exists("/proc/self/status")) GTEST_SKIP() << "no /proc";
  EXPECT_EQ(exit_code_of([&] { write_text_atomically("/proc/angio.txt", "x"); }),
            ExitCode::cannot_create);
  EXPECT_EQ(exit_code_of([&] { make_folder("/proc/angio/case"); }), ExitCode::cannot_create);
}

TEST_F(AtomicFile, ReadingWhatIsMissingIsNoInput) {
  EXPECT_EQ(exit_code_of([&] { read_text(folder_ / "missing.txt"); }), ExitCode::no_input);
}

TEST_F(AtomicFile, ReadingAFolderIsAnIoError) {
  EXPECT_EQ(exit_code_of([&] { read_text(folder_); }), ExitCode::io);
}

}  // namespace
}  // namespace angio
