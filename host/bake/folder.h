// The -o folder: who owns it, and which files in it may be removed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/base/descriptor.h"

namespace fascicle::bake {

// Keeps two bakes out of one folder. Released on destruction, and by the system when the process dies. Throws
// FolderInUse if another process holds the lock. NFS locks files but no folders: there the lock is on a file
// in the folder, `lock_name`, which destruction removes. A file system without any locks is used unlocked.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  base::Descriptor folder_, file_;
  std::filesystem::path path_;  // of the file
};
inline constexpr const char* lock_name = "fascicle.lock";

// Whether a process of this computer holds the lock. False where the file system has no locks. Reads the
// kernel's table: trying the lock could keep out a bake that begins at that moment.
bool is_in_use_here(const std::filesystem::path& folder);

// Creates the folder and its parents durably. Throws BakeError if the path is something else.
void make_folder(const std::filesystem::path& folder);

// Whether it contains a bake, finished or not: a manifest of fascicle, a frame cache or a checkpoint.
bool holds_bake(const std::filesystem::path& folder);

// Removes a bake's files: those that its manifest lists, if a bake can write files of that name, and their
// partial forms. Everything else in the folder stays, even if a manifest lists it.
void clear_bake(const std::filesystem::path& folder);

// Removes these files (in the form of the manifest's list) and their partial forms.
void remove_files(const std::filesystem::path& folder, const std::vector<std::string>& files);

// A separate folder in which an export writes its files, so that an earlier export stays as it is until the
// new files are complete. Leftovers of a killed export are removed first. Removed on destruction.
class ExportStage {
 public:
  explicit ExportStage(const std::filesystem::path& folder);
  ~ExportStage();
  ExportStage(const ExportStage&) = delete;
  ExportStage& operator=(const ExportStage&) = delete;

  const std::filesystem::path& path() const { return path_; }
  // Moves those of these files (in the form of the manifest's list) that exist to their final places. Each
  // replaces an earlier file as a whole; no frames of an earlier series are left.
  void move_up(const std::vector<std::string>& files);

 private:
  std::filesystem::path folder_, path_;
};

// Throws BakeError if one of the `files` (in the form of the manifest's list) already exists: no bake made
// it.
void refuse_foreign(const std::filesystem::path& folder, const std::vector<std::string>& files);

// The same before clear_bake(): throws, and changes nothing, if one of the `files` exists that it would not
// remove, or if it would meet a folder in place of a file.
void refuse_to_replace(const std::filesystem::path& folder, const std::vector<std::string>& files);

// Throws BakeError if `file` (in the form of the manifest's list) is gone, or one of its frames 0 to `last`;
// `first_number`: number of frame 0.
void refuse_lost(const std::filesystem::path& folder, const std::string& file, std::uint64_t last,
                 std::uint64_t first_number);

}  // namespace fascicle::bake
