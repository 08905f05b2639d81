#include "host/base/sandbox.h"

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "host/base/descriptor.h"

namespace fascicle::base {
namespace {

// Landlock as in the kernel's ABI, because the C library's headers may be older than the kernel. Its system
// call numbers are the same on every architecture.
constexpr long landlock_create_ruleset = 444, landlock_add_rule = 445, landlock_restrict_self = 446;
constexpr std::uint32_t ask_version = 1, rule_of_path = 1;

// Kernels older than a field accept the struct if that field is 0.
struct Ruleset {
  std::uint64_t handled_access_fs;
  std::uint64_t handled_access_net;
  std::uint64_t scoped;
};
struct [[gnu::packed]] PathRule {
  std::uint64_t allowed_access;
  std::int32_t parent;
};

constexpr std::uint64_t read_file = 1 << 2, remove_file = 1 << 5, make_regular = 1 << 8;
constexpr std::uint64_t abstract_sockets = 1 << 0, signals = 1 << 1;

// All accesses that an ABI version knows; accesses that are handled but not allowed are refused.
std::uint64_t accesses_of(long version) {
  int count = 13;
  if (version >= 2) count = 14;  // linking and renaming across folders
  if (version >= 3) count = 15;  // truncation
  if (version >= 5) count = 16;  // ioctl on devices
  return (std::uint64_t{1} << count) - 1;
}

long landlock_version() {
  return ::syscall(landlock_create_ruleset, nullptr, std::size_t{0}, ask_version);
}

void allow(int rules, const std::string& path, std::uint64_t accesses) {
  const Descriptor place(::open(path.c_str(), O_PATH | O_CLOEXEC));
  if (place.get() < 0) return;
  const PathRule rule{accesses, place.get()};
  ::syscall(landlock_add_rule, rules, rule_of_path, &rule, 0U);
}

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

void restrict_files(const std::vector<std::string>& inputs, const std::string& output) {
  const long version = landlock_version();
  if (version < 1) return;
  // Scopes: signals and abstract sockets must not leave this process's domain.
  const Ruleset handled{accesses_of(version), 0, version >= 6 ? abstract_sockets | signals : 0};
  const Descriptor rules(static_cast<int>(::syscall(landlock_create_ruleset, &handled, sizeof handled, 0U)));
  if (rules.get() < 0) return;
  for (const std::string& input : inputs) allow(rules.get(), input, read_file);
  // Renaming needs both of these. The output itself is already open.
  if (!output.empty()) allow(rules.get(), folder_of(output), make_regular | remove_file);
  ::syscall(landlock_restrict_self, rules.get(), 0U);
}

// On other architectures system calls have other names, and there is no filter.
#if defined(__x86_64__) || defined(__aarch64__)
#if defined(__x86_64__)
constexpr std::uint32_t architecture = AUDIT_ARCH_X86_64;
#else
constexpr std::uint32_t architecture = AUDIT_ARCH_AARCH64;
#endif

// What reading, computing, writing and exiting need; some have two forms, depending on the architecture.
constexpr long allowed_calls[] = {
    SYS_read,
    SYS_readv,
    SYS_pread64,
    SYS_write,
    SYS_writev,
    SYS_pwrite64,
    SYS_lseek,
    SYS_openat,
    SYS_close,
    SYS_dup,
    SYS_dup3,
    SYS_fstat,
    SYS_newfstatat,
    SYS_statx,
    SYS_fsync,
    SYS_unlinkat,
    SYS_renameat,
    SYS_renameat2,
    SYS_getcwd,
    SYS_brk,
    SYS_munmap,
    SYS_mremap,
    SYS_madvise,
    SYS_futex,
    SYS_rt_sigaction,
    SYS_rt_sigreturn,
    SYS_rt_sigprocmask,
    SYS_sigaltstack,
    SYS_getpid,
    SYS_gettid,
    SYS_getrandom,
    SYS_clock_gettime,
    SYS_gettimeofday,
    SYS_getrusage,
    SYS_sched_getaffinity,
    SYS_restart_syscall,
    SYS_exit,
    SYS_exit_group,
#ifdef SYS_open
    SYS_open,
    SYS_stat,
    SYS_lstat,
    SYS_unlink,
    SYS_rename,
    SYS_dup2,
    SYS_time,
#endif
};

// Other fcntl() commands (F_SETOWN, F_SETFL with O_ASYNC) make a file signal arbitrary processes.
constexpr int allowed_of_fcntl[] = {F_DUPFD, F_DUPFD_CLOEXEC, F_GETFD, F_SETFD, F_GETFL};

constexpr auto of_call = static_cast<std::uint32_t>(offsetof(seccomp_data, nr));
constexpr auto of_architecture = static_cast<std::uint32_t>(offsetof(seccomp_data, arch));

// Offset of the lower half of an argument: both architectures are little-endian.
constexpr std::uint32_t of_argument(std::size_t number) {
  return static_cast<std::uint32_t>(offsetof(seccomp_data, args) + number * sizeof(std::uint64_t));
}

// A BPF program over the number and the arguments of a system call.
class Filter {
 public:
  Filter() {
    load(of_architecture);
    unless_equal(architecture, SECCOMP_RET_KILL_PROCESS);
    load(of_call);
    for (const long call : allowed_calls) {
      step(BPF_JMP | BPF_JEQ | BPF_K, number(call), 0, 1);
      answer(SECCOMP_RET_ALLOW);
    }
    // No memory becomes executable, so code left in memory by an overflow cannot run.
    for (const long call : {SYS_mmap, SYS_mprotect}) {
      step(BPF_JMP | BPF_JEQ | BPF_K, number(call), 0, 4);
      load(of_argument(2));
      step(BPF_JMP | BPF_JSET | BPF_K, PROT_EXEC, 0, 1);
      answer(refused);
      answer(SECCOMP_RET_ALLOW);
    }
    step(BPF_JMP | BPF_JEQ | BPF_K, number(SYS_fcntl), 0,
         2 + 2 * static_cast<int>(std::size(allowed_of_fcntl)));
    load(of_argument(1));
    for (const int command : allowed_of_fcntl) {
      step(BPF_JMP | BPF_JEQ | BPF_K, number(command), 0, 1);
      answer(SECCOMP_RET_ALLOW);
    }
    answer(refused);
    // abort() signals the process itself.
    step(BPF_JMP | BPF_JEQ | BPF_K, number(SYS_tgkill), 0, 4);
    load(of_argument(0));
    unless_equal(static_cast<std::uint32_t>(::getpid()), refused);
    answer(SECCOMP_RET_ALLOW);
    answer(refused);
  }

