// The cache of filled bodies gives the same bits as no cache, whatever happens to its files.
#include "host/build/cache.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/bake/identity.h"
#include "host/base/file.h"
#include "host/build/filled_body.h"
#include "tests/build/scenes.h"
#include "tests/build/surfaces.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using build::Cache;
using scene::Vector3d;

const std::string key_a(32, 'a'), key_b(32, 'b'), key_c(32, 'c');

class CacheTest : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("fascicle-cache-" + std::string(info->name()));
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path only_entry() const {
    std::vector<fs::path> files;
    for (const auto& file : fs::directory_iterator(folder_)) files.push_back(file.path());
    EXPECT_EQ(files.size(), 1u);
    return files.empty() ? fs::path() : files[0];
  }

  fs::path folder_;
};

std::string content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void overwrite(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

TEST_F(CacheTest, GivesBackWhatWasPut) {
  const Cache cache(folder_);
  EXPECT_FALSE(cache.find(key_a));
  cache.put(key_a, "first");
  cache.put(key_b, std::string("a\0b\n", 4));
  cache.put(key_a, "second");
  EXPECT_EQ(cache.find(key_a), "second");
  EXPECT_EQ(cache.find(key_b), std::string("a\0b\n", 4));
  EXPECT_FALSE(cache.find(key_c));
  // No temporary files are left behind.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);
}

TEST_F(CacheTest, WithoutAFolderKeepsNothing) {
  const Cache cache({});
  cache.put(key_a, "x");
  EXPECT_FALSE(cache.find(key_a));
}

TEST_F(CacheTest, IgnoresEveryDamage) {
  const Cache cache(folder_);
  cache.put(key_a, "some bytes");
  const fs::path entry = only_entry();
  const std::string good = content(entry);
  for (std::size_t k = 0; k < good.size(); ++k) {
    std::string bad = good;
    bad[k] = static_cast<char>(bad[k] ^ 0x10);
    overwrite(entry, bad);
    EXPECT_FALSE(cache.find(key_a)) << "flipped byte " << k;
    overwrite(entry, good.substr(0, k));
    EXPECT_FALSE(cache.find(key_a)) << "cut at " << k;
  }
  overwrite(entry, good + "x");
  EXPECT_FALSE(cache.find(key_a));
  // The control: the undamaged bytes are accepted again.
  overwrite(entry, good);
  EXPECT_EQ(cache.find(key_a), "some bytes");
  // An entry under another entry's name.
  fs::copy_file(entry, folder_ / (key_b + ".entry"));
  EXPECT_FALSE(cache.find(key_b));
  // It is replaced.
  cache.put(key_b, "b");
  EXPECT_EQ(cache.find(key_b), "b");
}

TEST_F(CacheTest, PassesByWhatIsNoFile) {
  const Cache cache(folder_);
  fs::create_directories(folder_ / (key_a + ".entry"));
  EXPECT_FALSE(cache.find(key_a));
  cache.put(key_a, "x");
  EXPECT_FALSE(cache.find(key_a));
  // A FIFO without a writer must not block.
  ASSERT_EQ(::mkfifo((folder_ / (key_b + ".entry")).c_str(), 0600), 0);
  EXPECT_FALSE(cache.find(key_b));
  cache.put(key_b, "b");
  EXPECT_EQ(cache.find(key_b), "b");
  // The cache folder's parent is a file.
  overwrite(folder_ / "file", "");
  const Cache nowhere(folder_ / "file" / "cache");
  nowhere.put(key_a, "x");
  EXPECT_FALSE(nowhere.find(key_a));
}

TEST_F(CacheTest, WhatWasNotUsedForLongestMakesRoom) {
  const std::string bytes(1000, 'x');
  // Room for two entries with their headers, but not for three.
  const Cache cache(folder_, 2500);
  const auto set_age = [&](const std::string& key, int hours) {
    fs::last_write_time(folder_ / (key + ".entry"),
                        fs::file_time_type::clock::now() - std::chrono::hours(hours));
  };
  cache.put(key_a, bytes);
  cache.put(key_b, bytes);
  set_age(key_a, 3);
  set_age(key_b, 2);
  ASSERT_TRUE(cache.find(key_a));  // a use; now b is the oldest
  const fs::path stale = folder_ / (key_c + ".entry.0123456789abcdef.tmp");
  const std::array mine{folder_ / "mine.txt", folder_ / "render.tmp", folder_ / "diary.entry",
                        folder_ / (key_a + ".tmp"), folder_ / "diary.entry.0123456789abcdef.tmp"};
  overwrite(stale, bytes);
  for (const fs::path& file : mine) overwrite(file, bytes);
  const auto set_old = [](const fs::path& file) {
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(5));
  };
  set_old(stale);
  for (const fs::path& file : mine) set_old(file);
  cache.put(key_c, bytes);
  EXPECT_TRUE(cache.find(key_a));
  EXPECT_FALSE(cache.find(key_b));
  EXPECT_TRUE(cache.find(key_c));
  // Other people's files stay; a stale temporary file is removed.
  for (const fs::path& file : mine) EXPECT_TRUE(fs::exists(file)) << file;
  EXPECT_FALSE(fs::exists(stale));
  // An entry larger than the whole cache is not kept and evicts nothing.
  cache.put(key_b, std::string(5000, 'y'));
  EXPECT_FALSE(cache.find(key_b));
  EXPECT_TRUE(cache.find(key_a));
}

