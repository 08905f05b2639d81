// The cache of filled bodies gives the same bits as no cache, whatever happens to its files.
#include "host/build/cache.h"

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
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

// An entry that is whole but holds no usable body must leave nothing behind, not even its warnings.
TEST_F(CacheTest, NothingOfARefusedEntryIsKept) {
  const scene::Scene scene = cube_character();
  build::BuildOptions options;
  options.cache = folder_;
  build::Report first, second;
  build::build_model(scene, first, options);
  build::Report foreign;
  foreign.warnings = {{"a warning of another body", {}}};
  Cache(folder_).put(only_entry().stem(), build::filled_body_bytes({}, foreign));
  build::build_model(scene, second, options);
  EXPECT_FALSE(second.body_from_cache);
  EXPECT_EQ(second.warnings.size(), first.warnings.size());
  for (const auto& warning : second.warnings) EXPECT_NE(warning.text, foreign.warnings[0].text);
}

}  // namespace
}  // namespace fascicle::tests
