// The converter as a program: what it says of malicious files, of its limits and of what it may write, and
// what the reader says without it.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <sys/wait.h>

#include "host/base/errors.h"
#include "host/base/process.h"
#include "host/gltf/convert.h"
#include "host/gltf/gltf.h"
#include "host/rig/character.h"
#include "tests/gltf/convert_files.h"
#include "tests/gltf/gltf_builder.h"

namespace fascicle::tests {
namespace {

using rig::Character;
namespace fs = std::filesystem;

TEST(Fbx, files_that_mean_no_good_get_one_message) {
  const TemporaryFolder folder;
  const std::string good = fbx_of({});
  const auto refused = [&](const std::string& name, const std::string& text) {
    try {
      gltf::read_gltf(folder.write(name, text));
    } catch (const base::SceneError& error) {
      const std::string what = error.what();
      EXPECT_EQ(what.find('\n'), std::string::npos) << what;
      return what;
    }
    return std::string();
  };
  EXPECT_EQ(refused("good.fbx", good), "");
  EXPECT_NE(refused("empty.fbx", "").find("it is empty"), std::string::npos);
  EXPECT_NE(refused("noise.fbx", "\x01\x02 noise").find("cannot be read"), std::string::npos);
  // Just a header that announces blocks of 4 GiB.
  std::string binary = "Kaydara FBX Binary  ";
  binary += std::string("\0\x1a\0\xe8\x1c\0\0", 7) + std::string(64, '\xff');
  EXPECT_NE(refused("huge.fbx", binary).find("cannot be read"), std::string::npos);
  std::string counts = good;
  counts.replace(counts.find("*12 {"), 5, "*4000000000 {");
  EXPECT_NE(refused("counts.fbx", counts).find("cannot be read"), std::string::npos);
  std::string nothing = good;
  nothing.replace(nothing.find("C: \"OO\",12,11"), 13, "");
  EXPECT_NE(refused("nothing.fbx", nothing).find("contains no polygon mesh"), std::string::npos);
  // By its name an FBX file, by its content one that would open others.
  EXPECT_NE(
      refused("other.fbx", "mtllib /etc/passwd\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").find("cannot be"),
      std::string::npos);
  // Names that assimp gives parts of an FBX node are ordinary names in Collada, for the top node and for a
  // joint.
  const Character named = gltf::read_gltf(
      folder.write("links.dae", dae_of("Top_$AssimpFbx$_Rotation", "Bone_$AssimpFbx$_Rotation")));
  EXPECT_TRUE(has_joint(named, "Bone_$AssimpFbx$_Rotation"));
  EXPECT_LT(both_ways(named.surface.vertices, {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}}), file_rounding);
}

// The converter's own output; checks its exit status.
std::string said_by_converter(const TemporaryFolder& folder, const std::string& arguments, int status) {
  const std::string command = "cd '" + folder.path().string() + "' && '" + FASCICLE_BINARY_DIR +
                              "/fascicle-convert' " + arguments + " 2> err";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), status) << arguments;
  return text_of(folder.path() / "err");
}

TEST(Converter, writes_nothing_but_a_glb_that_is_another_file) {
  const TemporaryFolder folder;
  const std::string good = fbx_of({});
  folder.write("man.fbx", good);
  fs::create_hard_link(folder.path() / "man.fbx", folder.path() / "same.glb");
  for (const char* out : {"man.fbx", "man", "man.gltf", "same.glb"}) {
    const std::string said = said_by_converter(folder, std::string("man.fbx ") + out, 2);
    EXPECT_NE(said.find(out), std::string::npos) << said;
    EXPECT_EQ(text_of(folder.path() / "man.fbx"), good) << out;
  }
  fs::create_directories(folder.path() / "taken.glb" / "by");
  EXPECT_NE(said_by_converter(folder, "man.fbx taken.glb", 4).find("taken.glb cannot be written"),
            std::string::npos);
  for (const auto& entry : fs::directory_iterator(folder.path()))
    EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
  EXPECT_EQ(said_by_converter(folder, "man.fbx man.glb", 0), "");
  EXPECT_TRUE(fs::exists(folder.path() / "man.glb"));
}

TEST(Converter, messages_name_the_file_once) {
  const TemporaryFolder folder;
  folder.write("noise.fbx", "noise");
  EXPECT_EQ(said_by_converter(folder, "noise.fbx noise.glb", 3).find("fascicle-convert: noise.fbx: "), 0u);
  const fs::path noise = folder.path() / "noise.fbx";
  try {
    gltf::read_gltf(noise);
    FAIL() << "noise was read";
  } catch (const base::SceneError& error) {
    const std::string what = error.what();
    EXPECT_EQ(what.find(noise.string() + ": cannot be read: "), 0u) << what;
    EXPECT_EQ(what.find(noise.string(), 1), std::string::npos) << what;
  }
}

// The error when `converter` runs in place of the real one, or with its limits.
std::string refusal_of(const fs::path& input, const gltf::Converter& converter) {
  try {
    gltf::convert_character(input, fs::path(input).replace_extension(".glb"), converter);
  } catch (const base::SceneError& error) {
    return error.what();
  }
  return "converted";
}

// Each name in this comment begins a search, which once went to the end of the file: half a minute for 4 MB.
TEST(Converter, searches_a_file_of_many_names_in_time_by_its_length) {
  const TemporaryFolder folder;
  std::string text = fbx_of({}) + ";";
  while (text.size() < 4'000'000) text += "LocalStop\"";
  EXPECT_EQ(refusal_of(folder.write("names.fbx", text + "\n"),
                       {.limits = {.seconds = 10.0, .bytes = std::uint64_t{4} << 30}}),
            "converted");
}

