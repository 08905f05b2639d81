// The model file next to the frames: it survives a round trip, and nothing else is accepted in its place.
#include "host/bake/model_file.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#define XXH_INLINE_ALL
#include <gtest/gtest.h>
#include <unistd.h>
#include <xxhash.h>

#include "host/bake/bake.h"
#include "host/bake/identity.h"
#include "tests/bake/fake_solver.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

class ModelFile : public testing::Test {
 protected:
  void TearDown() override { fs::remove(path_); }
  void write(const std::string& bytes) { std::ofstream(path_, std::ios::binary) << bytes; }
  // Checks that the changed model_ has another hash and survives a round trip. Returns the model as read.
  model::Model written_and_read() {
    const std::string bytes = bake::encode_model(model_);
    EXPECT_EQ(bake::encoded_bytes(model_), bytes.size());
    EXPECT_NE(bake::model_hash(model_), hash_);
    hash_ = bake::model_hash(model_);
    write(bytes);
    model::Model read = bake::read_model_file(path_, hash_);
    EXPECT_EQ(bake::encode_model(read), bytes);
    return read;
  }
  // The error message; empty if the file was read.
  std::string refusal(const std::string& bytes) {
    write(bytes);
    try {
      bake::read_model_file(path_, hash_);
    } catch (const bake::BakeError& error) {
      return error.what();
    }
    return "";
  }
  // With the correct checksum for the preceding bytes.
  static std::string sealed(std::string bytes) {
    const std::uint64_t checksum = XXH3_64bits(bytes.data(), bytes.size() - 8);
    std::memcpy(bytes.data() + bytes.size() - 8, &checksum, 8);
    return bytes;
  }

  fs::path path_ = fs::temp_directory_path() / ("fascicle-model-" + std::to_string(getpid()));
  model::Model model_ = two_tetrahedra();
  std::uint64_t hash_ = bake::model_hash(model_);
  std::string bytes_ = bake::encode_model(model_);
};

TEST_F(ModelFile, ComesBackAsItWas) {
  write(bytes_);
  const model::Model read = bake::read_model_file(path_, hash_);
  EXPECT_EQ(bake::encode_model(read), bytes_);
  EXPECT_EQ(bake::model_hash(read), hash_);
  EXPECT_EQ(read.rest, model_.rest);
  EXPECT_EQ(read.layers.size(), model_.layers.size());
  EXPECT_EQ(read.layers[0].name, model_.layers[0].name);
  EXPECT_EQ(bake::encoded_bytes(model_), bytes_.size());
}

// Optional arrays are in the file and in the hash only of models that have them.
TEST_F(ModelFile, AVolumeTermIsInTheFileOfThoseThatHaveOne) {
  EXPECT_EQ(bytes_.find("region_volume"), std::string::npos);
  model_.volume_gain.assign(model_.vertex_count, 2.0f);
  model_.region_volume.assign(3 * std::size_t{model_.vertex_count}, 1.5f);
  const model::Model read = written_and_read();
  EXPECT_EQ(read.volume_gain, model_.volume_gain);
  EXPECT_EQ(read.region_volume, model_.region_volume);
}

TEST_F(ModelFile, TiesAreInTheFileOfThoseThatHaveThem) {
  EXPECT_EQ(bytes_.find("tie_index"), std::string::npos);
  model_.tie = {{0, 1, 2, 3, 1.0f, 1.0f, 0.5f, 0.125f}};
  model_.tie_offset.assign(std::size_t{model_.vertex_count} + 1, 1);
  model_.tie_offset[0] = 0;
  model_.tie_index = {0};
  model_.tie_coefficient = {0.375f};
  const model::Model read = written_and_read();
  EXPECT_EQ(read.tie.size(), 1u);
  EXPECT_EQ(read.tie_coefficient, model_.tie_coefficient);
}

