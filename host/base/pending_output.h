// A file that a helper program writes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/base/descriptor.h"

namespace fascicle::base {

// Create it before entering the sandbox, which allows no other file to be written.
class PendingOutput {
 public:
  // Creates an empty file next to `path`, and removes leftovers of helpers killed more than an hour ago.
  // Throws std::system_error.
  explicit PendingOutput(const std::string& path);
  PendingOutput(const PendingOutput&) = delete;
  PendingOutput& operator=(const PendingOutput&) = delete;
  // Removes the file unless it was finished. A signal that ends the process, except SIGKILL, also removes it;
  // with several files at once, only the first.
  ~PendingOutput();

  // Writes all bytes, syncs them to disk and renames the file to its final name. Throws std::system_error.
  void finish(std::string_view bytes);
  // The file's name until then.
  const std::string& part() const { return part_; }

 private:
  void listen();
  void listen_no_more();

  std::string path_, part_;
  Descriptor file_;
  bool is_whole_ = false, listens_ = false;
  std::vector<char> stack_;  // alternate signal stack, for signals caused by stack overflow
};

}  // namespace fascicle::base
