// Which room includes which, read from the #include lines, and as a picture.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/house/source_tree.h"

namespace fascicle::tests {

// Of each room the rooms that its files include.
using RoomGraph = std::map<std::string, std::set<std::string>>;

// "host/bake", "cpu_reference/oracle", "gpu", ...; empty for what no other room includes: tests, bench, and
// what lies in no room.
std::string room_of(const std::string& path);

RoomGraph room_graph(const std::vector<Source>& sources);

// The rooms along one cycle, the first one again at the end; empty where every arrow leads down.
std::vector<std::string> cycle_in(const RoomGraph& graph);

// SVG: one room a line, above all that it includes, so that every arrow leads down. Arrows that follow from
// others are left out; the description holds all of them. The graph must have no cycle.
std::string picture_of(const RoomGraph& graph);

}  // namespace fascicle::tests
