// What the tables of keys are made of.
#pragma once

#include <Eigen/Core>

#include "host/scene/scene.h"
#include "host/scene/scene_table.h"

namespace fascicle::scene {

inline constexpr double farthest = 1e6;  // metres; squares and cubes of it are far from float's end

constexpr Range between(double minimum, double maximum) {
  return {minimum, maximum, false};
}
constexpr Range positive(double maximum) {
  return {0.0, maximum, true};
}
inline constexpr Range coordinate = between(-farthest, farthest);

inline nlohmann::ordered_json json_of(const Vector3d& v) {
  return nlohmann::ordered_json::array({v.x(), v.y(), v.z()});
}

inline Key point(const char* name, const char* doc) {
  return {.name = name, .type = KeyType::vector, .doc = doc, .range = coordinate, .required = true};
}

inline Key where_key(const Table& shape, bool required, const char* doc) {
  return {.name = "where", .type = KeyType::tables, .doc = doc, .required = required, .table = &shape};
}

// The shapes of `where`.
const Table& shape_table();

}  // namespace fascicle::scene