TEST_F(ModelFile, LimitsAreInTheFileOfThoseThatHaveThem) {
  EXPECT_EQ(bytes_.find("mobility"), std::string::npos);
  // Limits need the implicit integrator.
  model_.youngs_modulus.assign(model_.vertex_count, 1e4);
  model_.stiffness.assign(model_.vertex_count, 1.0);
  model_.carried.assign(model_.has_skeleton() ? model_.vertex_count : 0, 0.0f);
  model_.limit = {{0, 1, 2, 3, 4.0f, 0.25f, 0.125f, 0.5f}};
  for (std::uint32_t i = 0; i <= model_.vertex_count; ++i) model_.limit_offset.push_back(std::min(i, 4u));
  model_.limit_entry = {0, 1, 2, 3};
  for (std::uint32_t i = 0; i < model_.vertex_count; ++i)
    model_.mobility.push_back(model_.is_kinematic(i) ? 0.0f : 1.5f);
  const model::Model read = written_and_read();
  ASSERT_EQ(read.limit.size(), 1u);
  EXPECT_EQ(read.limit[0].least_square, 0.5f);
  EXPECT_EQ(read.limit_entry, model_.limit_entry);
  EXPECT_EQ(read.mobility, model_.mobility);
}

TEST_F(ModelFile, WhatIsCutShortOrChangedIsRefused) {
  for (std::size_t length = 0; length < bytes_.size(); length += 1 + length / 7)
    EXPECT_NE(refusal(bytes_.substr(0, length)), "") << length;
  for (std::size_t k = 0; k < bytes_.size(); k += 1 + k / 7) {
    std::string changed = bytes_;
    changed[k] = static_cast<char>(changed[k] ^ 0x10);
    EXPECT_NE(refusal(changed), "") << k;
  }
  EXPECT_EQ(refusal(bytes_), "");
}

// Invalid files with a valid checksum: other fields, counts beyond the end, indices out of range.
TEST_F(ModelFile, WhatLiesIsRefused) {
  std::string renamed = bytes_;
  renamed.replace(renamed.find("source_vertex"), 6, "sauces");
  EXPECT_NE(refusal(sealed(renamed)).find("another version"), std::string::npos) << refusal(sealed(renamed));
  std::string endless = bytes_;
  const std::size_t count = endless.find("tetrahedron") + std::strlen("tetrahedron") + 4;
  endless[count + 6] = 0x7f;
  EXPECT_NE(refusal(sealed(endless)).find("ends too soon"), std::string::npos) << refusal(sealed(endless));
  std::string astray = bytes_;
  astray[count + 8 + 3] = 0x7f;  // the highest byte of the first corner
  EXPECT_NE(refusal(sealed(astray)).find("the model is invalid"), std::string::npos)
      << refusal(sealed(astray));
  model::Model other = model_;
  other.alpha[0] += 0.25f;
  EXPECT_NE(refusal(bake::encode_model(other)).find("baked with another model"), std::string::npos);
}

// A probe takes at least 56 bytes: two heads of 16, the names of its fields and no vertices. 60 MB of zeros
// once became 60 million probes, of 3.4 GB.
TEST_F(ModelFile, AListLongerThanItsFileIsRefusedBeforeItIsMade) {
  const std::string before_count = bytes_.substr(0, bytes_.rfind("probes") + std::strlen("probes") + 4);
  const auto refusal_of = [&](std::uint64_t probes) {
    std::string bytes = before_count;
    bytes.append(reinterpret_cast<const char*>(&probes), sizeof probes);
    bytes.append(100 * 56 + 8, '\0');
    return refusal(sealed(bytes));
  };
  EXPECT_NE(refusal_of(101).find("ends too soon"), std::string::npos) << refusal_of(101);
  // The control: as many as there is room for are read, and refused for their names.
  EXPECT_NE(refusal_of(100).find("at probe.name"), std::string::npos) << refusal_of(100);
}

}  // namespace
}  // namespace fascicle::tests