  void install() {
    const sock_fprog program{static_cast<unsigned short>(steps_.size()), steps_.data()};
    ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
  }

 private:
  static constexpr std::uint32_t refused = SECCOMP_RET_ERRNO | EPERM;

  static std::uint32_t number(long call) { return static_cast<std::uint32_t>(call); }
  void step(int code, std::uint32_t value, int if_true, int if_false) {
    steps_.push_back({static_cast<std::uint16_t>(code), static_cast<std::uint8_t>(if_true),
                      static_cast<std::uint8_t>(if_false), value});
  }
  void load(std::uint32_t offset) { step(BPF_LD | BPF_W | BPF_ABS, offset, 0, 0); }
  void answer(std::uint32_t value) { step(BPF_RET | BPF_K, value, 0, 0); }
  void unless_equal(std::uint32_t value, std::uint32_t answered) {
    step(BPF_JMP | BPF_JEQ | BPF_K, value, 1, 0);
    answer(answered);
  }

  std::vector<sock_filter> steps_;
};

void restrict_calls() {
  Filter().install();
}

bool has_seccomp() {
  const std::uint32_t answer = SECCOMP_RET_ERRNO;
  return ::syscall(SYS_seccomp, SECCOMP_GET_ACTION_AVAIL, 0U, &answer) == 0;
}
#else
void restrict_calls() {}

bool has_seccomp() {
  return false;
}
#endif

}  // namespace

void enter_sandbox(const std::vector<std::string>& inputs, const std::string& output) {
  // Required by both Landlock and seccomp.
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return;
  restrict_files(inputs, output);
  restrict_calls();
}

std::string sandbox_words() {
  std::string words;
  if (const long version = landlock_version(); version > 0) words = "Landlock " + std::to_string(version);
  if (has_seccomp()) words += words.empty() ? "seccomp" : ", seccomp";
  return words.empty() ? "none" : words;
}

}  // namespace fascicle::base
