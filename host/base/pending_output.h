// The file that a helper program writes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/base/descriptor.h"

namespace fascicle::base {

// Made before the sandbox is entered, which lets no further file be written.
class PendingOutput {
 public:
  // Makes an empty file beside `path`, and removes those that helpers left there which were killed more than
  // an hour ago. Throws std::system_error.
  explicit PendingOutput(const std::string& path);
  PendingOutput(const PendingOutput&) = delete;
  PendingOutput& operator=(const PendingOutput&) = delete;
  // Removes it unless it was finished. A signal that ends the process, but for SIGKILL, removes it too; of
  // several at a time that is so of the first.
  ~PendingOutput();

  // Writes all of it, to the disk too, and gives it its name. Throws std::system_error.
  void finish(std::string_view bytes);
  // The name that it has until then.
  const std::string& part() const { return part_; }

 private:
  void listen();
  void listen_no_more();

  std::string path_, part_;
  Descriptor file_;
  bool is_whole_ = false, listens_ = false;
  std::vector<char> stack_;  // for signals of a stack that is full
};

}  // namespace fascicle::base
