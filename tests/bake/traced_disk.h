// What a disk holds after a power cut, by a process' own system calls: a model that knows nothing of how we
// write files, only what POSIX promises. Bytes are safe after fsync of their file, names after fsync of their
// folder.
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
  std::string path, to;      // `to`: of a rename
  std::string bytes;         // of a write
  std::uint64_t offset = 0;  // of a write, or append; of a truncation the new size
};
inline constexpr std::uint64_t append = ~std::uint64_t{0};

// Empty where a command can be traced here, else why not.
std::string why_no_strace();

// Runs a command of the shell under strace; what it did below `folder`, in the order in which it was done.
// Throws std::runtime_error where the command fails, or where it did there what this model does not know.
std::vector<DiskCall> traced(const std::string& command, const std::filesystem::path& folder);

class Disk {
 public:
  // The folder is made by the calls; the one above it is there.
  explicit Disk(std::filesystem::path folder);
  void apply(const DiskCall& call);

  // Files below the folder by name, as a power cut may leave them: with the names that are safe, or with
  // those that there were, which a system may write before the bytes.
  enum class Names { safe, latest };
  using Files = std::map<std::string, std::string>;
  Files after_power_cut(Names names) const;
  // Names whose bytes or which themselves are not safe.
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

// Where files were published before their bytes were safe, and where manifest or checkpoint appeared before
// everything was that they count on: what `counts` says, of names relative to the folder. Empty: nowhere.
std::vector<std::string> wrong_orders(
    const std::vector<DiskCall>& calls, const std::filesystem::path& folder,
    const std::function<bool(const std::string& name, bool at_end)>& counts);

}  // namespace fascicle::tests
