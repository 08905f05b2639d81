#include "host/bake/folder.h"

#include <algorithm>
#include <cerrno>
#include <sstream>
#include <system_error>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/bake/bake.h"
#include "host/bake/checkpoint.h"
#include "host/bake/manifest.h"
#include "host/bake/outputs.h"
#include "host/bake/read_frame_cache.h"
#include "host/base/part_file.h"
#include "host/formats/formats.h"
#include "host/formats/frame_files.h"
#include "host/formats/surface_objects.h"

namespace fascicle::bake {

namespace fs = std::filesystem;
using base::rename_over;

namespace {

constexpr std::uint64_t most_lock_bytes = std::uint64_t{64} << 20;  // of the kernel's table

// A file's final name and its temporary names.
std::vector<fs::path> forms_of(const fs::path& path) {
  return {path, fs::path(path.string() + base::part_suffix),
          fs::path(path.string() + base::temporary_suffix)};
}

// All existing files of one entry of the manifest's list.
std::vector<fs::path> existing(const fs::path& folder, const std::string& entry) {
  std::vector<fs::path> found;
  const auto add = [&](const fs::path& name) {
    // Do not follow links out of this folder.
    if (name.has_parent_path() && fs::is_symlink(folder / name.parent_path())) return;
    for (const fs::path& form : forms_of(folder / name))
      if (fs::symlink_status(form).type() != fs::file_type::not_found) found.push_back(form);
  };
  for (const formats::Format& format : all_formats())
    if (format.file == entry)
      for (const std::string& name : format.beside) add(name);
  if (!entry.ends_with('/')) {
    add(entry);
    return found;
  }
  const std::string extension = entry.substr(0, entry.size() - 1);
  const fs::path inner = folder / extension;
  if (fs::is_symlink(inner)) found.push_back(inner);
  if (!fs::is_directory(fs::symlink_status(inner))) return found;
  for (const auto& item : fs::directory_iterator(inner)) {
    std::string name = item.path().filename().string();
    if (name.ends_with(base::temporary_suffix))
      name.resize(name.size() - std::string(base::temporary_suffix).size());
    const bool is_ours = extension == formats::textures_folder ? formats::is_texture_name(name)
                                                               : formats::is_frame_file_name(name, extension);
    if (is_ours) found.push_back(item.path());
  }
  return found;
}

void refuse_folder(const fs::path& path) {
  if (fs::is_directory(fs::symlink_status(path)))
    throw BakeError(path.string() + ": is a folder; move it away");
}

void remove_file(const fs::path& path) {
  refuse_folder(path);
  fs::remove(path);
}

enum class Locking { held, held_by_another, impossible };

Locking lock(const base::Descriptor& descriptor) {
  if (::flock(descriptor.get(), LOCK_EX | LOCK_NB) == 0) return Locking::held;
  return errno == EWOULDBLOCK ? Locking::held_by_another : Locking::impossible;
}

bool is_at(const base::Descriptor& descriptor, const fs::path& path) {
  struct stat open {
  }, there{};
  return ::fstat(descriptor.get(), &open) == 0 && ::lstat(path.c_str(), &there) == 0 &&
         open.st_dev == there.st_dev && open.st_ino == there.st_ino;
}

constexpr const char* stage_name = "export.part";
// In a stage, so that no other folder of that name is mistaken for one.
constexpr const char* stage_mark = ".fascicle-export";

// Keeps files that are not an export's, and then the folder too.
void remove_stage(const fs::path& folder) {
  const fs::path stage = folder / stage_name;
  if (!fs::is_directory(fs::symlink_status(stage)) || !fs::exists(stage / stage_mark)) return;
  remove_files(stage, all_file_names());
  remove_file(stage / stage_mark);
  std::error_code not_empty;
  fs::remove(stage, not_empty);
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder)
    : folder_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)), path_(folder / lock_name) {
  if (folder_.get() < 0)
    throw std::system_error(errno, std::generic_category(), "cannot open " + folder.string());
  const auto in_use = [&] {
    return FolderInUse(folder.string() +
                       ": another fascicle is writing there; wait for it or choose another -o");
  };
  const Locking of_folder = lock(folder_);
  if (of_folder == Locking::held_by_another) throw in_use();
  while (of_folder == Locking::impossible) {
    file_ = base::Descriptor(::open(path_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666));
    if (file_.get() < 0) {
      // A bake that is only read, to export it to another folder.
      if (errno == EACCES || errno == EPERM || errno == EROFS) break;
      if (errno == ELOOP) throw BakeError(path_.string() + ": is a symbolic link; move it away");
      throw std::system_error(errno, std::generic_category(), "cannot open " + path_.string());
    }
    if (lock(file_) == Locking::held_by_another) throw in_use();
    // Its last holder may have removed it in between.
    if (is_at(file_, path_)) break;
  }
}

