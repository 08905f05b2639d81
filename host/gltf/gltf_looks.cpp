#include "host/gltf/gltf_looks.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <tuple>

#include "host/base/errors.h"
#include "host/gltf/gltf_check.h"
#include "host/gltf/gltf_decode.h"
#include "host/gltf/gltf_library.h"
#include "host/gltf/gltf_limits.h"
#include "host/gltf/gltf_material.h"

namespace fascicle::gltf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class LooksReader {
 public:
  LooksReader(const fs::path& path, const json& document, const tinygltf::Model& model)
      : path_(path), document_(document), model_(model), beside_(path), embedded_left_(stored_bytes(model)) {}

  Looks run(const Rig& rig) {
    for (const json& material : list("materials")) looks_.materials.push_back(read_look(material));
    const auto white = static_cast<std::uint32_t>(looks_.materials.size());
    looks_.materials.emplace_back();
    for (const RigPart& part : rig.parts) {
      const json& primitive = primitive_of(part);
      PartLooks looks{.material = white, .uvs = {}, .colours = {}};
      if (const auto m = json_index(json_member(primitive, "material"), list("materials"))) {
        looks.material = static_cast<std::uint32_t>(*m);
        looks_.has_colours = true;
      }
      const std::size_t count = part.positions.size();
      if (looks_.materials[looks.material].texture >= 0) looks.uvs = part.uvs;
      looks.colours = colours_of(primitive, count);
      looks_.has_colours = looks_.has_colours || !looks.colours.empty();
      looks_.parts.push_back(std::move(looks));
    }
    return std::move(looks_);
  }

 private:
  const json& list(const char* name) const { return json_member(document_, name); }

  const json& primitive_of(const RigPart& part) const {
    try {
      return document_.at("meshes").at(part.mesh).at("primitives").at(part.primitive);
    } catch (const json::exception&) {
      throw base::SceneError(path_.string() + ": has changed while it was read; try again");
    }
  }

  LookMaterial read_look(const json& source) {
    const Material material = read_material(document_, source);
    LookMaterial result;
    result.name = material.name;
    result.base_colour = material.base_colour;
    if (material.alpha_mode == AlphaMode::mask) result.alpha_cutoff = material.alpha_cutoff;
    if (material.texture) result.texture = texture_of(material.texture->texture);
    return result;
  }

  // The texture's index in Looks::textures; -1 if it cannot be read.
  std::int32_t texture_of(std::size_t texture) {
    if (const auto known = number_of_.find(texture); known != number_of_.end()) return known->second;
    std::int32_t result = -1;
    const TextureSource source = texture_source(document_, texture);
    if (source.image) {
      const auto [known, is_new] =
          number_of_wrapped_.try_emplace({*source.image, source.across, source.down}, -1);
      if (is_new) known->second = add_texture(*source.image, source.across, source.down);
      result = known->second;
    } else {
      looks_.notes.push_back("texture " + std::to_string(texture) +
                             " is neither PNG nor JPEG; its surface gets its plain colour");
    }
    number_of_[texture] = result;
    return result;
  }

  std::int32_t add_texture(std::size_t image, TextureWrap across, TextureWrap down) {
    LookTexture read{
        .name = "image " + std::to_string(image), .bytes = nullptr, .across = across, .down = down};
    const std::string name = json_text(json_member(list("images")[image], "name"), "");
    if (!name.empty()) read.name += " (" + name.substr(0, 60) + ")";
    read.bytes = image_bytes(list("images")[image], image, read.name);
    if (read.bytes == nullptr) return -1;
    looks_.textures.push_back(std::move(read));
    return static_cast<std::int32_t>(looks_.textures.size() - 1);
  }

