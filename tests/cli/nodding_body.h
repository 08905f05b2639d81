// A small character for tests, written by them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/page/base64.h"

namespace fascicle::tests {

// A glTF file of a body of revolution: rings x spokes vertices and two poles, 1.7 m high. The upper half nods
// and turns while the whole body moves up and down and along x, with `speed`, m/s. `floor`: half the side of
// a square of 21 x 21 vertices 2 cm below it that stays where it is, m; 0: none.
inline std::string nodding_body(std::size_t rings, std::size_t spokes, double floor = 0.0,
                                double speed = 0.0) {
  std::vector<float> positions, weights, times, turns, rises;
  std::vector<std::uint16_t> joints;
  std::vector<std::uint32_t> triangles;
  const auto add = [&](double radius, double angle, double height) {
    for (const double value : {radius * std::cos(angle), height, radius * std::sin(angle)})
      positions.push_back(static_cast<float>(value));
    const double upper = std::clamp((height - 0.7) / 0.3, 0.0, 1.0);
    for (const double weight : {1.0 - upper, upper, 0.0, 0.0}) weights.push_back(static_cast<float>(weight));
    joints.insert(joints.end(), {0, 1, 0, 0});
  };
  for (std::size_t ring = 0; ring < rings; ++ring) {
    const double share = (static_cast<double>(ring) + 0.5) / static_cast<double>(rings);
    const double radius =
        0.28 * std::sqrt(std::sin(std::numbers::pi * share)) * (1.0 + 0.15 * std::sin(14.0 * share));
    for (std::size_t spoke = 0; spoke < spokes; ++spoke)
      add(radius, 2.0 * std::numbers::pi * static_cast<double>(spoke) / static_cast<double>(spokes),
          1.7 * share);
  }
  add(0.0, 0.0, 0.0);
  add(0.0, 0.0, 1.7);
  const auto at = [&](std::size_t ring, std::size_t spoke) {
    return static_cast<std::uint32_t>(ring * spokes + spoke % spokes);
  };
  const auto bottom = static_cast<std::uint32_t>(rings * spokes), top = bottom + 1;
  for (std::size_t spoke = 0; spoke < spokes; ++spoke) {
    for (std::size_t ring = 0; ring + 1 < rings; ++ring)
      for (const std::uint32_t corner : {at(ring, spoke), at(ring + 1, spoke), at(ring, spoke + 1),
                                         at(ring, spoke + 1), at(ring + 1, spoke), at(ring + 1, spoke + 1)})
        triangles.push_back(corner);
    for (const std::uint32_t corner :
         {bottom, at(0, spoke), at(0, spoke + 1), top, at(rings - 1, spoke + 1), at(rings - 1, spoke)})
      triangles.push_back(corner);
  }
  if (floor > 0.0) {
    constexpr std::uint32_t across = 20;
    const auto first = static_cast<std::uint32_t>(positions.size() / 3);
    for (std::uint32_t x = 0; x <= across; ++x)
      for (std::uint32_t z = 0; z <= across; ++z) {
        for (const double value : {floor * (2.0 * x / across - 1.0), -0.02, floor * (2.0 * z / across - 1.0)})
          positions.push_back(static_cast<float>(value));
        weights.insert(weights.end(), {1.0f, 0.0f, 0.0f, 0.0f});
        joints.insert(joints.end(), {2, 0, 0, 0});
        if (x == across || z == across) continue;
        const std::uint32_t corner = first + x * (across + 1) + z, next = corner + across + 1;
        triangles.insert(triangles.end(), {corner, corner + 1, next + 1, corner, next + 1, next});
      }
  }
  for (int k = 0; k <= 30; ++k) {
    const double time = 0.05 * k, half = 0.35 * std::sin(7.0 * time), spin = 0.3 * std::sin(4.0 * time);
    times.push_back(static_cast<float>(time));
    // A rotation about y, then one about z.
    for (const double value : {std::sin(half) * std::sin(spin), std::cos(half) * std::sin(spin),
                               std::sin(half) * std::cos(spin), std::cos(half) * std::cos(spin)})
      turns.push_back(static_cast<float>(value));
    for (const double value : {speed * time, 0.12 * std::sin(6.0 * time), 0.0})
      rises.push_back(static_cast<float>(value));
  }
  const std::vector<float> binds{1, 0, 0, 0, 0, 1,      0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0,
                                 0, 0, 1, 0, 0, -0.85f, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  nlohmann::json document{{"asset", {{"version", "2.0"}}}};
  std::string bytes;
  const auto put = [&](const auto& values, int component, const char* type, std::size_t width) {
    const std::size_t offset = bytes.size(), size = values.size() * sizeof values[0];
    bytes.append(reinterpret_cast<const char*>(values.data()), size);
    document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
    document["accessors"].push_back({{"bufferView", document["bufferViews"].size() - 1},
                                     {"componentType", component},
                                     {"type", type},
                                     {"count", values.size() / width}});
    return document["accessors"].size() - 1;
  };
  const auto position = put(positions, 5126, "VEC3", 3), weight = put(weights, 5126, "VEC4", 4),
             joint = put(joints, 5123, "VEC4", 4), index = put(triangles, 5125, "SCALAR", 1),
             bind = put(binds, 5126, "MAT4", 16), time = put(times, 5126, "SCALAR", 1),
             turn = put(turns, 5126, "VEC4", 4), rise = put(rises, 5126, "VEC3", 3);
  document["accessors"][position]["min"] = {-std::max(floor, 1.0), -0.02, -std::max(floor, 1.0)};
  document["accessors"][position]["max"] = {std::max(floor, 1.0), 1.7, std::max(floor, 1.0)};
  document["accessors"][time]["min"] = {0};
  document["accessors"][time]["max"] = {1.5};
  document["meshes"] = {
      {{"primitives",
        {{{"attributes", {{"POSITION", position}, {"WEIGHTS_0", weight}, {"JOINTS_0", joint}}},
          {"indices", index}}}}}};
  document["nodes"] = {{{"name", "hips"}, {"children", {1}}},
                       {{"name", "chest"}, {"translation", {0, 0.85, 0}}},
                       {{"mesh", 0}, {"skin", 0}},
                       {{"name", "ground"}}};
  document["skins"] = {{{"joints", {0, 1, 3}}, {"inverseBindMatrices", bind}}};
  document["scenes"] = {{{"nodes", {0, 2, 3}}}};
  document["scene"] = 0;
  document["animations"] = {
      {{"name", "nod"},
       {"samplers", {{{"input", time}, {"output", turn}}, {{"input", time}, {"output", rise}}}},
       {"channels",
        {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "rotation"}}}},
         {{"sampler", 1}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
  document["buffers"] = {
      {{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + page::base64(bytes)}}};
  return document.dump();
}

}  // namespace fascicle::tests
