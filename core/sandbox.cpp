#include "core/sandbox.hpp"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/capability.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>

namespace angio {
namespace {

// ---- files: Landlock ---------------------------------------------------------------------------

// Rights that Debian 12's headers lack, of versions 2 to 6 (landlock(7)).
constexpr std::uint64_t kRefer = 1ULL << 13;
constexpr std::uint64_t kTruncate = 1ULL << 14;
constexpr std::uint64_t kDeviceCommands = 1ULL << 15;
constexpr std::uint64_t kAbstractSockets = 1ULL << 0;
constexpr std::uint64_t kSignals = 1ULL << 1;

/// The kernel's landlock_ruleset_attr of version 6; an older one takes the first member alone.
struct Ruleset {
  std::uint64_t files = 0;
  std::uint64_t network = 0;
  std::uint64_t scoped = 0;
};

constexpr std::uint64_t kReadFile = LANDLOCK_ACCESS_FS_READ_FILE;
constexpr std::uint64_t kRead = kReadFile | LANDLOCK_ACCESS_FS_READ_DIR;

/// All that a version of Landlock can hold back.
Ruleset ruleset_of(int version) {
  Ruleset rules;
  rules.files = (1ULL << 13) - 1;
  if (version >= 2) rules.files |= kRefer;
  if (version >= 3) rules.files |= kTruncate;
  if (version >= 5) rules.files |= kDeviceCommands;
  if (version >= 4) rules.network = 3;  // TCP: bind, connect
  if (version >= 6) rules.scoped = kAbstractSockets | kSignals;
  return rules;
}

std::size_t size_of_rules(int version) {
  if (version >= 6) return sizeof(Ruleset);
  return version >= 4 ? offsetof(Ruleset, scoped) : offsetof(Ruleset, network);
}

int landlock_version() {
  return int(std::max(
      0L, syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION)));
}

/// What is not there needs no rule.
void allow(int rules, const std::filesystem::path& path, std::uint64_t rights) {
  const int file = open(path.c_str(), O_PATH | O_CLOEXEC);
  struct stat status {};
  if (file < 0) return;
  if (fstat(file, &status) == 0) {
    constexpr std::uint64_t kOfFiles = kReadFile | LANDLOCK_ACCESS_FS_WRITE_FILE | kTruncate;
    landlock_path_beneath_attr rule{};
    rule.allowed_access = S_ISDIR(status.st_mode) ? rights : rights & kOfFiles;
    rule.parent_fd = file;
    syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
  }
  close(file);
}

void hold_back_files(const ReachableFiles& reach) {
  const int version = landlock_version();
  if (version < 1) return;
  const Ruleset all = ruleset_of(version);
  const int rules = int(syscall(SYS_landlock_create_ruleset, &all, size_of_rules(version), 0));
  if (rules < 0) return;
  for (const auto& path : reach.read) allow(rules, path, kRead);
  const std::uint64_t change = kRead | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_MAKE_REG |
                               LANDLOCK_ACCESS_FS_REMOVE_FILE | (all.files & kTruncate);
  for (const auto& path : reach.write) allow(rules, path, change);
  syscall(SYS_landlock_restrict_self, rules, 0);
  close(rules);
}

// ---- system calls: seccomp ---------------------------------------------------------------------

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t kArchitecture = 0;  // no filter
#endif

constexpr std::array kRefusedCalls = {
    // the network, also that of this machine alone
    SYS_socket,
    SYS_socketpair,
    SYS_connect,
    SYS_bind,
    SYS_listen,
    SYS_accept,
    SYS_accept4,
    SYS_sendto,
    SYS_sendmsg,
    SYS_sendmmsg,
    SYS_recvfrom,
    SYS_recvmsg,
    SYS_recvmmsg,
    // other programs and processes
    SYS_execve,
    SYS_execveat,
    SYS_ptrace,
    SYS_process_vm_readv,
    SYS_process_vm_writev,
    SYS_pidfd_open,
    SYS_pidfd_getfd,
    SYS_pidfd_send_signal,
    SYS_process_madvise,
    SYS_kcmp,
    // files by other ways than their names, other roots, other people's rights
    SYS_open_by_handle_at,
    SYS_name_to_handle_at,
    SYS_io_uring_setup,
    SYS_io_uring_enter,
    SYS_io_uring_register,
    SYS_chroot,
    SYS_pivot_root,
    SYS_mount,
    SYS_umount2,
    SYS_open_tree,
    SYS_move_mount,
    SYS_fsopen,
    SYS_fsmount,
    SYS_fspick,
    SYS_fsconfig,
    SYS_setns,
    SYS_unshare,
    SYS_quotactl,
    SYS_swapon,
    SYS_swapoff,
    SYS_fanotify_init,
    SYS_mknodat,
    // the kernel
    SYS_bpf,
    SYS_perf_event_open,
    SYS_userfaultfd,
    SYS_keyctl,
    SYS_add_key,
    SYS_request_key,
    SYS_init_module,
    SYS_finit_module,
    SYS_delete_module,
    SYS_kexec_load,
    SYS_reboot,
    SYS_acct,
    SYS_syslog,
    SYS_personality,
    SYS_sethostname,
    SYS_setdomainname,
    SYS_settimeofday,
    SYS_clock_settime,
    SYS_adjtimex,
    SYS_clock_adjtime,
#if defined(__x86_64__)
    SYS_mknod,
    SYS_iopl,
    SYS_ioperm,
    SYS_modify_ldt,
    SYS_kexec_file_load,
#endif
};

/// That change what is on the disk.
constexpr std::array kChangingCalls = {
    SYS_mkdirat,     SYS_unlinkat,     SYS_symlinkat,    SYS_linkat,    SYS_renameat2,
    SYS_fchmodat,    SYS_fchmod,       SYS_fchownat,     SYS_fchown,    SYS_truncate,
    SYS_ftruncate,   SYS_utimensat,    SYS_setxattr,     SYS_lsetxattr, SYS_fsetxattr,
    SYS_removexattr, SYS_lremovexattr, SYS_fremovexattr, SYS_renameat,  SYS_memfd_create,
#if defined(__x86_64__)
    SYS_mkdir,       SYS_rmdir,        SYS_unlink,       SYS_symlink,   SYS_link,
    SYS_rename,      SYS_chmod,        SYS_chown,        SYS_lchown,    SYS_creat,
    SYS_utime,       SYS_utimes,       SYS_futimesat,
#endif
};

/// A program for the kernel's filter (seccomp(2)), which looks at every call.
class Filter {
 public:
  Filter() {
    load(offsetof(seccomp_data, arch));
    program_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0));
    answer(SECCOMP_RET_KILL_PROCESS);
    load(offsetof(seccomp_data, nr));
#if defined(__x86_64__)
    constexpr std::uint32_t kX32 = 0x40000000;  // the same calls by other numbers
    program_.push_back(BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, kX32, 0, 1));
    refuse(EPERM);
