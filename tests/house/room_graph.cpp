#include "tests/house/room_graph.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <regex>
#include <sstream>

namespace fascicle::tests {
namespace {

constexpr int box_width = 160, box_height = 26, row = 36, margin = 16;

// All rooms reachable from `from` by at least one arrow.
std::set<std::string> below(const RoomGraph& graph, const std::string& from) {
  std::set<std::string> found;
  std::vector<std::string> open{from};
  while (!open.empty()) {
    const std::string room = open.back();
    open.pop_back();
    for (const std::string& next : graph.at(room))
      if (found.insert(next).second) open.push_back(next);
  }
  return found;
}

// Transitive reduction: without arrows that are implied by longer paths.
RoomGraph without_shortcuts(const RoomGraph& graph) {
  RoomGraph left = graph;
  for (auto& [room, targets] : left)
    for (const std::string& over : graph.at(room))
      for (const std::string& further : below(graph, over)) targets.erase(further);
  return left;
}

// Topological order: each room before the rooms it includes, those with the most rooms below them first.
std::vector<std::string> from_top_to_bottom(const RoomGraph& graph) {
  std::map<std::string, int> levels;
  const std::function<int(const std::string&)> level_of = [&](const std::string& room) {
    if (const auto known = levels.find(room); known != levels.end()) return known->second;
    int level = 0;
    for (const std::string& target : graph.at(room)) level = std::max(level, level_of(target) + 1);
    return levels[room] = level;
  };
  std::vector<std::string> rooms;
  for (const auto& [room, targets] : graph) rooms.push_back(room);
  std::stable_sort(rooms.begin(), rooms.end(),
                   [&](const std::string& a, const std::string& b) { return level_of(a) > level_of(b); });
  return rooms;
}

}  // namespace

std::string room_of(const std::string& path) {
  static const std::regex room(R"(^(host/[^/]+|cpu_reference/[^/]+|include/fascicle|gpu|python|shaders)/.+)");
  std::smatch match;
  return std::regex_match(path, match, room) ? match[1].str() : std::string();
}

RoomGraph room_graph(const std::vector<Source>& sources) {
  static const std::regex include(R"re(^\s*#\s*include\s*["<]([^">]+)[">])re");
  RoomGraph graph;
  for (const Source& source : sources) {
    const std::string room = room_of(source.path);
    if (room.empty()) continue;
    std::set<std::string>& targets = graph[room];
    for (const std::string& line : lines_of(without_comments(source.text))) {
      std::smatch match;
      if (!std::regex_search(line, match, include)) continue;
      std::string header = match[1];
      if (header.starts_with("fascicle/")) header.insert(0, "include/");
      const std::string target = room_of(header);
      if (!target.empty() && target != room) targets.insert(target);
    }
  }
  // The picture also shows included rooms that have no files of their own in the graph.
  const RoomGraph found = graph;
  for (const auto& [room, targets] : found)
    for (const std::string& target : targets) graph[target];
  return graph;
}

std::vector<std::string> cycle_in(const RoomGraph& graph) {
  std::set<std::string> done;
  std::vector<std::string> way;
  const std::function<bool(const std::string&)> closes = [&](const std::string& room) {
    const bool is_open = std::find(way.begin(), way.end(), room) != way.end();
    way.push_back(room);
    if (is_open) {
      way.erase(way.begin(), std::find(way.begin(), way.end(), room));
      return true;
    }
    if (!done.contains(room))
      for (const std::string& target : graph.at(room))
        if (closes(target)) return true;
    way.pop_back();
    done.insert(room);
    return false;
  };
  for (const auto& [room, targets] : graph)
    if (closes(room)) return way;
  return {};
}

std::string picture_of(const RoomGraph& graph) {
  const std::vector<std::string> rooms = from_top_to_bottom(graph);
  std::map<std::string, int> middle;
  for (std::size_t k = 0; k < rooms.size(); ++k)
    middle[rooms[k]] = margin + static_cast<int>(k) * row + box_height / 2;
  const int right = margin + box_width, height = 2 * margin + static_cast<int>(rooms.size()) * row;
  const int width = right + height / 2;
  std::ostringstream svg;
  svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << width << ' ' << height << "\" width=\""
      << width << "\" height=\"" << height << "\" font-family=\"sans-serif\" font-size=\"13\">\n"
      << "<title>Which room includes which</title>\n<desc>\n";
  for (const std::string& room : rooms) {
    svg << room << ':';
    for (const std::string& target : graph.at(room)) svg << ' ' << target;
    svg << '\n';
  }
  svg << "</desc>\n<rect width=\"" << width << "\" height=\"" << height << "\" fill=\"#fff\"/>\n"
      << "<defs><marker id=\"head\" viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" markerWidth=\"7\" "
         "markerHeight=\"7\" "
         "orient=\"auto\"><path d=\"M0 0L8 4L0 8z\" fill=\"#6b7684\"/></marker></defs>\n"
      << "<g fill=\"none\" stroke=\"#6b7684\" stroke-width=\"1.2\" marker-end=\"url(#head)\">\n";
  for (const auto& [room, targets] : without_shortcuts(graph))
    for (const std::string& target : targets) {
      const int from = middle.at(room) + 5, to = middle.at(target) - 5;
      const int out = right + 12 + (to - from) * 3 / 5;
      svg << "<path d=\"M" << right << ' ' << from << 'C' << out << ' ' << from << ' ' << out << ' ' << to
          << ' ' << right << ' ' << to << "\"/>\n";
    }
  svg << "</g>\n";
  for (const std::string& room : rooms)
    svg << "<rect x=\"" << margin << "\" y=\"" << middle.at(room) - box_height / 2 << "\" width=\""
        << box_width << "\" height=\"" << box_height
        << "\" rx=\"4\" fill=\"#eef2f7\" stroke=\"#44546a\"/><text x=\"" << margin + box_width / 2
        << "\" y=\"" << middle.at(room) + 5 << "\" text-anchor=\"middle\" fill=\"#1c2530\">" << room
        << "</text>\n";
  svg << "</svg>\n";
  return svg.str();
}

}  // namespace fascicle::tests
