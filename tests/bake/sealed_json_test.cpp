// Our own JSON files: any flipped bit is detected, and older files without a checksum are still read.
#include "host/bake/sealed_json.h"

#include <string>

#include <gtest/gtest.h>

#include "host/bake/manifest.h"
#include "tests/bake/fake_bakes.h"

namespace fascicle::tests {
namespace {

using bake::is_damaged;
using bake::sealed_text;
using scene::Json;

const Json object{
    {"version", bake::sealed_json_version}, {"name", "caf\xc3\xa9"}, {"values", {1e-7, -0.0, 12, nullptr}}};

TEST(SealedJson, IsWholeHoweverItIsIndented) {
  for (const int indent : {-1, 0, 2, 7}) {
    const Json read = Json::parse(sealed_text(object, indent));
    EXPECT_FALSE(is_damaged(read)) << indent;
    EXPECT_EQ(read.at("values"), object.at("values"));
    EXPECT_EQ(sealed_text(read, indent), sealed_text(object, indent)) << "sealed twice";
  }
}

TEST(SealedJson, BytesThatAreNoTextAreSealedAsTheyAreWritten) {
  EXPECT_FALSE(is_damaged(Json::parse(sealed_text({{"file", "caf\xe9"}}))));
}

TEST(SealedJson, ATurnedBitIsFound) {
  const std::string text = sealed_text(object, 1);
  for (std::size_t at = 0; at < text.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      std::string turned = text;
      turned[at] = static_cast<char>(static_cast<unsigned char>(turned[at]) ^ (1u << bit));
      const Json read = Json::parse(turned, nullptr, false);
      // A flipped bit can turn the e of an exponent into an E, which means the same.
      if (!read.is_object() || read == Json::parse(text)) continue;
      EXPECT_TRUE(is_damaged(read)) << turned;
    }
}

TEST(SealedJson, OnlyOlderFilesMayLackIt) {
  Json bare = object;
  EXPECT_TRUE(is_damaged(bare));
  bare["version"] = 1;
  EXPECT_FALSE(is_damaged(bare));
  bare.erase("version");
  EXPECT_FALSE(is_damaged(bare));
}

TEST(SealedJson, AManifestIsReadOnlyWhole) {
  const TemporaryFolder folder;
  fake_bake_into(options_for(folder / "out"), short_scene(3));
  const std::string path = folder / "out/manifest.json";
  const std::string whole = read_text(path);
  ASSERT_TRUE(bake::read_manifest(folder / "out"));
  for (std::size_t at = 0; at < whole.size(); at += 11) {
    std::string turned = whole;
    turned[at] = static_cast<char>(turned[at] ^ 0x10);
    write_text(path, turned);
    EXPECT_FALSE(bake::read_manifest(folder / "out")) << at << ": " << turned;
  }
  // Functions that update the manifest seal it again.
  write_text(path, whole);
  bake::set_status(folder / "out", bake::Status::failed, "a reason");
  EXPECT_EQ(bake::manifest_of(folder / "out").message, "a reason");
  bake::add_to_manifest(folder / "out", {"more"});
  EXPECT_EQ(bake::manifest_of(folder / "out").files.back(), "more");
}

}  // namespace
}  // namespace fascicle::tests
