// glTF JSON and its one buffer, under construction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace fascicle::convert {

struct Document {
  nlohmann::json json;
  std::string binary;
  // Nodes that stand in for a joint where it is bound again, by the joint and its number there.
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> stand_ins = {};
};

std::size_t add_view(Document& document, const void* data, std::size_t bytes);
// Rows of `width` (1, 2, 3, 4 or 16) numbers. `with_bounds`: writes minimum and maximum, which positions and
// times require.
std::size_t add_accessor(Document& document, std::span<const float> values, int width,
                         bool with_bounds = false);
std::size_t add_accessor(Document& document, std::span<const std::uint16_t> values, int width);
std::size_t add_indices(Document& document, std::span<const std::uint32_t> values);

// Encodes as GLB. Takes the document by value, to be moved in: the buffer is large.
std::string glb_text(Document document);

}  // namespace fascicle::convert