TEST_F(CacheTest, MayBeAsFullAsItIsAllowedToBe) {
  const std::string bytes(1000, 'x');
  Cache(folder_).put(key_a, bytes);
  const Cache full(folder_, 2 * fs::file_size(folder_ / (std::string(key_a) + ".entry")));
  full.put(key_b, bytes);
  EXPECT_TRUE(full.find(key_a));
  EXPECT_TRUE(full.find(key_b));
}

TEST_F(CacheTest, ManyMayWriteAndReadAtATime) {
  const Cache cache(folder_);
  const std::string bytes(200000, 'z');
  std::vector<std::jthread> threads;
  std::atomic<int> wrong{0};
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int k = 0; k < 10; ++k) {
        cache.put(key_a, bytes);
        // Whichever write came last, the entry is complete.
        if (cache.find(key_a) != bytes) ++wrong;
      }
    });
  threads.clear();
  EXPECT_EQ(wrong, 0);
  only_entry();
}

// Runs `work` in a process with PID 1, as could happen on another host that shares the folder. `work` returns
// whether all is well. The process exits with 2 if the system allows no PID namespaces.
bool start_as_on_another_host(const std::function<bool()>& work, pid_t& process) {
  process = ::fork();
  if (process != 0) return process > 0;
  constexpr int not_allowed = 2;
  if (::unshare(CLONE_NEWPID) != 0 && ::unshare(CLONE_NEWUSER | CLONE_NEWPID) != 0) ::_exit(not_allowed);
  const pid_t first = ::fork();
  if (first == 0) ::_exit(::getpid() == 1 && work() ? 0 : 1);
  int status = 0;
  if (first < 0 || ::waitpid(first, &status, 0) != first) ::_exit(1);
  ::_exit(WIFEXITED(status) ? WEXITSTATUS(status) : 1);
}

