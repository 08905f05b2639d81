// The graph of which room includes which, from #include lines, and a picture of it.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/house/source_tree.h"

namespace fascicle::tests {

// For each room, the rooms that its files include.
using RoomGraph = std::map<std::string, std::set<std::string>>;

// "host/bake", "cpu_reference/oracle", "gpu", ...; empty for what no room includes: tests, bench, and files
// outside the rooms.
std::string room_of(const std::string& path);

RoomGraph room_graph(const std::vector<Source>& sources);

// The rooms of a cycle, the first one repeated at the end; empty if there is no cycle.
std::vector<std::string> cycle_in(const RoomGraph& graph);

// An SVG with one room per line, above all rooms that it includes, so that every arrow points down. Implied
// arrows are left out of the picture; its description lists all. The graph must have no cycle.
std::string picture_of(const RoomGraph& graph);

}  // namespace fascicle::tests
