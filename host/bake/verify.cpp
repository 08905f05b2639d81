#include "host/bake/verify.h"

#include <algorithm>
#include <exception>
#include <optional>

#include "host/bake/bake.h"
#include "host/bake/checkpoint.h"
#include "host/bake/folder.h"
#include "host/bake/manifest.h"
#include "host/bake/model_file.h"
#include "host/bake/outputs.h"
#include "host/bake/read_frame_cache.h"
#include "host/base/file.h"
#include "host/base/text.h"
#include "host/formats/frame_files.h"
#include "host/formats/rest_mesh.h"
#include "host/formats/surface_objects.h"
#include "host/formats/vtk_xml.h"
#include "host/model/validate.h"

namespace fascicle::bake {
namespace {

namespace fs = std::filesystem;

class Verification {
 public:
  explicit Verification(const VerifyOptions& options)
      : options_(options),
        manifest_(manifest_of(options.bake)),
        is_complete_(manifest_.status == name_of(Status::complete)) {}

  VerifyResult run() {
    result_.status = manifest_.status;
    result_.in_use_here = is_in_use_here(options_.bake);
    // It may have ended since the manifest was read.
    if (!result_.in_use_here) result_.status = manifest_of(options_.bake).status;
    for (const std::string& name : manifest_.files) {
      if (result_.interrupted) break;
      if (name == manifest_name) continue;
      if (!is_there(name))
        check_absent(name);
      else if (name == cache_name)
        look_at(name, [&] { return frames_finding(); });
      else if (name == model_file_name)
        look_at(name, [&] { return model_finding(); });
      else if (name == checkpoint_name)
        look_at(name, [&] { return checkpoint_finding(); });
      else if (name == metrics_name)
        look_at(name, [&] { return metrics_finding(); });
      else
        look_at(name, [&] { return output_finding(name); });
    }
    return std::move(result_);
  }

 private:
  struct Wrong : std::runtime_error {
    using std::runtime_error::runtime_error;
  };

  fs::path path_of(const std::string& name) const { return options_.bake / name; }
  bool is_there(const std::string& name) const {
    std::error_code error;
    const fs::path path = path_of(name);
    return name.ends_with('/') ? fs::is_directory(path, error) : fs::is_regular_file(path, error);
  }

  void check_absent(const std::string& name) {
    // A complete bake needs no checkpoint; a surface may have neither materials nor images.
    const bool may_lack = !is_complete_ || name == checkpoint_name || name == formats::rest_materials_name ||
                          name == std::string(formats::textures_folder) + '/';
    if (!may_lack) result_.files.push_back({name, "is missing", false});
  }

  template <class Look>
  void look_at(const std::string& name, Look look) {
    try {
      result_.files.push_back({name, look(), true});
    } catch (const std::exception& error) {
      // File errors begin with the path, which the row already has.
      std::string text = error.what();
      const std::string path = path_of(name).string() + ": ";
      if (text.starts_with(path)) text.erase(0, path.size());
      result_.files.push_back({name, text, false});
    }
  }

  std::string frames_finding() {
    const FrameCacheReader cache(path_of(cache_name));
    const std::uint64_t count = cache.frame_count(), wanted = cache.header().frames + 1;
    std::vector<std::uint64_t> damaged, other;
    for (std::uint64_t k = 0; k < count && !result_.interrupted; ++k) {
      try {
        const model::Frame frame = cache.read(k);
        if (k < manifest_.position_hashes.size() &&
            base::hash_text(model::position_hash(frame)) != manifest_.position_hashes[k])
          other.push_back(k);
      } catch (const BakeError&) {
        damaged.push_back(k);
      }
      if (options_.on_frame) options_.on_frame(k, cache.header().frames);
      result_.interrupted = options_.interrupted != nullptr && options_.interrupted->load();
    }
    std::string wrong;
    const auto add = [&](const std::string& what) { wrong += (wrong.empty() ? "" : "; ") + what; };
    if (!damaged.empty()) add("damaged: " + frames_text(damaged));
    if (!other.empty()) add("differs from the manifest: " + frames_text(other));
    // In an unfinished bake, frames reach the disk before the manifest counts them.
    const std::uint64_t there = is_complete_ ? wanted : manifest_.position_hashes.size();
    if (!result_.interrupted && count < there)
      add("missing or damaged at the end: " + frames_text(count, there));
    if (is_complete_ && manifest_.position_hashes.size() != wanted)
      add("the manifest has hashes of " + base::number_text(manifest_.position_hashes.size()) +
          " frames instead of " + base::number_text(wanted));
    if (!wrong.empty()) throw Wrong(wrong);
    return base::number_text(count) + (is_complete_ ? "" : " of " + base::number_text(wanted)) +
           " frames, all good";
  }

  std::string model_finding() const {
    // The frame cache has the hash of its model.
    std::optional<std::uint64_t> hash;
    if (is_there(cache_name)) hash = FrameCacheReader(path_of(cache_name)).header().model_hash;
    const model::Model model = read_model_file(path_of(model_file_name), hash);
    return base::number_text(model.vertex_count) + " vertices, good";
  }

