// What is read from a manifest that lacks entries or has unexpected ones: those of older versions, or edited
// by hand.
#include "host/bake/manifest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include "host/bake/sealed_json.h"
#include "tests/bake/fake_bakes.h"
#include "tests/drive/bending_bar.h"

namespace fascicle::tests {
namespace {

using bake::BakeOptions;
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

// Counts the files that get a name in a folder while it lives.
class Arrivals {
 public:
  explicit Arrivals(const std::filesystem::path& folder) : queue_(inotify_init1(IN_NONBLOCK)) {
    EXPECT_GE(inotify_add_watch(queue_, folder.c_str(), IN_MOVED_TO), 0) << std::strerror(errno);
  }
  ~Arrivals() { close(queue_); }
  Arrivals(const Arrivals&) = delete;
  Arrivals& operator=(const Arrivals&) = delete;

  // Since the last call.
  std::size_t of(const std::string& name) const {
    std::size_t count = 0;
    alignas(inotify_event) std::array<char, 65536> events;
    for (ssize_t size = 0; (size = read(queue_, events.data(), events.size())) > 0;)
      for (ssize_t at = 0; at < size;) {
        const auto* event = reinterpret_cast<const inotify_event*>(events.data() + at);
        EXPECT_EQ(event->mask & IN_Q_OVERFLOW, 0u);
        count += event->len > 0 && event->name == name ? 1 : 0;
        at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
      }
    return count;
  }

 private:
  int queue_;
};

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

// It has a line for each frame: written at every checkpoint, it would take the square of the frames in bytes.
TEST(Manifest, IsWrittenLessOftenAsItGrows) {
  constexpr int frames = 200;
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "out");
  const Arrivals arrivals(folder / "out");
  BakeOptions options = options_for(folder / "out");
  options.checkpoint_frames = 1;
  fake_bake_into(options, short_scene(frames));
  const auto written = static_cast<double>(arrivals.of("manifest.json"));
  // Each time after it has grown by a 64th, at first after each frame; and at the start and the end.
  EXPECT_LE(written, 64 + std::log(frames / 64.0) / std::log1p(1.0 / 64.0) + 4);
  // A bake that is killed loses no more than that.
  EXPECT_GE(written, 64);
}

// Control: files that arrive are counted.
TEST(Manifest, ArrivalsAreCounted) {
  const TemporaryFolder folder;
  const Arrivals arrivals(folder / ".");
  // By turns, as the manifest and the checkpoint: the kernel joins equal events.
  for (const char* name : {"a", "b", "a", "b", "a", "b"}) {
    write_text(folder / "tmp", name);
    std::filesystem::rename(folder / "tmp", folder / name);
  }
  EXPECT_EQ(arrivals.of("a"), 3u);
  EXPECT_EQ(arrivals.of("a"), 0u);
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
