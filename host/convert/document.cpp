#include "host/convert/document.h"

#include <algorithm>

namespace fascicle::convert {
namespace {

using nlohmann::json;

const char* type_name(int width) {
  switch (width) {
    case 1:
      return "SCALAR";
    case 2:
      return "VEC2";
    case 3:
      return "VEC3";
    case 16:
      return "MAT4";
    default:
      return "VEC4";
  }
}

enum ComponentType : int { unsigned_short = 5123, unsigned_int = 5125, single = 5126 };

template <typename T>
json& accessor(Document& document, std::span<const T> values, int width, int component) {
  const std::size_t view = add_view(document, values.data(), values.size_bytes());
  json& accessors = document.json["accessors"];
  accessors.push_back({{"bufferView", view},
                       {"componentType", component},
                       {"count", values.size() / static_cast<std::size_t>(width)},
                       {"type", type_name(width)}});
  return accessors.back();
}

void append_word(std::string& text, std::size_t value) {
  for (int shift = 0; shift < 32; shift += 8) text += static_cast<char>(value >> shift & 255);
}

}  // namespace

std::size_t add_view(Document& document, const void* data, std::size_t bytes) {
  document.binary.resize((document.binary.size() + 3) / 4 * 4);
  document.json["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", document.binary.size()}, {"byteLength", bytes}});
  document.binary.append(static_cast<const char*>(data), bytes);
  return document.json["bufferViews"].size() - 1;
}

std::size_t add_accessor(Document& document, std::span<const float> values, int width, bool with_bounds) {
  json& made = accessor(document, values, width, single);
  if (with_bounds && !values.empty()) {
    const auto columns = static_cast<std::size_t>(width);
    std::vector<float> low(values.begin(), values.begin() + width), high = low;
    for (std::size_t i = 0; i < values.size(); ++i) {
      low[i % columns] = std::min(low[i % columns], values[i]);
      high[i % columns] = std::max(high[i % columns], values[i]);
    }
    made["min"] = low;
    made["max"] = high;
  }
  return document.json["accessors"].size() - 1;
}

std::size_t add_accessor(Document& document, std::span<const std::uint16_t> values, int width) {
  accessor(document, values, width, unsigned_short);
  return document.json["accessors"].size() - 1;
}

std::size_t add_indices(Document& document, std::span<const std::uint32_t> values) {
  accessor(document, values, 1, unsigned_int);
  return document.json["accessors"].size() - 1;
}

std::string glb_text(Document document) {
  constexpr std::size_t header = 12, chunk_header = 8, version = 2;
  constexpr std::size_t magic = 0x46546C67, chunk_json = 0x4E4F534A, chunk_binary = 0x004E4942;
  document.binary.resize((document.binary.size() + 3) / 4 * 4);
  if (!document.binary.empty())
    document.json["buffers"] = json::array({{{"byteLength", document.binary.size()}}});
  // Names in files may be invalid UTF-8.
  std::string text = document.json.dump(-1, ' ', false, json::error_handler_t::replace);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string out;
  append_word(out, magic);
  append_word(out, version);
  append_word(out, header + chunk_header + text.size() +
                       (document.binary.empty() ? 0 : chunk_header + document.binary.size()));
  append_word(out, text.size());
  append_word(out, chunk_json);
  out += text;
  if (document.binary.empty()) return out;
  append_word(out, document.binary.size());
  append_word(out, chunk_binary);
  return out + document.binary;
}

}  // namespace fascicle::convert
