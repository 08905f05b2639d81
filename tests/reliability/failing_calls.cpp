// A preloaded library that makes file-changing calls in one folder fail, as on a full or broken disk, or ends
// the program before one of them.
//
//   FAILING_FOLDER  absolute; calls on files below it count
//   FAILING_CALL    the number of the first call that fails, from 1; 0: none
//   FAILING_MODE    "once": only that call; "from": that call and all later ones; "kill": SIGKILL ends the
//                   program before that call
//   FAILING_ERROR   errno
//   FAILING_COUNT   the number of calls is appended to this file when the process exits
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

namespace {

std::string text_of(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

struct Plan {
  std::string folder = text_of("FAILING_FOLDER"), count_file = text_of("FAILING_COUNT");
  unsigned long first = std::strtoul(text_of("FAILING_CALL").c_str(), nullptr, 10);
  bool only_once = text_of("FAILING_MODE") == "once", kills = text_of("FAILING_MODE") == "kill";
  int error = static_cast<int>(std::strtol(text_of("FAILING_ERROR").c_str(), nullptr, 10));
  std::atomic<unsigned long> calls{0};

  Plan() = default;
  Plan(const Plan&) = delete;
  Plan& operator=(const Plan&) = delete;
  ~Plan();
};

template <class Function>
Function real(const char* name) {
  Function function = nullptr;
  void* found = ::dlsym(RTLD_NEXT, name);
  std::memcpy(&function, &found, sizeof function);
  return function;
}

Plan& plan() {
  static Plan one;
  return one;
}

Plan::~Plan() {
  if (count_file.empty() || calls == 0) return;
  const std::string line = std::to_string(calls) + "\n";
  const int file =
      real<int (*)(const char*, int, ...)>("open")(count_file.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  if (file < 0) return;
  (void)!real<ssize_t (*)(int, const void*, std::size_t)>("write")(file, line.data(), line.size());
  ::close(file);
}

// Whether this call must fail; sets errno if so.
bool fails(const std::string& path) {
  Plan& p = plan();
  if (p.folder.empty() || path.compare(0, p.folder.size(), p.folder) != 0) return false;
  const unsigned long number = ++p.calls;
  if (p.first == 0 || number < p.first || (p.only_once && number > p.first)) return false;
  if (p.kills) ::raise(SIGKILL);
  errno = p.error;
  return true;
}

bool fails(int descriptor) {
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  char path[4096];
  const ssize_t size = ::readlink(link.c_str(), path, sizeof path);
  return size > 0 && fails(std::string(path, static_cast<std::size_t>(size)));
}

}  // namespace

extern "C" {

ssize_t write(int file, const void* bytes, size_t count) {
  if (fails(file)) return -1;
  return real<ssize_t (*)(int, const void*, size_t)>("write")(file, bytes, count);
}
ssize_t pwrite(int file, const void* bytes, size_t count, off_t offset) {
  if (fails(file)) return -1;
  return real<ssize_t (*)(int, const void*, size_t, off_t)>("pwrite")(file, bytes, count, offset);
}
ssize_t pwrite64(int file, const void* bytes, size_t count, off64_t offset) {
  if (fails(file)) return -1;
  return real<ssize_t (*)(int, const void*, size_t, off64_t)>("pwrite64")(file, bytes, count, offset);
}
ssize_t writev(int file, const iovec* pieces, int count) {
  if (fails(file)) return -1;
  return real<ssize_t (*)(int, const iovec*, int)>("writev")(file, pieces, count);
}
int fsync(int file) {
  return fails(file) ? -1 : real<int (*)(int)>("fsync")(file);
}
int fdatasync(int file) {
  return fails(file) ? -1 : real<int (*)(int)>("fdatasync")(file);
}
int ftruncate(int file, off_t size) noexcept {
  return fails(file) ? -1 : real<int (*)(int, off_t)>("ftruncate")(file, size);
}
int ftruncate64(int file, off64_t size) noexcept {
  return fails(file) ? -1 : real<int (*)(int, off64_t)>("ftruncate64")(file, size);
}
int rename(const char* from, const char* to) noexcept {
  return fails(std::string(to)) ? -1 : real<int (*)(const char*, const char*)>("rename")(from, to);
}
int mkdir(const char* path, mode_t mode) noexcept {
  return fails(std::string(path)) ? -1 : real<int (*)(const char*, mode_t)>("mkdir")(path, mode);
}
int open(const char* path, int flags, ...) {
  mode_t mode = 0;
  // O_TMPFILE includes the bit of O_DIRECTORY, so compare all its bits.
  if ((flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE) {
    std::va_list more;
    va_start(more, flags);
    mode = va_arg(more, mode_t);
    va_end(more);
    if (fails(std::string(path))) return -1;
  }
  return real<int (*)(const char*, int, ...)>("open")(path, flags, mode);
}

}  // extern "C"