// If both used one temporary file name, each could truncate or rename the other's file.
TEST_F(CacheTest, HostsMayShareIt) {
  fs::create_directories(folder_);
  const fs::path path = folder_ / "entry";
  std::array<pid_t, 2> hosts{};
  for (pid_t& host : hosts)
    ASSERT_TRUE(start_as_on_another_host(
        [&] {
          const std::string bytes(300000, static_cast<char>('a' + (&host - hosts.data())));
          try {
            for (int k = 0; k < 50; ++k) {
              base::write_whole_beside_others(path, bytes);
              const std::string found = content(path);
              if (found.size() != bytes.size() || found.find_first_not_of(found[0]) != std::string::npos)
                return false;
            }
          } catch (const std::system_error&) {
            return false;
          }
          return true;
        },
        host));
  for (const pid_t host : hosts) {
    int status = 0;
    ASSERT_EQ(::waitpid(host, &status, 0), host);
    ASSERT_TRUE(WIFEXITED(status));
    if (WEXITSTATUS(status) == 2) GTEST_SKIP() << "NO PROCESS NAMESPACES, HOSTS NOT TESTED";
    EXPECT_EQ(WEXITSTATUS(status), 0);
  }
  only_entry();
}

TEST(CacheFolder, ComesFromTheEnvironment) {
  const auto restore = [](const char* name) {
    const char* value = std::getenv(name);
    return std::pair<std::string, std::string>(name, value == nullptr ? "" : value);
  };
  const std::vector<std::pair<std::string, std::string>> before{restore("FASCICLE_CACHE_DIR"),
                                                                restore("XDG_CACHE_HOME"), restore("HOME")};
  ::setenv("FASCICLE_CACHE_DIR", "/own", 1);
  ::setenv("XDG_CACHE_HOME", "/xdg", 1);
  ::setenv("HOME", "/home/me", 1);
  EXPECT_EQ(build::default_cache_folder(), "/own");
  ::unsetenv("FASCICLE_CACHE_DIR");
  EXPECT_EQ(build::default_cache_folder(), "/xdg/fascicle");
  ::setenv("XDG_CACHE_HOME", "relative", 1);
  EXPECT_EQ(build::default_cache_folder(), "/home/me/.cache/fascicle");
  ::unsetenv("XDG_CACHE_HOME");
  ::unsetenv("HOME");
  EXPECT_TRUE(build::default_cache_folder().empty());
  for (const auto& [name, value] : before)
    if (!value.empty()) ::setenv(name.c_str(), value.c_str(), 1);
}

// A cube with two joints, split along an edge like a UV seam.
scene::Scene cube_character() {
  rig::Character character;
  character.surface = cube_surface(2.0);
  character.surface.vertices.push_back(character.surface.vertices[0]);
  character.surface.triangles[0][0] = 8;
  for (const Vector3d& p : character.surface.vertices) {
    character.joints.push_back({0, 1});
    character.weights.push_back(p[0] < 0 ? std::array<double, 8>{0.75, 0.25}
                                         : std::array<double, 8>{0.1, 0.9});
  }
  character.skeleton = {joint_at("hip", -1, {-0.5, 0, 0}), joint_at("head", 0, {0.5, 0, 0})};
  scene::Scene scene = bar_scene();
  scene.geometry = character;
  scene.resolution = 0.4;
  return scene;
}

TEST_F(CacheTest, AModelHasTheSameBitsWithAndWithoutIt) {
  const scene::Scene scene = cube_character();
  build::BuildOptions options;
  build::Report without, first, second;
  const model::Model plain = build::build_model(scene, without, options);
  options.cache = folder_;
  const model::Model filling = build::build_model(scene, first, options);
  const model::Model cached = build::build_model(scene, second, options);
  EXPECT_FALSE(without.body_from_cache);
  EXPECT_FALSE(first.body_from_cache);
  EXPECT_TRUE(second.body_from_cache);
  EXPECT_EQ(bake::model_hash(plain), bake::model_hash(filling));
  EXPECT_EQ(bake::model_hash(plain), bake::model_hash(cached));
  EXPECT_EQ(without.warnings.size(), second.warnings.size());
  EXPECT_EQ(without.fill.least_barycentric, second.fill.least_barycentric);

  // Different input gets a different entry.
  scene::Scene finer = scene;
  finer.resolution = 0.3;
  build::Report third;
  build::build_model(finer, third, options);
  EXPECT_FALSE(third.body_from_cache);
  // A damaged entry is rebuilt.
  for (const auto& file : fs::directory_iterator(folder_)) {
    std::string bytes = content(file.path());
    bytes.back() = static_cast<char>(bytes.back() ^ 1);
    overwrite(file.path(), bytes);
  }
  build::Report fourth, fifth;
  EXPECT_EQ(bake::model_hash(plain), bake::model_hash(build::build_model(scene, fourth, options)));
  EXPECT_FALSE(fourth.body_from_cache);
  EXPECT_EQ(bake::model_hash(plain), bake::model_hash(build::build_model(scene, fifth, options)));
  EXPECT_TRUE(fifth.body_from_cache);
}