#endif
    // Their arguments lie in memory, where a filter cannot look: the older call is used instead.
    refuse_call(SYS_openat2, ENOSYS);
  }

  void refuse_call(long number, int error) {
    program_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, std::uint32_t(number), 0, 1));
    refuse(error);
  }

  /// Refuses to open a file but for reading.
  /// @param argument  the call's argument that says how it is opened
  void refuse_to_write(long number, unsigned argument) {
    const std::uint32_t changes = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND;
    program_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, std::uint32_t(number), 0, 4));
    load(std::uint32_t(offsetof(seccomp_data, args) + sizeof(std::uint64_t) * argument));
    program_.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, changes, 0, 1));
    refuse(EACCES);
    answer(SECCOMP_RET_ALLOW);
  }

  void install() {
    answer(SECCOMP_RET_ALLOW);
    const sock_fprog program{static_cast<unsigned short>(program_.size()), program_.data()};
    prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
  }

 private:
  void load(std::size_t offset) {
    program_.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, std::uint32_t(offset)));
  }
  void answer(std::uint32_t action) { program_.push_back(BPF_STMT(BPF_RET | BPF_K, action)); }
  void refuse(int error) { answer(SECCOMP_RET_ERRNO | std::uint32_t(error)); }

  std::vector<sock_filter> program_;
};

void hold_back_calls(bool may_write) {
  if (kArchitecture == 0) return;
  Filter filter;
  for (const long call : kRefusedCalls) filter.refuse_call(call, EPERM);
  if (!may_write) {
    for (const long call : kChangingCalls) filter.refuse_call(call, EACCES);
    filter.refuse_to_write(SYS_openat, 2);
#if defined(__x86_64__)
    filter.refuse_to_write(SYS_open, 1);
#endif
  }
  filter.install();
}

// ---- capabilities ------------------------------------------------------------------------------

/// Keeps these capabilities alone. @param kept  a bit each, of the first 32
void set_capabilities(std::uint32_t kept) {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> data{};
  data[0].effective = data[0].permitted = kept;
  syscall(SYS_capset, &header, data.data());
}

std::uint32_t permitted_capabilities() {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> data{};
  return syscall(SYS_capget, &header, data.data()) == 0 ? data[0].permitted : 0;
}

bool can(const std::filesystem::path& path, int mode) {
  return faccessat(AT_FDCWD, path.c_str(), mode, AT_EACCESS) == 0 || errno != EACCES;
}

/// Root reads files of others, as in containers, by a capability: it stays where nothing else
/// would do.
void drop_capabilities(const ReachableFiles& reach) {
  const std::uint32_t permitted = permitted_capabilities();
  for (int bound = 0; prctl(PR_CAPBSET_READ, bound) >= 0; ++bound) prctl(PR_CAPBSET_DROP, bound);
  prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0);
  if (permitted == 0) return;
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> none{};
  none[0].permitted = permitted;  // in reserve, while it is seen what goes without
  syscall(SYS_capset, &header, none.data());
  std::uint32_t kept = 0;
  for (const auto& path : reach.read)
    if (!can(path, R_OK)) kept |= 1U << CAP_DAC_READ_SEARCH;
  for (const auto& path : reach.write)
    if (!can(path, R_OK | W_OK | X_OK)) kept |= 1U << CAP_DAC_OVERRIDE;
  set_capabilities(kept & permitted);
}

}  // namespace

SandboxSupport sandbox_support() {
  return {landlock_version(), kArchitecture != 0 && prctl(PR_GET_SECCOMP, 0, 0, 0, 0) >= 0};
}

std::string to_text(const SandboxSupport& support) {
  const std::string calls = support.system_calls
                                ? "no network, no other programs (seccomp)"
                                : "network and other programs are open to them (no seccomp here)";
  const std::string files =
      support.landlock_version > 0
          ? "their input alone (Landlock " + std::to_string(support.landlock_version) + ")"
          : "any file that you may read (no Landlock here)";
  return "readers of foreign files reach " + files + "; " + calls;
}

void enter_sandbox(const ReachableFiles& reach, int kept) {
  prctl(PR_SET_DUMPABLE, 0, 0, 0, 0);
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  constexpr unsigned kFirst = 3;
  if (unsigned(kept) > kFirst) syscall(SYS_close_range, kFirst, unsigned(kept) - 1, 0);
  syscall(SYS_close_range, std::max(kFirst, unsigned(kept) + 1), ~0U, 0);
  drop_capabilities(reach);
  hold_back_files(reach);
  hold_back_calls(!reach.write.empty());
}

}  // namespace angio
