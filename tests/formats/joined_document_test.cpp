// Documents of several characters: the nodes of each below its own node.
#include "host/formats/joined_document.h"

#include <cstddef>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace fascicle::tests {
namespace {

using nlohmann::json;
using Nodes = std::vector<std::size_t>;

json three_nodes() {
  return {{"nodes", {{{"children", {1}}}, json::object(), json::object()}}};
}

TEST(ShownRoots, AreThoseOfTheShownScene) {
  json document = three_nodes();
  document["scenes"] = {{{"nodes", {2}}}, {{"nodes", {0, 2}}}};
  EXPECT_EQ(formats::shown_roots(document), Nodes{2});
  document["scene"] = 1;
  EXPECT_EQ(formats::shown_roots(document), (Nodes{0, 2}));
  document["scenes"] = {json::object(), json::object()};
  EXPECT_EQ(formats::shown_roots(document), Nodes{});
}

// glTF allows a file without scenes, and a character's reader shows all of its nodes.
TEST(ShownRoots, AreAllWithoutParentIfThereIsNoScene) {
  json document = three_nodes();
  EXPECT_EQ(formats::shown_roots(document), (Nodes{0, 2}));
  document["scenes"] = json::array();
  EXPECT_EQ(formats::shown_roots(document), (Nodes{0, 2}));
  EXPECT_EQ(formats::shown_roots(json::object()), Nodes{});
}

TEST(JoinedDocument, HasTheNodesOfAPartWithoutScenes) {
  gltf::GltfDocument both{.json = {{"scenes", {json::object()}}}, .binary = {}};
  json part = three_nodes();
  part["animations"] = {{{"name", "idle"}}};  // without samplers and channels
  formats::add_document(both, {.json = part, .binary = {}},
                        {.name = "man", .transform = json::object(), .parent = std::nullopt});
  EXPECT_EQ(both.json["nodes"][0]["children"], (json{1, 3}));
  EXPECT_EQ(both.json["nodes"][1]["children"], (json{2}));
  EXPECT_TRUE(both.json["animations"][0]["channels"].is_array());
}

}  // namespace
}  // namespace fascicle::tests
