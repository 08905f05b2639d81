// Changes to GLB files.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "tests/cli/program.h"

namespace fascicle::tests {

// Changes the JSON of a GLB file. `more`: bytes that are added first, as its last buffer view.
template <class Change>
void change_glb(const std::filesystem::path& path, Change change, const std::string& more = {}) {
  const std::string bytes = read_text(path);
  const auto number_at = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof(value));
    return value;
  };
  const std::uint32_t length = number_at(12);
  nlohmann::json document = nlohmann::json::parse(bytes.substr(20, length));
  std::string rest = bytes.substr(20 + length);
  if (!more.empty()) {
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", rest.size() - 8}, {"byteLength", more.size()}});
    rest += more;
    rest.resize((rest.size() + 3) / 4 * 4);
    const auto binary = static_cast<std::uint32_t>(rest.size() - 8);
    std::memcpy(rest.data(), &binary, sizeof(binary));
    document["buffers"][0]["byteLength"] = binary;
  }
  change(document);
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string out = bytes.substr(0, 8);
  const auto append_number = [&out](std::size_t value) {
    const auto number = static_cast<std::uint32_t>(value);
    out.append(reinterpret_cast<const char*>(&number), sizeof(number));
  };
  append_number(20 + text.size() + rest.size());
  append_number(text.size());
  out += bytes.substr(16, 4) + text + rest;
  write_text(path, out);
}

}  // namespace fascicle::tests
