#include "host/base/file.h"

#include <bit>
#include <cerrno>
#include <cstdio>
#include <random>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/base/descriptor.h"
#include "host/base/errors.h"
#include "host/base/parallel.h"
#include "host/base/text.h"

namespace fascicle::base {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little,
              "the binary formats are written as they lie in memory");

namespace {

[[noreturn]] void fail(const char* what, const fs::path& path) {
  const int code = errno;
  throw std::system_error(code, std::generic_category(),
                          std::string(what) + " " + path.string() +
                              (code == EFBIG ? ", which exceeds the file size limit (raise ulimit -f)" : ""));
}

int open_retried(const fs::path& path, int flags) {
  for (;;) {
    const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
    if (descriptor >= 0 || errno != EINTR) return descriptor;
  }
}

// O_EXCL: an existing name may be a symbolic link to anywhere, or a hard link. Neither is written through.
int open_new(const fs::path& path) {
  constexpr int most_tries = 8;  // others may keep recreating the name
  int descriptor = -1;
  for (int k = 0; k < most_tries; ++k) {
    descriptor = open_retried(path, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW);
    if (descriptor >= 0 || errno != EEXIST) break;
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) break;
  }
  return descriptor;
}

fs::path with_suffix(const fs::path& path, const std::string& suffix) {
  return fs::path(path.string() + suffix);
}

using Pieces = std::span<const std::string_view>;

// A change would reach the other names, such as a snapshot's.
void refuse_other_names(int descriptor, const fs::path& path) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) fail("cannot examine", path);
  if (status.st_nlink > 1)
    throw BakeError(path.string() +
                    ": is a hard link, so that a change would also change the file's other name; replace it "
                    "with a copy, or start again with --overwrite");
}

// Leaves no file behind on failure.
void write_new(const fs::path& path, Pieces pieces, bool sync) {
  try {
    File file(path, FileMode::replace);
    for (const std::string_view bytes : pieces) file.write(bytes);
    if (sync) file.sync();
    file.close();
  } catch (const std::system_error&) {
    std::error_code ignored;
    fs::remove(path, ignored);
    throw;
  }
}

void replace_file(const fs::path& path, const fs::path& temporary, Pieces pieces) {
  write_new(temporary, pieces, true);
  try {
    rename_over(temporary, path);
  } catch (const std::system_error&) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw;
  }
  sync_folder(path.parent_path());
}

std::string message_of(int error) {
  return std::generic_category().message(error);
}

// Asks the open file, not its name, which may refer to another file by now.
std::uint64_t size_of_regular(int descriptor, const fs::path& path) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) throw InputError(path, "cannot be read: " + message_of(errno));
  if (!S_ISREG(status.st_mode)) throw InputError(path, "is not a regular file; give the name of one");
  return static_cast<std::uint64_t>(status.st_size);
}

// O_NONBLOCK: opening a pipe must not wait for its other end. On regular files it does nothing.
constexpr int input_flags = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;

// Nothing if no file has that name.
template <class Bytes>
std::optional<Bytes> read_whole(const fs::path& path, std::uint64_t most_bytes, Links links) {
  const Descriptor file(::open(path.c_str(), input_flags | (links == Links::refused ? O_NOFOLLOW : 0)));
  if (file.get() < 0 && (errno == ENOENT || errno == ENOTDIR)) return std::nullopt;
  if (file.get() < 0) throw InputError(path, "cannot be opened: " + message_of(errno));
  const std::uint64_t size = size_of_regular(file.get(), path);
  const auto refuse_above = [&](std::uint64_t count) {
    if (count > most_bytes)
      throw InputError(path, "has more than the " + number_text(most_bytes) +
                                 " bytes allowed for such a file; is it the right one?");
  };
  refuse_above(size);
  // Reads to the end of the file, not to its size: the file may grow meanwhile, and files in /proc report
  // size 0. The extra byte detects the end.
  Bytes bytes;
  bytes.resize(static_cast<std::size_t>(size) + 1);
  std::size_t done = 0;
  while (true) {
    const ssize_t got = ::read(file.get(), bytes.data() + done, bytes.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError(path, "cannot be read: " + message_of(errno));
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
    refuse_above(done);
    if (done == bytes.size()) bytes.resize(2 * done);
  }
  bytes.resize(done);
  return bytes;
}

template <class Bytes>
Bytes of_there(std::optional<Bytes> bytes, const fs::path& path) {
  if (!bytes) throw InputError(path, "does not exist");
  return std::move(*bytes);
}

}  // namespace

std::string read_input(const fs::path& path, std::uint64_t most_bytes) {
  return of_there(read_input_if_there(path, most_bytes), path);
}

std::vector<unsigned char> read_input_bytes(const fs::path& path, std::uint64_t most_bytes, Links links) {
  return of_there(read_whole<std::vector<unsigned char>>(path, most_bytes, links), path);
}

