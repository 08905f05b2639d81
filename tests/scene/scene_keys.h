// The samples line by line, and the fixture of the tests of scene files' keys.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/scene/scene_file.h"
#include "tests/gltf/gltf_builder.h"
#include "tests/scene/scene_samples.h"
#include "tests/support/assets.h"

namespace fascicle::tests {

// One line of a sample, and its key.
struct Line {
  std::size_t number = 0;  // from 0
  std::string text;
  std::vector<std::string> section;  // parts of the header that applies, or of this header
  std::string key;                   // empty for a header
};

struct Sample {
  std::vector<Line> lines;

  std::string text_with(std::size_t number, const std::string& replacement) const {
    std::string text;
    for (const Line& line : lines) text += (line.number == number ? replacement : line.text) + "\n";
    return text;
  }
};

inline std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, '.');) parts.push_back(part);
  return parts;
}

inline Sample sample_of(const std::string& text) {
  Sample sample;
  std::istringstream in(text);
  std::vector<std::string> section;
  for (std::string line; std::getline(in, line);) {
    Line entry{sample.lines.size(), line, {}, {}};
    if (line.starts_with('[')) section = split(line.substr(1, line.size() - 2));
    if (const std::size_t equals = line.find(" = "); equals != std::string::npos)
      entry.key = line.substr(0, equals);
    if (line.starts_with('[') || !entry.key.empty()) entry.section = section;
    sample.lines.push_back(entry);
  }
  return sample;
}

// Puts the files that the mesh and character samples name into a temporary folder.
class SceneKeys : public ::testing::Test {
 protected:
  SceneKeys() {
    write_tetrahedron_off(folder_.path() / "tetrahedron.off");
    write_arm_paint(folder_.path() / "arm.paint.json");
    samples_.push_back(sample_of(bar_sample()));
    samples_.push_back(sample_of(mesh_sample()));
    if (std::filesystem::exists(character_))
      std::filesystem::copy(character_, folder_.path() / character_.filename());
    samples_.push_back(sample_of(character_sample()));
    samples_.push_back(sample_of(made_sample()));
    samples_.push_back(sample_of(made_surface_sample()));
    samples_.push_back(sample_of(implicit_sample()));
    samples_.push_back(sample_of(characters_sample()));
  }

  scene::Scene parse(const std::string& text, const scene::SceneOverrides& overrides = {}) const {
    return scene::parse_scene({"sample", "sample.toml", text, folder_.path()}, overrides);
  }

  // The described scene, or the error.
  std::string outcome(const std::string& text) const {
    try {
      return describe(parse(text));
    } catch (const scene::SceneError& error) {
      return error.what();
    }
  }

  // The message of the SceneError that `text` causes.
  std::string refusal(const std::string& text, const scene::SceneOverrides& overrides = {}) const {
    try {
      parse(text, overrides);
    } catch (const scene::SceneError& error) {
      return error.what();
    }
    return "no error";
  }

  void for_each_line(const std::function<void(const Sample&, const Line&)>& use) const {
    for (const Sample& sample : samples_) {
      for (const Line& line : sample.lines) use(sample, line);
    }
  }

  TemporaryFolder folder_;
  std::vector<Sample> samples_;
  std::filesystem::path character_ = asset("CesiumMan.glb");
};

}  // namespace fascicle::tests
