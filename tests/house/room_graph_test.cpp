// The include graph of rooms has no cycle, and its picture is up to date.
#include "tests/house/room_graph.h"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

namespace fascicle::tests {
namespace {

std::string joined(const std::vector<std::string>& rooms) {
  std::string text;
  for (const std::string& room : rooms) text += (text.empty() ? "" : " includes ") + room;
  return text;
}

TEST(RoomGraph, HasNoCycle) {
  const RoomGraph graph = room_graph(read_sources(FASCICLE_SOURCE_DIR));
  ASSERT_GT(graph.size(), 15u) << "the sources were not found";
  EXPECT_EQ(joined(cycle_in(graph)), "");
}

TEST(RoomGraph, IsTheOneInThePicture) {
  const RoomGraph graph = room_graph(read_sources(FASCICLE_SOURCE_DIR));
  ASSERT_TRUE(cycle_in(graph).empty());
  std::ostringstream drawn;
  drawn << std::ifstream(std::string(FASCICLE_SOURCE_DIR) + "/docs/figures/rooms.svg", std::ios::binary)
               .rdbuf();
  EXPECT_TRUE(drawn.str() == picture_of(graph)) << "docs/figures/rooms.svg is out of date; run ./do rooms";
}

// The controls: an upward include is detected, direct or through other rooms, and a new arrow changes the
// picture.
TEST(RoomGraph, APlantedUpwardIncludeIsSeen) {
  std::vector<Source> sources = read_sources(FASCICLE_SOURCE_DIR);
  sources.push_back({"host/formats/planted.cpp", "#include \"host/bake/bake.h\"\n"});
  const std::vector<std::string> cycle = cycle_in(room_graph(sources));
  ASSERT_EQ(cycle.size(), 3u) << joined(cycle);
  EXPECT_EQ(cycle.front(), cycle.back());

  sources.back() = {"host/base/planted.h", "  #  include \"host/pipeline/errors.h\"\n"};
  EXPECT_GT(cycle_in(room_graph(sources)).size(), 2u);

  sources.back() = {"host/base/planted.h", "// #include \"host/pipeline/errors.h\"\n#include <vector>\n"};
  EXPECT_TRUE(cycle_in(room_graph(sources)).empty());
}

TEST(RoomGraph, ANewArrowChangesThePicture) {
  const RoomGraph graph{{"a", {"b"}}, {"b", {"c"}}, {"c", {}}};
  RoomGraph more = graph;
  more["a"].insert("c");  // an implied arrow
  EXPECT_NE(picture_of(graph), picture_of(more));
}

}  // namespace
}  // namespace fascicle::tests
