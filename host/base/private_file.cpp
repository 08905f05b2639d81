#include "host/base/private_file.h"

#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "host/base/descriptor.h"

namespace fascicle::base {

void write_private(const std::filesystem::path& path, std::string_view text) {
  // An existing name may be a link to anywhere.
  ::unlink(path.c_str());
  errno = 0;
  const Descriptor file(
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR));
  if (file.get() >= 0 && ::write(file.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size()))
    return;
  // A short write sets no error.
  const int code = errno != 0 ? errno : ENOSPC;
  if (file.get() >= 0) ::unlink(path.c_str());
  throw std::system_error(code, std::generic_category(), "cannot write " + path.string());
}

}  // namespace fascicle::base
