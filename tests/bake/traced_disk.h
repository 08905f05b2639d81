// What a disk may contain after a power cut, derived from a process's system calls. The model does not know
// how we write files, only what POSIX guarantees: bytes are safe after fsync of the file, names after fsync
// of the folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace fascicle::tests {

struct DiskCall {
  enum class Kind { create, write, truncate, sync, rename, remove, make_folder };
  Kind kind{};
  std::string path, to;      // `to`: for renames
  std::string bytes;         // for writes
  std::uint64_t offset = 0;  // for writes, or append; for truncations the new size
};
inline constexpr std::uint64_t append = ~std::uint64_t{0};

// Empty if commands can be traced here, otherwise the reason why not.
std::string why_no_strace();

// Runs a shell command under strace. Returns its calls below `folder` in order. Throws std::runtime_error if
// the command fails or makes a call there that this model does not know.
std::vector<DiskCall> traced(const std::string& command, const std::filesystem::path& folder);

class Disk {
 public:
  // Starts without the folder, which the calls create; its parent exists.
  explicit Disk(std::filesystem::path folder);
  void apply(const DiskCall& call);

  // Files below the folder by name, as a power cut may leave them: under the safe names, or under the latest
  // names, which a system may write before the bytes.
  enum class Names { safe, latest };
  using Files = std::map<std::string, std::string>;
  Files after_power_cut(Names names) const;
  // Paths whose bytes or names are not safe.
  std::vector<std::string> unsafe() const;
  bool is_dirty(const std::string& path) const;
  std::string content(const std::string& path) const;

 private:
  struct Inode {
    bool is_folder = false, is_dirty = false;
    std::string bytes, safe_bytes;
  };
  using Entries = std::map<std::string, std::shared_ptr<Inode>>;  // by path
  bool is_below_safe(const std::string& path) const;
  std::string relative(const std::string& path) const;

  std::string folder_;
  Entries latest_, safe_;
};

// Lists files published before their bytes were safe, and files that were not safe when a manifest or
// checkpoint that depends on them appeared. `counts` says whether it depends on a file; names are relative to
// the folder. Empty if the order is right.
std::vector<std::string> wrong_orders(
    const std::vector<DiskCall>& calls, const std::filesystem::path& folder,
    const std::function<bool(const std::string& name, bool at_end)>& counts);

}  // namespace fascicle::tests