FolderLock::~FolderLock() {
  if (file_.get() >= 0) ::unlink(path_.c_str());
}

bool is_in_use_here(const fs::path& folder) {
  std::vector<std::string> ends;
  for (const fs::path& locked : {folder, folder / lock_name})
    if (struct stat about{}; ::stat(locked.c_str(), &about) == 0)
      ends.push_back(":" + std::to_string(about.st_ino) + " ");
  try {
    std::istringstream locks(base::read_input_if_there("/proc/locks", most_lock_bytes).value_or(""));
    for (std::string line; std::getline(locks, line);)
      if (line.find("FLOCK") != std::string::npos && line.find(" WRITE ") != std::string::npos &&
          std::any_of(ends.begin(), ends.end(),
                      [&](const auto& end) { return line.find(end) != std::string::npos; }))
        return true;
  } catch (const base::InputError&) {
    // The system does not show it.
  }
  return false;
}

void make_folder(const fs::path& folder) {
  if (folder.empty()) throw BakeError("no output folder given; use -o FOLDER");
  if (fs::exists(folder) && !fs::is_directory(folder))
    throw BakeError(folder.string() + ": is not a folder; choose another -o");
  std::vector<fs::path> made;
  for (fs::path path = fs::absolute(folder).lexically_normal(); !fs::exists(path); path = path.parent_path())
    made.push_back(path);
  fs::create_directories(folder);
  for (const fs::path& path : made) base::sync_folder(path.parent_path());
}

bool holds_bake(const fs::path& folder) {
  return read_manifest(folder).has_value() || is_frame_cache(folder / cache_name) ||
         is_checkpoint(folder / checkpoint_name);
}

namespace {

// The entries that clear_bake() removes.
std::vector<std::string> entries_of_bake(const fs::path& folder) {
  const std::vector<std::string> known = all_file_names();
  std::vector<std::string> made = files_listed(folder);
  // Without a manifest, remove only files recognisable as ours.
  if (is_frame_cache(folder / cache_name)) made.push_back(cache_name);
  if (is_checkpoint(folder / checkpoint_name)) made.push_back(checkpoint_name);
  // The manifest goes last: as long as it exists, an interrupted removal can be repeated.
  std::stable_partition(made.begin(), made.end(),
                        [](const std::string& entry) { return entry != manifest_name; });
  std::erase_if(made, [&](const std::string& entry) {
    return std::find(known.begin(), known.end(), entry) == known.end();
  });
  return made;
}

}  // namespace

void clear_bake(const fs::path& folder) {
  // If the removal is interrupted, nothing is left to resume, and `--resume` starts again.
  try {
    set_running_from(folder, 0);
  } catch (const std::system_error&) {
    // A full disk: the removal makes room.
  }
  remove_files(folder, entries_of_bake(folder));
  remove_stage(folder);
}