  // Null for an image that cannot be read, after a note. Images of the same bytes share them: a small file
  // may name its bytes again and again.
  ImageBytes image_bytes(const json& image, std::size_t number, const std::string& name) {
    std::string why = "is empty";
    ImageBytes bytes;
    try {
      if (const auto view = json_index(json_member(image, "bufferView"), list("bufferViews"))) {
        bytes = bytes_of_view(*view, why);
      } else if (const json& uri = json_member(image, "uri"); uri.is_string()) {
        const auto text = uri.get<std::string>();
        if (text.starts_with("data:")) {
          why = "is not base64";
          bytes = shared_bytes("image " + std::to_string(number), [&] { return data_uri_bytes(text); });
        } else {
          bytes = beside_.read("/images", text);
        }
      }
    } catch (const base::SceneError& error) {
      why = std::string("cannot be read: ") + error.what();
    }
    if (bytes != nullptr && !bytes->empty()) return bytes;
    looks_.notes.push_back(name + " " + why + "; its surface gets its plain colour");
    return nullptr;
  }

  ImageBytes bytes_of_view(std::size_t view, std::string& why) {
    // The decoder's views match the file's, and were checked to fit their buffers.
    const tinygltf::BufferView& v = model_.bufferViews.at(view);
    const std::vector<unsigned char>& data = model_.buffers.at(static_cast<std::size_t>(v.buffer)).data;
    if (v.byteOffset > data.size() || v.byteLength > data.size() - v.byteOffset) return nullptr;
    const std::string place = "buffer " + std::to_string(v.buffer) + " " + std::to_string(v.byteOffset) +
                              " " + std::to_string(v.byteLength);
    if (!bytes_of_.contains(place)) {
      // Views of honest files do not overlap.
      if (v.byteLength > embedded_left_) {
        why = "is one of too many, which have more bytes than the file";
        return nullptr;
      }
      embedded_left_ -= v.byteLength;
    }
    return shared_bytes(place, [&] {
      const auto first = data.begin() + static_cast<std::ptrdiff_t>(v.byteOffset);
      return std::vector<unsigned char>(first, first + static_cast<std::ptrdiff_t>(v.byteLength));
    });
  }

  template <class Read>
  ImageBytes shared_bytes(const std::string& place, const Read& read) {
    const auto known = bytes_of_.find(place);
    if (known != bytes_of_.end()) return known->second;
    return bytes_of_[place] = std::make_shared<const std::vector<unsigned char>>(read());
  }

  // The attribute's accessor, if it has one element per vertex.
  const tinygltf::Accessor* accessor_of(const json& primitive, const std::string& attribute,
                                        std::size_t count, int& number) const {
    const json& value = json_member(json_member(primitive, "attributes"), attribute.c_str());
    if (!value.is_number_unsigned() || value.get<std::size_t>() >= model_.accessors.size()) return nullptr;
    number = value.get<int>();
    const tinygltf::Accessor& accessor = model_.accessors[static_cast<std::size_t>(number)];
    return accessor.count == count ? &accessor : nullptr;
  }

  std::vector<Eigen::Vector3d> colours_of(const json& primitive, std::size_t count) const {
    std::vector<Eigen::Vector3d> colours;
    int number = -1;
    const auto* accessor = accessor_of(primitive, "COLOR_0", count, number);
    if (accessor == nullptr) return colours;
    const std::size_t width = accessor->type == TINYGLTF_TYPE_VEC3   ? 3
                              : accessor->type == TINYGLTF_TYPE_VEC4 ? 4
                                                                     : 0;
    if (width == 0) return colours;
    const std::vector<double> values = accessor_numbers(path_, model_, number);
    for (std::size_t i = 0; i + width <= values.size(); i += width)
      colours.push_back(Eigen::Vector3d(values[i], values[i + 1], values[i + 2]).cwiseMax(0.0).cwiseMin(1.0));
    return colours;
  }

  const fs::path& path_;
  const json& document_;
  const tinygltf::Model& model_;
  std::map<std::size_t, std::int32_t> number_of_;  // file's texture index to ours
  std::map<std::tuple<std::size_t, TextureWrap, TextureWrap>, std::int32_t>
      number_of_wrapped_;                       // of an image
  std::map<std::string, ImageBytes> bytes_of_;  // by where they are
  ImagesBeside beside_;
  std::size_t embedded_left_;  // bytes of views that may still be copied
  Looks looks_;
};

}  // namespace

Looks read_looks(const fs::path& path, const Rig& rig) {
  const CheckedGltf checked = check_gltf(read_gltf_file(path));
  const auto model = decode_gltf(checked);
  return LooksReader(path, checked.plain, *model).run(rig);
}

}  // namespace fascicle::gltf