// Bytes with a valid checksum can still be foreign or malicious.
class FilledBodyTest : public testing::Test {
 protected:
  void SetUp() override {
    body_.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    body_.mesh.tetrahedra = {{0, 1, 2, 3}, {1, 2, 3, 4}};
    body_.skin.offset = {0, 1, 2, 3, 4, 6};
    body_.skin.joint = {0, 0, 1, 1, 0, 1};
    body_.skin.weight = {1, 1, 1, 1, 0.5, 0.5};
    body_.render.corners = {{0, 1, 2, 3}, {4, 4, 4, 4}, {1, 1, 1, 1}};
    body_.render.weights = {{0.25, 0.25, 0.25, 0.25}, {1, 0, 0, 0}, {1, 0, 0, 0}};
    found_.warnings = {{"a warning", {3, 4}}};
    found_.fill.least_barycentric = -0.03;
    character_.skeleton.resize(2);
    surface_.vertices.resize(3);
    surface_.triangles = {{0, 1, 2}};
  }

  bool reads(const std::string& bytes) {
    read_ = {};
    found_again_ = {};
    return build::read_filled_body(bytes, {scene_, surface_, welded_, bones_, &character_}, read_,
                                   found_again_);
  }
  void expect_refused(const std::function<void(build::FilledBody&)>& spoil, const char* what) {
    build::FilledBody spoilt = body_;
    spoil(spoilt);
    EXPECT_FALSE(reads(build::filled_body_bytes(spoilt, found_))) << what;
  }

  build::FilledBody body_, read_;
  build::Report found_, found_again_;
  scene::Scene scene_;
  rig::Character character_;
  mesh::SurfaceMesh surface_;
  build::WeldedSurface welded_;
  std::vector<build::Bone> bones_;
};

// The cut reads the clips, so other poses give another body.
TEST_F(FilledBodyTest, IsKeptUnderItsClips) {
  const auto key = [&] {
    return build::fill_key({scene_, surface_, welded_, bones_, &character_}, "programs");
  };
  const std::string still = key();
  rig::Clip& clip = character_.clips.emplace_back();
  clip.duration = 1.0;
  clip.channels.push_back(
      {0, rig::ChannelPath::translation, rig::Interpolation::linear, {0.0, 1.0}, {0, 0, 0, 1, 0, 0}});
  const std::string moving = key();
  EXPECT_NE(moving, still);
  clip.name = "a name that nothing reads";
  EXPECT_EQ(key(), moving);
  clip.channels[0].values[3] = 2.0;
  EXPECT_NE(key(), moving);
}