  // Files for other programs. Their bytes have no checksum, but must all be there.
  std::string output_finding(const std::string& name) const {
    const auto is_of_format = [&](const formats::Format& format) { return format.file == name; };
    const auto format = std::find_if(all_formats().begin(), all_formats().end(), is_of_format);
    if (!is_complete_) return "there";
    if (!name.ends_with('/')) {
      const std::uint64_t size = fs::file_size(path_of(name));
      if (size == 0) throw Wrong("is empty");
      if (name == formats::rest_name) hold_materials(name);
      const bool is_point_cache =
          format != all_formats().end() && (format->name == "pc2" || format->name == "mdd");
      if (is_point_cache &&
          size != format->bytes(read_model_file(path_of(model_file_name), {}), frame_files()))
        throw Wrong("has " + base::number_text(size) + " bytes, which are not all frames or too many");
      return "there";
    }
    if (format == all_formats().end()) return "there";  // textures, as many as the character has
    const std::string extension = name.substr(0, name.size() - 1);
    for (std::uint64_t k = 0; k < frame_files(); ++k)
      hold(name + formats::frame_file_name(manifest_.first_number + k, extension));
    for (const std::string& file : format->beside)
      if (file == name + formats::vtk_series) hold(file);
    if (format->name == "obj")
      hold_materials(name + formats::frame_file_name(manifest_.first_number, extension));
    return base::number_text(frame_files()) + " frames, there";
  }

  void hold(const std::string& file) const {
    std::error_code error;
    if (!fs::is_regular_file(path_of(file), error) || fs::file_size(path_of(file), error) == 0)
      throw Wrong("lacks " + file);
  }

  // The materials that an OBJ names in its first lines, and the images that these name.
  void hold_materials(const std::string& mesh) const {
    const base::File file(path_of(mesh), base::FileMode::read);
    std::string head(std::min<std::uint64_t>(file.size(), 1000), '\0');
    if (!file.read_at(0, head)) throw Wrong("cannot be read");
    constexpr std::string_view library = "\nmtllib ", image = "\nmap_Kd ";
    const std::size_t at = head.find(library);
    if (at == std::string::npos) return;
    const fs::path folder = fs::path(mesh).parent_path();
    const std::string name = head.substr(at + library.size(), head.find('\n', at + 1) - at - library.size());
    // Other names are not a bake's.
    if (fs::path(name).has_parent_path()) return;
    const std::string materials = (folder / name).string();
    hold(materials);
    const std::string text = base::read_input(path_of(materials), base::most_json_bytes);
    for (std::size_t k = text.find(image); k != std::string::npos; k = text.find(image, k + 1)) {
      const std::size_t begin = k + image.size();
      const fs::path texture =
          (folder / text.substr(begin, text.find('\n', begin) - begin)).lexically_normal();
      if (texture.parent_path() == formats::textures_folder) hold(texture.string());
    }
  }
  std::uint64_t frame_files() const { return manifest_.frames + 1; }

  std::string checkpoint_finding() const {
    const std::optional<Checkpoint> found = read_checkpoint(path_of(checkpoint_name));
    return found ? "of frame " + base::number_text(found->state.frame) + ", good" : "is gone";
  }

  std::string metrics_finding() const {
    const std::string text = base::read_input(path_of(metrics_name), base::most_metrics_bytes);
    const auto lines = static_cast<std::uint64_t>(std::count(text.begin(), text.end(), '\n'));
    const std::uint64_t rows = lines > 0 ? lines - 1 : 0;
    if (is_complete_ && rows != manifest_.frames + 1)
      throw Wrong("has " + base::number_text(rows) + " rows instead of " +
                  base::number_text(manifest_.frames + 1));
    return base::number_text(rows) + " rows";
  }

  // As a list, the frames of a header that lies could fill the memory.
  static std::string frames_text(std::uint64_t first, std::uint64_t end) {
    if (first + 1 == end) return "frame " + base::number_text(first);
    return "frames " + base::number_text(first) + " to " + base::number_text(end - 1);
  }
  static std::string frames_text(const std::vector<std::uint64_t>& frames) {
    return (frames.size() == 1 ? "frame " : "frames ") + ranges_text(frames);
  }

  const VerifyOptions& options_;
  const ManifestSummary manifest_;
  const bool is_complete_;
  VerifyResult result_;
};

}  // namespace

std::string ranges_text(const std::vector<std::uint64_t>& ascending) {
  constexpr std::size_t most_groups = 12;
  std::string text;
  std::size_t groups = 0;
  for (std::size_t first = 0; first < ascending.size();) {
    if (groups++ == most_groups) return text + " and more";
    std::size_t last = first;
    while (last + 1 < ascending.size() && ascending[last + 1] == ascending[last] + 1) ++last;
    text += (text.empty() ? "" : ", ") + base::number_text(ascending[first]);
    if (last > first) text += " to " + base::number_text(ascending[last]);
    first = last + 1;
  }
  return text;
}

bool VerifyResult::is_good() const {
  return std::all_of(files.begin(), files.end(), [](const VerifiedFile& file) { return file.is_good; });
}

VerifyResult verify_bake(const VerifyOptions& options) {
  return Verification(options).run();
}

}  // namespace fascicle::bake
