// What is read from a manifest that lacks entries or has unexpected ones: those of older versions, or edited
// by hand.
#include "host/bake/manifest.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/bake/sealed_json.h"
#include "tests/bake/fake_bakes.h"
#include "tests/drive/bending_bar.h"

namespace fascicle::tests {
namespace {

using scene::Json;

// The timings that are read if the manifest's entry is this; without an entry for null.
bake::Timings timings_read_from(const Json& entry) {
  const TemporaryFolder folder;
  fake_bake_into(options_for(folder / "out"), short_scene(2));
  Json manifest = manifest_in(folder / "out");
  manifest.erase("timings");
  if (!entry.is_null()) manifest["timings"] = entry;
  write_text(folder / "out/manifest.json", bake::sealed_text(manifest, 1));
  return bake::manifest_of(folder / "out").timings;
}

bool has_name(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

TEST(Manifest, ListsMaterialsAndTexturesForCharactersOnly) {
  BendingBar bar = bending_bar(0.2);
  bar.model.surface_vertex = {0, 1, 2, 3, 1, 2, 3, 4, 2, 3, 4, 5};
  bar.model.surface_weight = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  bar.model.surface_triangle = {0, 1, 2};
  const std::vector<std::string> of_character = bake::file_names(bar.model, {"obj"});
  const std::vector<std::string> of_body = bake::file_names(two_tetrahedra(), {"obj"});
  for (const char* name : {"manifest.json", "checkpoint", "model.fascicle", "rest.obj", "frames.fascicle"}) {
    EXPECT_TRUE(has_name(of_character, name)) << name;
    EXPECT_TRUE(has_name(of_body, name)) << name;
  }
  for (const char* name : {"character.glb", "rest.mtl", "textures/"}) {
    EXPECT_TRUE(has_name(of_character, name)) << name;
    EXPECT_FALSE(has_name(of_body, name)) << name;
  }
}

TEST(Manifest, TimingsAreReadAsWritten) {
  const bake::Timings read = timings_read_from(
      {{"solver_seconds", 1.5}, {"writing_seconds", 0.25}, {"total_seconds", 2.0}, {"runs", 3}});
  EXPECT_EQ(read.solver, 1.5);
  EXPECT_EQ(read.writing, 0.25);
  EXPECT_EQ(read.total, 2.0);
  EXPECT_EQ(read.runs, 3u);
}

TEST(Manifest, MissingTimingsAreOneRunThatTookNoTime) {
  for (const Json& entry :
       {Json(), Json::object(), Json("soon"), Json{{"total_seconds", "soon"}, {"runs", -3}}}) {
    const bake::Timings read = timings_read_from(entry);
    EXPECT_EQ(read.solver, 0.0) << entry;
    EXPECT_EQ(read.writing, 0.0) << entry;
    EXPECT_EQ(read.total, 0.0) << entry;
    EXPECT_EQ(read.runs, 1u) << entry;
  }
}

}  // namespace
}  // namespace fascicle::tests
