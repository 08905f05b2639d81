// What is read from a manifest that lacks entries or has unexpected ones: those of older versions, or edited
// by hand.
#include "host/bake/manifest.h"

#include <gtest/gtest.h>

#include "host/bake/sealed_json.h"
#include "tests/bake/fake_bakes.h"

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
