// For formats that write one file per frame, frame_NNNNNN.EXTENSION, into a separate folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace fascicle::formats {

// The folder's name is the extension: vtu/frame_000012.vtu.
std::string frame_file_name(std::uint64_t number, const std::string& extension);
bool is_frame_file_name(const std::string& name, const std::string& extension);

class FrameFiles {
 public:
  // Makes FOLDER/EXTENSION. The files of frames before `first` must exist; later ones are removed. The file
  // of frame 0 has the number `first_number`. Throws BakeError.
  FrameFiles(const std::filesystem::path& folder, const std::string& extension, std::uint64_t first,
             std::uint64_t first_number = 0);

  const std::filesystem::path& folder() const { return folder_; }
  std::uint64_t number_of(std::uint64_t frame) const { return first_number_ + frame; }
  void write(std::uint64_t frame, std::string_view bytes);
  // Moves the files written so far to their final names; they then survive a power cut.
  void sync();

 private:
  std::filesystem::path path_of(std::uint64_t frame) const;

  std::filesystem::path folder_;
  std::string extension_;
  std::uint64_t first_number_ = 0;
  std::vector<std::filesystem::path> staged_;  // written since the last sync
};

}  // namespace fascicle::formats