// Everything that the filling reads is in the key: with one left out, another body would be taken for this
// one.
TEST_F(FilledBodyTest, IsKeptUnderAllThatItIsMadeOf) {
  welded_.surface.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  welded_.surface.triangles = {{0, 1, 2}};
  welded_.of_vertex = {0, 1, 2};
  welded_.file_vertex = {0, 1, 2};
  bones_.resize(1);
  character_.joints.resize(3);
  character_.weights.resize(3);
  struct Input {
    scene::Scene scene;
    mesh::SurfaceMesh surface;
    build::WeldedSurface welded;
    std::vector<build::Bone> bones;
    rig::Character character;
    std::string programs = "programs";
    bool is_character = true;
  };
  const Input as_it_is{scene_, surface_, welded_, bones_, character_};
  const std::vector<std::pair<const char*, std::function<void(Input&)>>> changes{
      {"the programs", [](Input& in) { in.programs = "others"; }},
      {"the resolution", [](Input& in) { in.scene.resolution = 0.25; }},
      {"the cage", [](Input& in) { in.scene.body.cage = scene::Cage::wrap; }},
      {"the cage's detail", [](Input& in) { in.scene.body.cage_detail *= 2.0; }},
      {"the number of vertices", [](Input& in) { in.scene.body.vertices = 500; }},
      {"the thickness", [](Input& in) { in.scene.body.thickness = 0.01; }},
      {"a vertex", [](Input& in) { in.welded.surface.vertices[2][1] = 1.5; }},
      {"a triangle of the welded surface",
       [](Input& in) {
         in.welded.surface.triangles = {{1, 2, 0}};
       }},
      {"where a vertex was welded", [](Input& in) { in.welded.of_vertex[2] = 1; }},
      {"the numbers in the file", [](Input& in) { in.welded.file_vertex[2] = 7; }},
      {"a triangle",
       [](Input& in) {
         in.surface.triangles = {{1, 2, 0}};
       }},
      {"one bone more", [](Input& in) { in.bones.emplace_back(); }},
      {"the end of a bone", [](Input& in) { in.bones[0].to[2] = 0.5; }},
      {"the owner of a bone", [](Input& in) { in.bones[0].owners[1] = 1; }},
      {"no character", [](Input& in) { in.is_character = false; }},
      {"one joint more", [](Input& in) { in.character.skeleton.emplace_back(); }},
      {"a joint's parent", [](Input& in) { in.character.skeleton[1].parent = 0; }},
      {"a vertex's joints", [](Input& in) { in.character.joints[1][3] = 1; }},
      {"a vertex's weights", [](Input& in) { in.character.weights[1][3] = 0.5; }}};
  const auto key = [](const Input& in) {
    const rig::Character* character = in.is_character ? &in.character : nullptr;
    return build::fill_key({in.scene, in.surface, in.welded, in.bones, character}, in.programs);
  };
  std::map<std::string, const char*> of_key{{key(as_it_is), "nothing"}};
  EXPECT_EQ(key(Input(as_it_is)), key(as_it_is));
  for (const auto& [what, change] : changes) {
    Input changed = as_it_is;
    change(changed);
    const auto [found, is_new] = of_key.emplace(key(changed), what);
    EXPECT_TRUE(is_new) << what << " has the key of " << found->second;
  }
}

TEST_F(FilledBodyTest, ComesBackWhole) {
  ASSERT_TRUE(reads(build::filled_body_bytes(body_, found_)));
  EXPECT_EQ(read_.mesh.vertices, body_.mesh.vertices);
  EXPECT_EQ(read_.mesh.tetrahedra, body_.mesh.tetrahedra);
  EXPECT_EQ(read_.skin.offset, body_.skin.offset);
  EXPECT_EQ(read_.skin.joint, body_.skin.joint);
  EXPECT_EQ(read_.skin.weight, body_.skin.weight);
  EXPECT_EQ(read_.render.corners, body_.render.corners);
  EXPECT_EQ(read_.render.weights, body_.render.weights);
  EXPECT_EQ(read_.render.triangles, surface_.triangles);
  ASSERT_EQ(found_again_.warnings.size(), 1u);
  EXPECT_EQ(found_again_.warnings[0].text, "a warning");
  EXPECT_EQ(found_again_.warnings[0].vertices, (std::vector<std::uint32_t>{3, 4}));
  EXPECT_EQ(found_again_.fill.least_barycentric, -0.03);
}

TEST_F(FilledBodyTest, RefusesEveryShorterAndLongerText) {
  const std::string good = build::filled_body_bytes(body_, found_);
  for (std::size_t k = 0; k < good.size(); ++k) EXPECT_FALSE(reads(good.substr(0, k))) << k;
  EXPECT_FALSE(reads(good + '\0'));
}

