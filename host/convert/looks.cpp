#include "host/convert/looks.h"

#include <algorithm>
#include <map>
#include <string_view>

#include <assimp/material.h>

namespace fascicle::convert {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const char* mime_of(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG")) return "image/png";
  if (bytes.starts_with("\xff\xd8\xff")) return "image/jpeg";
  return nullptr;
}

// Percent-encodes characters that a URI does not allow.
std::string in_uri(const std::string& path) {
  constexpr std::string_view plain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.~/";
  constexpr std::string_view digits = "0123456789ABCDEF";
  std::string result;
  for (const char c : path) {
    if (plain.find(c) != std::string_view::npos) {
      result += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    result += '%';
    result += digits[byte >> 4];
    result += digits[byte & 15];
  }
  return result;
}

// Files name textures by their paths on the machine where they were made.
std::string found_beside(const fs::path& source, std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  const fs::path given(name);
  const fs::path plain = given.filename();
  fs::path packed = source.filename();
  packed.replace_extension(".fbm");
  std::vector<fs::path> places{plain, fs::path("textures") / plain, packed / plain};
  const bool leads_out =
      given.is_absolute() || std::find(given.begin(), given.end(), fs::path("..")) != given.end();
  if (!leads_out) places.insert(places.begin(), given);
  std::error_code ignored;
  for (const fs::path& place : places)
    if (fs::is_regular_file(source.parent_path() / place, ignored)) return place.generic_string();
  return plain.generic_string();
}

class Images {
 public:
  Images(const aiScene& scene, const fs::path& source, Document& document, std::vector<std::string>& notes)
      : scene_(scene), source_(source), document_(document), notes_(notes) {}

  // The glTF texture's index, or -1.
  int texture(const std::string& name) {
    const auto [at, is_new] = texture_.emplace(name, -1);
    if (!is_new) return at->second;
    json image = {{"name", fs::path(name).filename().string()}};
    if (const aiTexture* held = scene_.GetEmbeddedTexture(name.c_str()); held != nullptr) {
      // Height 0: an encoded image of mWidth bytes.
      const std::string_view bytes =
          held->mHeight == 0 && held->pcData != nullptr
              ? std::string_view(reinterpret_cast<const char*>(held->pcData), held->mWidth)
              : std::string_view();
      const char* mime = mime_of(bytes);
      if (mime == nullptr) {
        notes_.push_back("its texture `" + name + "` is neither PNG nor JPEG; it is left out");
        return -1;
      }
      image["mimeType"] = mime;
      image["bufferView"] = add_view(document_, bytes.data(), bytes.size());
    } else {
      image["uri"] = in_uri(found_beside(source_, name));
      if (image["uri"].get_ref<const std::string&>().empty()) return -1;
    }
    document_.json["images"].push_back(image);
    document_.json["textures"].push_back({{"source", document_.json["images"].size() - 1}});
    at->second = static_cast<int>(document_.json["textures"].size()) - 1;
    return at->second;
  }

 private:
  const aiScene& scene_;
  const fs::path& source_;
  Document& document_;
  std::vector<std::string>& notes_;
  std::map<std::string, int> texture_;
};

bool is_colour(const aiColor4D& c) {
  for (const ai_real value : {c.r, c.g, c.b, c.a})
    if (!(value >= 0.0f && value <= 1.0f)) return false;
  return true;
}

}  // namespace

void add_materials(const aiScene& scene, const fs::path& source, Document& document,
                   std::vector<std::string>& notes) {
  Images images(scene, source, document, notes);
  for (unsigned m = 0; m < scene.mNumMaterials; ++m) {
    const aiMaterial& material = *scene.mMaterials[m];
    json pbr = {{"metallicFactor", 0}};
    aiString text;
    int texture = -1;
    if (material.GetTexture(aiTextureType_DIFFUSE, 0, &text) == aiReturn_SUCCESS ||
        material.GetTexture(aiTextureType_BASE_COLOR, 0, &text) == aiReturn_SUCCESS) {
      texture = images.texture(text.C_Str());
    }
    aiColor4D colour(1.0f, 1.0f, 1.0f, 1.0f);
    if (texture >= 0) {
      // Replaces the colour.
      pbr["baseColorTexture"] = {{"index", texture}};
    } else if (material.Get(AI_MATKEY_COLOR_DIFFUSE, colour) == aiReturn_SUCCESS && is_colour(colour)) {
      pbr["baseColorFactor"] = {colour.r, colour.g, colour.b, 1.0};
    }
    json made = {{"pbrMetallicRoughness", pbr}, {"doubleSided", true}};
    if (material.Get(AI_MATKEY_NAME, text) == aiReturn_SUCCESS) made["name"] = text.C_Str();
    document.json["materials"].push_back(made);
  }
}

}  // namespace fascicle::convert