void remove_files(const fs::path& folder, const std::vector<std::string>& files) {
  for (const std::string& entry : files) {
    for (const fs::path& path : existing(folder, entry)) remove_file(path);
    std::error_code not_empty;
    if (entry.ends_with('/')) fs::remove(folder / entry.substr(0, entry.size() - 1), not_empty);
  }
  base::sync_folder(folder);
}

ExportStage::ExportStage(const fs::path& folder) : folder_(folder), path_(folder / stage_name) {
  remove_stage(folder_);
  // An empty one was left by an export that was killed as it began.
  const bool is_empty = fs::is_directory(fs::symlink_status(path_)) && fs::is_empty(path_);
  if (!is_empty && fs::exists(fs::symlink_status(path_)))
    throw BakeError(path_.string() + ": exists, but no export made it; move it away");
  fs::create_directory(path_);
  base::File(path_ / stage_mark, base::FileMode::replace).close();
}

ExportStage::~ExportStage() {
  try {
    remove_stage(folder_);
  } catch (const std::exception&) {
    // The next export to this folder removes it.
  }
}

void ExportStage::move_up(const std::vector<std::string>& files) {
  for (const std::string& entry : files) {
    std::vector<fs::path> made = existing(path_, entry);
    const bool is_folder = entry.ends_with('/');
    if (is_folder && !made.empty()) {
      const fs::path inner = folder_ / entry.substr(0, entry.size() - 1);
      if (fs::is_symlink(inner)) fs::remove(inner);
      base::make_own_folder(inner);
    }
    // A collection comes after the frames that it lists.
    std::reverse(made.begin(), made.end());
    for (const fs::path& from : made) base::rename_over(from, folder_ / from.lexically_relative(path_));
    if (!is_folder || made.empty()) continue;
    // Other formats share textures, which this export may not have.
    if (entry != std::string(formats::textures_folder) + '/')
      for (const fs::path& path : existing(folder_, entry))
        if (std::find(made.begin(), made.end(), path_ / path.lexically_relative(folder_)) == made.end())
          remove_file(path);
    base::sync_folder(folder_ / entry);
  }
  base::sync_folder(folder_);
}

void refuse_foreign(const fs::path& folder, const std::vector<std::string>& files) {
  // Left behind by a bake that is stopped while writing its first file.
  const fs::path first_temporary = folder / (std::string(manifest_name) + base::temporary_suffix);
  const std::vector<std::string> listed = files_listed(folder);
  const auto is_listed = [&](const std::string& entry) {
    return std::find(listed.begin(), listed.end(), entry) != listed.end();
  };
  for (const std::string& entry : files)
    for (const fs::path& path : existing(folder, entry))
      if (path != first_temporary)
        throw BakeError(path.string() +
                        (is_listed(entry)
                             ? ": already exists; --overwrite replaces it"
                             : ": would be overwritten, but no bake made it; move it or choose another -o"));
}

void refuse_to_replace(const fs::path& folder, const std::vector<std::string>& files) {
  const std::vector<std::string> made = entries_of_bake(folder);
  for (const std::string& entry : made)
    for (const fs::path& path : existing(folder, entry)) refuse_folder(path);
  std::vector<std::string> others = files;
  std::erase_if(others, [&](const std::string& entry) {
    return std::find(made.begin(), made.end(), entry) != made.end();
  });
  refuse_foreign(folder, others);
}

void refuse_lost(const fs::path& folder, const std::string& file, std::uint64_t last,
                 std::uint64_t first_number) {
  const auto refuse_lost_file = [](const fs::path& path) {
    const std::vector<fs::path> forms = forms_of(path);
    if (std::none_of(forms.begin(), forms.end(), base::has_content)) throw base::LostFile(path);
  };
  if (!file.ends_with('/')) return refuse_lost_file(folder / file);
  const std::string extension = file.substr(0, file.size() - 1);
  for (std::uint64_t k = 0; k <= last; ++k)
    refuse_lost_file(folder / extension / formats::frame_file_name(first_number + k, extension));
}

}  // namespace fascicle::bake