std::optional<std::string> read_input_if_there(const fs::path& path, std::uint64_t most_bytes) {
  return read_whole<std::string>(path, most_bytes, Links::followed);
}

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

void rename_over(const fs::path& from, const fs::path& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) fail("cannot rename to", to);
}

File::File(fs::path path, FileMode mode) : path_(std::move(path)) {
  descriptor_ = mode == FileMode::read     ? open_retried(path_, input_flags)
                : mode == FileMode::modify ? open_retried(path_, O_RDWR | O_NOFOLLOW | O_NONBLOCK)
                                           : open_new(path_);
  if (descriptor_ < 0 && mode == FileMode::modify && errno == ELOOP)
    throw BakeError(
        path_.string() +
        ": is a symbolic link, and nothing is written through one; replace it with the file, or start "
        "again with --overwrite");
  if (descriptor_ < 0) fail("cannot open", path_);
  try {
    if (mode != FileMode::replace) (void)size_of_regular(descriptor_, path_);
    if (mode == FileMode::modify) refuse_other_names(descriptor_, path_);
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
  if (mode == FileMode::modify && ::lseek(descriptor_, 0, SEEK_END) < 0) {
    const int code = errno;
    ::close(descriptor_);
    errno = code;
    fail("cannot seek in", path_);
  }
}

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

File::File(File&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

File& File::operator=(File&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

std::uint64_t File::size() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) fail("cannot get the size of", path_);
  return static_cast<std::uint64_t>(status.st_size);
}

void File::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::write(descriptor_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) fail("cannot write", path_);
    bytes.remove_prefix(static_cast<std::size_t>(done));
  }
}

void File::write_at(std::uint64_t offset, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) fail("cannot write", path_);
    bytes.remove_prefix(static_cast<std::size_t>(done));
    offset += static_cast<std::uint64_t>(done);
  }
}

bool File::read_at(std::uint64_t offset, std::span<char> bytes) const {
  while (!bytes.empty()) {
    const ssize_t done = ::pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) fail("cannot read", path_);
    if (done == 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(done));
    offset += static_cast<std::uint64_t>(done);
  }
  return true;
}

void File::truncate(std::uint64_t size) {
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) fail("cannot shorten", path_);
  if (::lseek(descriptor_, static_cast<off_t>(size), SEEK_SET) < 0) fail("cannot seek in", path_);
}

void File::sync() {
  if (::fsync(descriptor_) != 0) fail("cannot write to disk", path_);
}

void File::close() {
  if (::close(std::exchange(descriptor_, -1)) != 0) fail("cannot write", path_);
}

void make_own_folder(const fs::path& path) {
  if (fs::is_symlink(path))
    throw BakeError(
        path.string() +
        ": is a symbolic link, and nothing is written through one; move it away, or start again with "
        "--overwrite");
  fs::create_directories(path);
}

void sync_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) fail("cannot open", folder);
  const int result = ::fsync(descriptor);
  const int code = errno;
  ::close(descriptor);
  // Some file systems cannot sync a folder and report EINVAL; their renames are as durable as they can be.
  if (result != 0 && code != EINVAL) {
    errno = code;
    fail("cannot write to disk", folder);
  }
}

void write_whole(const fs::path& path, std::string_view bytes) {
  write_whole(path, Pieces(&bytes, 1));
}

void write_whole(const fs::path& path, Pieces pieces) {
  replace_file(path, with_suffix(path, temporary_suffix), pieces);
}

void stage(const fs::path& path, std::string_view bytes) {
  write_new(with_suffix(path, temporary_suffix), Pieces(&bytes, 1), false);
}

void publish(const fs::path& folder, std::span<const fs::path> paths) {
  // A disk handles several syncs at once in little more time than one.
  constexpr std::size_t most_at_once = 8;
  for_each_in_parallel(paths.size(), most_at_once, [&](std::size_t k, std::size_t) {
    const fs::path staged = with_suffix(paths[k], temporary_suffix);
    const int descriptor = open_retried(staged, O_RDWR | O_NOFOLLOW | O_NONBLOCK);
    if (descriptor < 0) fail("cannot open", staged);
    const int result = ::fsync(descriptor), code = errno;
    ::close(descriptor);
    if (result == 0) return;
    errno = code;
    fail("cannot write to disk", staged);
  });
  for (const fs::path& path : paths) rename_over(with_suffix(path, temporary_suffix), path);
  sync_folder(folder);
}

void write_whole_beside_others(const fs::path& path, std::string_view bytes) {
  // On a shared file system, others may run on other hosts, where a process may have the same id.
  std::random_device entropy;
  const std::uint64_t number = std::uint64_t{entropy()} << 32 | entropy();
  const std::string own = "." + hash_text(number) + temporary_suffix;
  constexpr std::size_t longest_name = 255;  // bytes, of common file systems
  const bool fits = path.filename().string().size() + own.size() <= longest_name;
  replace_file(path, fits ? with_suffix(path, own) : path.parent_path() / own, Pieces(&bytes, 1));
}

}  // namespace fascicle::base
