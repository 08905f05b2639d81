// The -o folder: whose it is, and what in it may be removed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/base/descriptor.h"

namespace fascicle::bake {

// Keeps two bakes out of one folder. Released on destruction, and by the system when the process dies. Throws
// BakeError if another process holds it.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);

 private:
  base::Descriptor descriptor_;
};

// Makes the folder and those above it, durably. Throws BakeError if the path is something else.
void make_folder(const std::filesystem::path& folder);

// Whether a bake was begun there: a manifest of fascicle, a frame cache or a checkpoint.
bool holds_bake(const std::filesystem::path& folder);

// Removes what the bake there made: the files that its manifest lists, as far as they are names a bake
// writes, with their unfinished forms. Everything else in the folder stays, also where a manifest lists it.
void clear_bake(const std::filesystem::path& folder);

// Removes these files (in the form of the manifest's list) with their unfinished forms.
void remove_files(const std::filesystem::path& folder, const std::vector<std::string>& files);

// Where an export's files grow: a folder of its own beside their places, so that what was exported there
// before stays as it is until the new files are whole. What one that was killed left is removed first. Goes
// with its owner.
class ExportStage {
 public:
  explicit ExportStage(const std::filesystem::path& folder);
  ~ExportStage();
  ExportStage(const ExportStage&) = delete;
  ExportStage& operator=(const ExportStage&) = delete;

  const std::filesystem::path& path() const { return path_; }
  // Moves these files (in the form of the manifest's list), as far as they are there, to their places. Each
  // takes the place of an earlier one whole; of an earlier series no frame stays.
  void move_up(const std::vector<std::string>& files);

 private:
  std::filesystem::path folder_, path_;
};

// Throws BakeError if one of the `files` (in the form of the manifest's list) is there already: no bake made
// it.
void refuse_foreign(const std::filesystem::path& folder, const std::vector<std::string>& files);

}  // namespace fascicle::bake