TEST_F(FilledBodyTest, NoByteCanMakeItCrash) {
  const std::string good = build::filled_body_bytes(body_, found_);
  // Every byte at its extremes; this covers the lengths of all arrays, up to 2^64 - 1.
  for (std::size_t k = 0; k < good.size(); ++k)
    for (const char value : {'\x00', '\x7f', '\x80', '\xff'}) {
      std::string bad = good;
      bad[k] = value;
      if (!reads(bad)) continue;
      // Accepted data must be safe to use.
      for (const auto& t : read_.mesh.tetrahedra)
        for (const std::uint32_t corner : t) ASSERT_LT(corner, read_.mesh.vertices.size());
      for (const std::uint32_t joint : read_.skin.joint) ASSERT_LT(joint, 2u);
      ASSERT_EQ(found_again_.fill.cage.ends.fate.size(), found_again_.fill.cage.ends.vertex.size());
    }
}

TEST_F(FilledBodyTest, RefusesWhatTheBuildCouldNotRelyOn) {
  expect_refused([](auto& b) { b.mesh.tetrahedra[1][3] = 5; }, "corner out of range");
  expect_refused([](auto& b) { std::swap(b.mesh.tetrahedra[0][0], b.mesh.tetrahedra[0][1]); }, "inside out");
  expect_refused([](auto& b) { b.mesh.vertices[4][0] = NAN; }, "not finite");
  expect_refused([](auto& b) { b.mesh.vertices.push_back({9, 9, 9}); }, "an unused vertex");
  expect_refused([](auto& b) { b.skin.joint[3] = 2; }, "joint out of range");
  expect_refused([](auto& b) { b.skin.weight[4] = 0.75; }, "weights that sum to more than 1");
  expect_refused([](auto& b) { b.skin.weight[0] = NAN; }, "a weight that is not a number");
  expect_refused([](auto& b) { b.skin.offset[2] = 1; }, "a vertex without joints");
  expect_refused([](auto& b) { b.skin.offset[2] = 0xffffffffu; }, "an offset beyond the end");
  expect_refused([](auto& b) { b.skin = {}; }, "no weights for a character");
  expect_refused([](auto& b) { b.render.corners[0][2] = 5; }, "a rider on nothing");
  expect_refused([](auto& b) { b.render.weights[1][0] = INFINITY; }, "a rider at infinity");
  expect_refused([](auto& b) { b.render.corners.pop_back(); }, "a rider too few");
}

// The report reads an entry of each array per end.
TEST_F(FilledBodyTest, RefusesEndsOfUnequalArrays) {
  build::OpenEnds& ends = found_.fill.cage.ends;
  ends = {.vertex = {0, 2}, .edges = {3, 4}, .joint = {1, -1}, .width = {0.5, 0.25}, .fate = {0, 1}};
  ASSERT_TRUE(reads(build::filled_body_bytes(body_, found_)));
  EXPECT_EQ(found_again_.fill.cage.ends.width, ends.width);
  const auto expect_ends_refused = [&](const std::function<void(build::OpenEnds&)>& spoil, const char* what) {
    build::Report spoilt = found_;
    spoil(spoilt.fill.cage.ends);
    EXPECT_FALSE(reads(build::filled_body_bytes(body_, spoilt))) << what;
  };
  expect_ends_refused([](auto& e) { e.vertex.resize(200'000); }, "vertices without the rest");
  expect_ends_refused([](auto& e) { e.edges.pop_back(); }, "an edge count too few");
  expect_ends_refused([](auto& e) { e.joint.pop_back(); }, "a joint too few");
  expect_ends_refused([](auto& e) { e.width.push_back(1.0); }, "a width too many");
  expect_ends_refused([](auto& e) { e.fate.clear(); }, "no fates");
}

}  // namespace
}  // namespace fascicle::tests