TEST(Converter, that_takes_too_long_or_too_much_is_said_to) {
  const TemporaryFolder folder;
  const fs::path hero = folder.write("hero.fbx", fbx_of({}));
  const auto said = [&](const std::string& script, const base::ProcessLimits& limits) {
    const fs::path program = folder.write("converter", "#!/bin/sh\n" + script + "\n");
    fs::permissions(program, fs::perms::owner_all);
    return refusal_of(hero, {program, limits});
  };
  constexpr std::uint64_t gigabyte = std::uint64_t{1} << 30;
  const std::string by_hand = ". Convert it with FBX2glTF, ";
  struct Case {
    const char* script;
    double seconds;  // also how long the machine may stand still
    const char* words;
  };
  for (const Case& one :
       {Case{"while :; do :; done", 1.5, "took longer to convert than the 1.5 s of processor time allowed"},
        Case{"exec 2>&-; sleep 600", 0.3,
             "was not converted: the converter got no processor time for 0.3 s; see what keeps this machine "
             "busy"},
        Case{"exit 6", 60.0, "cannot be read: it needs more than 1.5 GiB of memory"},
        Case{"kill -SEGV $$", 60.0, "cannot be read: the converter crashed on it (signal 11)"}}) {
    const std::string refusal = said(one.script, {.seconds = one.seconds, .bytes = 3 * gigabyte / 2});
    EXPECT_EQ(refusal.find(hero.string() + ": " + one.words + by_hand), 0u) << refusal;
  }
  // What the system or a scheduler ends says nothing about the file.
  for (const auto& [script, words] : {std::pair{"kill -KILL $$", "was killed from outside (Killed)"},
                                      std::pair{"kill -TERM $$", "was killed from outside (Terminated)"}})
    try {
      ADD_FAILURE() << said(script, {});
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  // On a busy machine it gets little CPU time, and is waited for.
  EXPECT_NE(said("i=0; while [ $i -lt 25 ]; do i=$((i+1)); sleep 0.2; done; exit 6", {.seconds = 3.0})
                .find("more than 4 GiB of memory"),
            std::string::npos);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

// The real converter with less and less memory: if it runs out it says so, and never blames the file.
TEST(Converter, a_file_that_needs_more_memory_is_not_called_bad) {
  const TemporaryFolder folder;
  // 400,000 numbers, which become a text of 5 MB and several copies.
  std::string points, corners;
  constexpr int count = 399996;
  for (int k = 0; k < count; ++k) points += std::to_string(k % 1000) + " ";
  for (int k = 0; k < count / 3; ++k) corners += std::to_string(k) + " ";
  const fs::path large = folder.write(
      "large.dae",
      "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><library_geometries>"
      "<geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"a\" count=\"" +
          std::to_string(count) + "\">" + points +
          "</float_array><technique_common><accessor source=\"#a\" count=\"" + std::to_string(count / 3) +
          "\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>"
          "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source><vertices id=\"v\">"
          "<input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles count=\"" +
          std::to_string(count / 9) + "\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>" +
          corners +
          "</p></triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene "
          "id=\"s\">"
          "<node id=\"n\"><instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes>"
          "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>");
  ASSERT_EQ(refusal_of(large, {}), "converted");
  bool is_refused = false;
  // With less, not even its libraries load.
  for (std::uint64_t megabytes = 256; megabytes >= 32; megabytes -= 4) {
    const std::string said = refusal_of(large, {{}, {.bytes = megabytes << 20}});
    if (said == "converted") continue;
    if (said.find("shared librar") != std::string::npos) break;
    is_refused = true;
    EXPECT_NE(said.find("it needs more than 0."), std::string::npos) << megabytes << " MiB: " << said;
  }
  EXPECT_TRUE(is_refused);
}

#endif

// Another converter would not help, so the message names none.
TEST(Converter, a_machine_without_room_for_the_result_is_not_the_files_fault) {
  const TemporaryFolder folder;
  folder.write("hero.fbx", fbx_of({}));
  const std::string command = "cd '" + folder.path().string() + "' && TMPDIR=/nowhere '" +
                              FASCICLE_BINARY_DIR + "/fascicle' inspect hero.fbx > out 2> err";
  EXPECT_NE(WEXITSTATUS(std::system(command.c_str())), 0);
  const std::string said = text_of(folder.path() / "err");
  for (const char* part : {"hero.fbx: ", "TMPDIR"}) EXPECT_NE(said.find(part), std::string::npos) << said;
  EXPECT_EQ(said.find("FBX2glTF"), std::string::npos) << said;
}

// A copy of the program without the helper next to it.
TEST(Fbx, without_the_converter_the_message_names_others) {
  const TemporaryFolder folder;
  folder.write("hero.fbx", fbx_of({}));
  fs::copy_file(fs::path(FASCICLE_BINARY_DIR) / "fascicle", folder.path() / "fascicle");
  const std::string in_folder = "cd '" + folder.path().string() + "' && ";
  const int status =
      std::system((in_folder + "PATH=/nowhere ./fascicle inspect hero.fbx > out 2> err").c_str());
  EXPECT_EQ(WEXITSTATUS(status), 3);
  const std::string said = text_of(folder.path() / "err");
  for (const char* part : {"hero.fbx: ", "fascicle-convert", "FBX2glTF", "export `hero.glb`"})
    EXPECT_NE(said.find(part), std::string::npos) << said;
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
}

}  // namespace
}  // namespace fascicle::tests
