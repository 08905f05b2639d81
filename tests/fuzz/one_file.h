// A file for readers that take a path; rewritten for each input.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "host/base/helper_program.h"

namespace fascicle::fuzz {

class OneFile {
 public:
  explicit OneFile(const std::string& name) : path_(folder_.path() / name) {}
  const std::filesystem::path& folder() const { return folder_.path(); }
  const std::filesystem::path& path() const { return path_; }
  // Throws std::runtime_error.
  void write(std::string_view bytes) const;
  // A second file in the folder.
  void write_beside(const std::string& name, std::string_view bytes) const;

 private:
  base::TemporaryFolder folder_;
  std::filesystem::path path_;
};

}  // namespace fascicle::fuzz
