#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

#include "core/atomic_file.hpp"
#include "core/child_process.hpp"
#include "core/sandbox.hpp"
#include "testing/temporary_folder.hpp"

#if !defined(__SANITIZE_ADDRESS__)  // whose children are not shut in: it has to be heard

namespace angio {
namespace {
namespace fs = std::filesystem;
using test::TemporaryFolder;

/// What `attempt` gives in a guarded child.
int in_child(const ChildLimits& limits, const std::function<int()>& attempt) {
  int given = -1;
  const ChildResult result = run_guarded(
      limits, [&](ChildOutput& output) { output.put(attempt()); },
      [&](ChildInput& input) { input.get(given); });
  EXPECT_EQ(result.end, ChildEnd::done);
  return given;
}

/// 0, or the errno of the call that failed.
int error_of(long result) { return result < 0 ? errno : 0; }

int open_error(const fs::path& path, int how = O_RDONLY) {
  return error_of(open(path.c_str(), how, 0600));
}

ChildLimits reading(const fs::path& path) {
  ChildLimits limits;
  limits.reach.read = {path};
  return limits;
}

class ReadingSandbox : public testing::Test {
 protected:
  void SetUp() override {
    write_text_atomically(folder_ / "input", "mine");
    write_text_atomically(folder_ / "other", "not mine");
  }
  TemporaryFolder folder_;
};

TEST_F(ReadingSandbox, ReadsItsInputAlone) {
  if (sandbox_support().landlock_version < 1) GTEST_SKIP() << "this kernel has no Landlock";
  const ChildLimits limits = reading(folder_ / "input");
  EXPECT_EQ(in_child(limits, [&] { return open_error(folder_ / "input"); }), 0);
  EXPECT_EQ(in_child(limits, [&] { return open_error(folder_ / "other"); }), EACCES);
  EXPECT_EQ(in_child(limits, [&] { return open_error("/etc/passwd"); }), EACCES);
  EXPECT_EQ(in_child(limits, [&] { return open_error("/proc/self/environ"); }), EACCES);
  EXPECT_EQ(in_child(limits, [&] { return open_error(folder_.path(), O_DIRECTORY); }), EACCES);
}

TEST_F(ReadingSandbox, ALinkOutOfItsFolderLeadsNowhere) {
  if (sandbox_support().landlock_version < 1) GTEST_SKIP() << "this kernel has no Landlock";
  fs::create_directory(folder_ / "inner");
  fs::create_symlink(folder_ / "other", folder_ / "inner" / "link");
  write_text_atomically(folder_ / "inner" / "input", "mine");
  const ChildLimits limits = reading(folder_ / "inner");
  EXPECT_EQ(in_child(limits, [&] { return open_error(folder_ / "inner" / "input"); }), 0);
  EXPECT_EQ(in_child(limits, [&] { return open_error(folder_ / "inner" / "link"); }), EACCES);
  fs::create_symlink(folder_ / "other",
                     folder_ / "given");  // a name that the user gave is followed
  EXPECT_EQ(in_child(reading(folder_ / "given"), [&] { return open_error(folder_ / "given"); }), 0);
}

TEST_F(ReadingSandbox, ChangesNothingOnTheDisk) {
  const ChildLimits limits = reading(folder_.path());
  const auto error = [&](const std::function<int()>& attempt) { return in_child(limits, attempt); };
  EXPECT_EQ(error([&] { return open_error(folder_ / "new", O_WRONLY | O_CREAT); }), EACCES);
  EXPECT_EQ(error([&] { return open_error(folder_ / "input", O_RDWR); }), EACCES);
  EXPECT_EQ(error([&] { return open_error(folder_ / "input", O_RDONLY | O_TRUNC); }), EACCES);
  EXPECT_EQ(error([&] { return error_of(mkdir((folder_ / "new").c_str(), 0700)); }), EACCES);
  EXPECT_EQ(error([&] { return error_of(unlink((folder_ / "input").c_str())); }), EACCES);
  EXPECT_EQ(error([&] { return error_of(chmod((folder_ / "input").c_str(), 0777)); }), EACCES);
  EXPECT_EQ(error([&] {
              return error_of(rename((folder_ / "input").c_str(), (folder_ / "new").c_str()));
            }),
            EACCES);
  EXPECT_EQ(read_text(folder_ / "input"), "mine");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 2);
}

TEST_F(ReadingSandbox, HasNoNetworkAndStartsNoPrograms) {
  if (!sandbox_support().system_calls) GTEST_SKIP() << "this kernel has no seccomp";
  for (const int family : {AF_INET, AF_INET6, AF_UNIX, AF_NETLINK})
    EXPECT_EQ(in_child({}, [&] { return error_of(socket(family, SOCK_STREAM, 0)); }), EPERM);
  EXPECT_EQ(in_child({},
                     [] {
                       char name[] = "/bin/true";
                       char* words[] = {name, nullptr};
                       return error_of(execv(name, words));
                     }),
            EPERM);
}

TEST_F(ReadingSandbox, HasNoPrivileges) {
  EXPECT_EQ(in_child({}, [] { return prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0); }), 1);
  EXPECT_EQ(in_child({}, [] { return prctl(PR_GET_DUMPABLE, 0, 0, 0, 0); }), 0);
  const auto capabilities = [] {
    __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
    std::array<__user_cap_data_struct, 2> data{};
    if (syscall(SYS_capget, &header, data.data()) != 0) return -1;
    return int(data[0].permitted | data[0].effective | data[0].inheritable | data[1].permitted);
  };
  EXPECT_EQ(in_child(reading(folder_ / "input"), capabilities), 0);
  EXPECT_EQ(in_child({}, [] { return prctl(PR_CAPBSET_READ, CAP_SYS_ADMIN, 0, 0, 0); }), 0);
}

