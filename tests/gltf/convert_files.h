// FBX and Collada files as text for the tests of the converter, and what these compare of the characters
// read.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "host/rig/character.h"

namespace fascicle::tests {

using Keys = std::vector<std::pair<double, double>>;  // s, value

// A plate on a rotating node, as text: 40 lines make an FBX file.
struct Post {
  std::string properties = {};
  int up = 1, up_sign = 1, right = 0, right_sign = 1;
  double unit = 1.0;       // cm
  bool has_still = false;  // constant translation keys of the plate at 0 and 2 s
  std::string stack = {};  // properties of the clip
  Keys turns = {};         // degrees about Z, instead of 0 to 90 in a second with 30 frames
  Keys shapes = {};        // per cent of a blend shape that moves the plate's last vertex by 10 cm
};

// A property of three numbers, as FBX's text form has it.
std::string property(const std::string& name, double x, double y, double z);
// Properties of a clip that lasts from `start` to `stop`, s.
std::string span(double start, double stop);
// The post as FBX in text form.
std::string fbx_of(const Post& post);

// The identity, as Collada writes a matrix.
inline const std::string unit = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";

// A plate skinned to one joint below a node, as Blender would write it. The clip holds it still for 2 s.
std::string dae_of(const std::string& top, const std::string& joint);

// Replaces the first `part`; fails the test if there is none.
void replace(std::string& text, const std::string& part, const std::string& by);

// The bytes of a file.
std::string text_of(const std::filesystem::path& path);

bool has_joint(const rig::Character& character, const std::string& name);

// The skin's vertices, m, at a time of the clip, s; in the bind pose without a clip.
std::vector<Eigen::Vector3d> skinned(const rig::Character& character, const rig::Clip* clip, double time);

// The largest distance of a point to the nearest point of the other set: vertex orders and seams differ.
double both_ways(const std::vector<Eigen::Vector3d>& one, const std::vector<Eigen::Vector3d>& other);

// Single precision through three changes of unit: 1e-6 of 1.8 m, a few times over.
inline constexpr double file_rounding = 1e-5;

}  // namespace fascicle::tests
