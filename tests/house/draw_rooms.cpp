// Draws the graph of rooms: draw_rooms REPOSITORY PICTURE.svg. Fails if the graph has a cycle.
#include <cstdio>
#include <fstream>

#include "tests/house/room_graph.h"

int main(int count, char** arguments) {
  if (count != 3) {
    std::fputs("usage: draw_rooms REPOSITORY PICTURE.svg\n", stderr);
    return 2;
  }
  using namespace fascicle::tests;
  const RoomGraph graph = room_graph(read_sources(arguments[1]));
  if (const auto cycle = cycle_in(graph); !cycle.empty()) {
    std::fputs("rooms include each other in a ring:", stderr);
    for (const std::string& room : cycle) std::fprintf(stderr, " %s", room.c_str());
    std::fputs("\n", stderr);
    return 1;
  }
  std::ofstream picture(arguments[2], std::ios::binary);
  picture << picture_of(graph);
  picture.close();
  if (!picture) {
    std::perror(arguments[2]);
    return 1;
  }
  return 0;
}