TEST_F(ReadingSandbox, RootReadsWhatBelongsToOthers) {
  if (geteuid() != 0) GTEST_SKIP() << "only root may";
  ASSERT_EQ(chown((folder_ / "input").c_str(), 12345, 12345), 0);
  ASSERT_EQ(chmod((folder_ / "input").c_str(), 0600), 0);
  EXPECT_EQ(in_child(reading(folder_ / "input"), [&] { return open_error(folder_ / "input"); }), 0);
}

TEST_F(ReadingSandbox, HoldsNoOpenFileOfItsParent) {
  const int file = open((folder_ / "other").c_str(), O_RDONLY);
  ASSERT_GE(file, 0);
  EXPECT_EQ(in_child({}, [&] { return error_of(fcntl(file, F_GETFD)); }), EBADF);
  close(file);
}

TEST(WritingSandbox, WritesIntoItsFolderAlone) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "mine");
  ChildLimits limits;
  limits.reach.write = {folder / "mine"};
  limits.written_bytes = 1000;
  const auto write_into = [](const fs::path& path, std::size_t size) {
    std::ofstream file(path);
    file << std::string(size, 'x') << std::flush;
    return int(file.good());
  };
  EXPECT_EQ(in_child(limits, [&] { return write_into(folder / "mine" / "small", 1000); }), 1);
  EXPECT_EQ(fs::file_size(folder / "mine" / "small"), 1000U);
  EXPECT_EQ(in_child(limits, [&] { return write_into(folder / "mine" / "large", 1001); }), 0);
  if (sandbox_support().landlock_version < 1) GTEST_SKIP() << "this kernel has no Landlock";
  EXPECT_EQ(in_child(limits, [&] { return write_into(folder / "outside", 1); }), 0);
  EXPECT_FALSE(fs::exists(folder / "outside"));
}

TEST(SandboxSupport, IsSaidInWords) {
  EXPECT_NE(to_text({0, false}).find("no Landlock here"), std::string::npos);
  EXPECT_NE(to_text({0, false}).find("no seccomp here"), std::string::npos);
  EXPECT_EQ(to_text({6, true}).find(" here)"), std::string::npos);
}

}  // namespace
}  // namespace angio

#endif
