// read_jobs: the bakes of a list, their names, and what is refused.
#include "host/scene/jobs.h"

#include <cctype>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/rig/pose.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

class ReadJobs : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("fascicle-jobs-" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& text, const std::string& name = "walks.toml") const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  scene::Jobs jobs(const std::string& text) const { return scene::read_jobs(write(text)); }
  std::string refusal(const std::string& text) const {
    try {
      (void)jobs(text);
    } catch (const scene::SceneError& error) {
      return error.what();
    }
    return "no error";
  }

  fs::path folder_;
};

TEST_F(ReadJobs, TakesEachCombinationOfClipsAndValues) {
  const scene::Jobs read = jobs(
      "output = \"out/all\"\nformat = [\"pc2\"]\n"
      "[job.man]\nscene = \"jump\"\nclips = [\"walk\", \"a run\"]\nset = [\"scene.fps=24\"]\n"
      "[job.man.vary]\n\"layers.fat.alpha\" = [0.1, 0.3]\n\"solver.substeps\" = [\"auto\"]\n"
      "[job.arm]\nscene = \"arm\"\nformat = [\"glb\", \"abc\"]\n");
  EXPECT_EQ(read.output, "out/all");
  ASSERT_EQ(read.jobs.size(), 5u);
  std::vector<std::string> names;
  for (const scene::Job& job : read.jobs) names.push_back(job.name);
  EXPECT_EQ(names, (std::vector<std::string>{"man-walk-0.1", "man-walk-0.3", "man-a_run-0.1", "man-a_run-0.3",
                                             "arm"}));
  EXPECT_EQ(read.jobs[2].clip, "a run");
  EXPECT_EQ(read.jobs[2].set,
            (std::vector<std::string>{"scene.fps=24", "layers.fat.alpha=0.1", "solver.substeps='auto'"}));
  EXPECT_EQ(read.jobs[2].formats, std::vector<std::string>{"pc2"});
  EXPECT_EQ(read.jobs[4].formats, (std::vector<std::string>{"glb", "abc"}));
  EXPECT_EQ(read.jobs[4].clip, "");
}

// The fewest digits that parse to the same number, in lists too.
TEST_F(ReadJobs, NamesVectorsShortly) {
  const scene::Jobs read =
      jobs("[job.a]\nscene = \"jump\"\n[job.a.vary]\n\"scene.gravity\" = [[0, -9.56, 0], [0, -9.5, 0.1]]\n");
  ASSERT_EQ(read.jobs.size(), 2u);
  EXPECT_EQ(read.jobs[0].name, "a-0_-9.56_0");
  EXPECT_EQ(read.jobs[1].name, "a-0_-9.5_0.1");
  EXPECT_EQ(read.jobs[0].set, std::vector<std::string>{"scene.gravity=[0, -9.56, 0]"});
}

TEST_F(ReadJobs, KeepsFramesAsItSaysOrAsAllDo) {
  const scene::Jobs read =
      jobs("keep_frames = false\n[job.a]\nscene = \"jump\"\n[job.b]\nscene = \"arm\"\nkeep_frames = true\n");
  EXPECT_FALSE(read.jobs[0].keep_frames);
  EXPECT_TRUE(read.jobs[1].keep_frames);
  EXPECT_TRUE(jobs("[job.a]\nscene = \"jump\"\n").jobs[0].keep_frames);
}

TEST_F(ReadJobs, FindsScenesBesideTheFile) {
  (void)write("", "mine.toml");
  const scene::Jobs read = jobs("[job.a]\nscene = \"mine.toml\"\n[job.b]\nscene = \"jump\"\n");
  EXPECT_EQ(read.jobs[0].scene, (folder_ / "mine.toml").string());
  EXPECT_EQ(read.jobs[1].scene, "jump");
  EXPECT_EQ(read.output, fs::path("out") / "walks");
}

// The folder that `fascicle bake rod-hang -o rod-hang` leaves next to the list.
TEST_F(ReadJobs, AFolderHidesNoBuiltInScene) {
  fs::create_directory(folder_ / "rod-hang");
  EXPECT_EQ(jobs("[job.a]\nscene = \"rod-hang\"\n").jobs[0].scene, "rod-hang");
}

// A name longer than a file system takes is that of a built-in scene, of which there is none: for the bake to
// say.
TEST_F(ReadJobs, TakesASceneOfAnyName) {
  const std::string scene(1000, 'a');
  EXPECT_EQ(jobs("output = 'o'\n[job.one]\nscene = '" + scene + "'\n").jobs.at(0).scene, scene);
}

TEST_F(ReadJobs, RefusesWithLineAndKey) {
  const std::vector<std::pair<std::string, std::string>> refused{
      {"", "job: is missing"},
      {"job = 3\n", ":1: job: is a table"},
      {"[job.a]\nset = [\"a=1\"]\n", "job.a: lacks scene"},
      {"[job.a]\nscen = \"jump\"\n", ":2: job.a.scen: unknown; did you mean scene?"},
      {"[job.a]\nscene = 3\n", ":2: job.a.scene: takes a text"},
      {"[job.a]\nscene = \"jump\"\nclips = \"walk\"\n", ":3: job.a.clips: takes a list of texts"},
      {"[job.a]\nscene = \"jump\"\nkeep_frames = 1\n", ":3: job.a.keep_frames: takes true or false"},
      {"[job.a]\nscene = \"jump\"\nvary = 2\n", ":3: job.a.vary: is a table"},
      {"[job.a]\nscene = \"jump\"\n[job.a.vary]\n\"scene.fps\" = 3\n", "takes a list of values"},
      {"[job.\"***\"]\nscene = \"jump\"\n", "has a name that cannot be a file name"},
      {"[job.\"a b\"]\nscene = \"jump\"\n[job.a_b]\nscene = \"arm\"\n", "makes a second bake called a_b"},
      {"[job.\"..\"]\nscene = \"jump\"\n", "which cannot be a folder name"},
      {"[job.\"batch.json\"]\nscene = \"jump\"\n", "which cannot be a folder name"},
      {"[job." + std::string(300, 'a') + "]\nscene = \"jump\"\n", "which cannot be a folder name"},
      {"[job.A]\nscene = \"jump\"\n[job.a]\nscene = \"arm\"\n", "makes a second bake called a"},
      {"[job.a\n", "TOML"}};
  for (const auto& [text, reason] : refused)
    EXPECT_NE(refusal(text).find(reason), std::string::npos) << text << refusal(text);
  EXPECT_THROW((void)scene::read_jobs(folder_ / "nowhere.toml"), scene::SceneError);
}

// `count` numbers, from 1.
std::string numbers(std::size_t count) {
  std::string list;
  for (std::size_t k = 1; k <= count; ++k) list += std::to_string(k) + ", ";
  return "[" + list + "]";
}

// A small file must not fill the memory: each bake has its own copy of the texts.
TEST_F(ReadJobs, RefusesMoreThanAFarmCanBake) {
  const std::string head = "[job.a]\nscene = \"arm\"\n", vary = "[job.a.vary]\n";
  const std::string many = "makes more than 10,000 bakes", long_text = "has a text of more than 65,536 bytes",
                    large = "more than 64 MiB of text";
  const std::string values = "b = " + numbers(10'000) + "\n";
  std::string clips, formats, tables;
  for (int k = 0; k < 10'001; ++k) clips += "\"c" + std::to_string(k) + "\", ";
  for (int k = 0; k < 1000; ++k) formats += "\"pc2\", ";
  for (int k = 0; k < 4000; ++k) tables += "[job.t" + std::to_string(k) + "]\nscene = \"arm\"\n";
  const std::vector<std::pair<std::string, std::string>> refused{
      {head + vary + values + "c = " + numbers(20'000) + "\n", many},
      {head + vary + "b = " + numbers(10'001) + "\n", many},
      {head + "clips = [" + clips + "]\n", many},
      {head + "clips = [\"x\", \"y\"]\n" + vary + "b = " + numbers(5001) + "\n", many},
      {head + vary + "b = " + numbers(6000) +
           "\n[job.b]\nscene = \"arm\"\n[job.b.vary]\nb = " + numbers(6000) + "\n",
       "job.b.vary: " + many},
      {head + "set = [\"s=" + std::string(1'000'000, 'x') + "\"]\n" + vary + values, long_text},
      {"[job.a]\nscene = \"" + std::string(100'000, 'x') + "\"\n", long_text},
      {head + "clips = [\"" + std::string(100'000, 'x') + "\"]\n", long_text},
      {head + vary + "b = [\"" + std::string(100'000, 'x') + "\"]\n", long_text},
      {head + "set = [\"s=" + std::string(60'000, 'x') + "\"]\n" + vary + values, large},
      {head + vary + "a = [\"" + std::string(60'000, 'x') + "\"]\n" + values, large},
      {head + vary + values + "c = [\"" + std::string(60'000, 'x') + "\"]\n", large},
      {"format = [" + formats + "]\n" + tables, large}};
  for (const auto& [text, reason] : refused)
    EXPECT_NE(refusal(text).find(reason), std::string::npos)
        << text.substr(0, 60) << ": " << refusal(text).substr(0, 200);
}

TEST_F(ReadJobs, TakesALargeFarmsList) {
  std::string set;
  for (int k = 0; k < 20; ++k)
    set += "\"layers.a_layer_with_a_long_name_" + std::to_string(k) + ".youngs_modulus=12345.678\", ";
  const scene::Jobs read =
      jobs("[job.a]\nscene = \"arm\"\nset = [" + set +
           "]\n[job.a.vary]\n\"scene.seed\" = " + numbers(10'000) + "\n\"scene.fps\" = [30]\n");
  ASSERT_EQ(read.jobs.size(), 10'000u);
  EXPECT_EQ(read.jobs.back().name, "a-10000");
  ASSERT_EQ(read.jobs.back().set.size(), 22u);
  EXPECT_EQ(read.jobs.back().set[20], "scene.seed=10000");
  EXPECT_EQ(read.jobs.back().set[21], "scene.fps=30");
}

TEST(JobNames, AreThoseThatAListMakes) {
  for (const std::string& name : {std::string("a"), std::string("man-walk-0.1"), std::string("A_b"),
                                  std::string("-1"), std::string(200, 'x')})
    EXPECT_TRUE(scene::is_job_name(name)) << name;
  for (const std::string& name :
       {std::string(), std::string("."), std::string(".."), std::string(".a"), std::string("a/b"),
        std::string("/a"), std::string("a b"), std::string("a\\b"), std::string("a\n"),
        std::string("\xc3\xa9"), std::string("a\0b", 3), std::string("batch.json"), std::string(201, 'x')})
    EXPECT_FALSE(scene::is_job_name(name)) << name;
}

rig::Character with_clips(const std::vector<std::string>& names) {
  rig::Character character;
  for (const std::string& name : names) character.clips.emplace_back().name = name;
  return character;
}

std::vector<std::string> file_names_of(const std::vector<scene::NamedClip>& clips) {
  std::vector<std::string> names;
  for (const scene::NamedClip& clip : clips) names.push_back(clip.file_name);
  return names;
}

using Names = std::vector<std::string>;

TEST(NamedClips, AreCalledAfterTheLastPartOfTheirNames) {
  const auto clips = scene::named_clips(with_clips({"Armature|walk", "Armature|run fast", "idle"}), {"all"});
  EXPECT_EQ(file_names_of(clips), (Names{"walk", "run_fast", "idle"}));
  EXPECT_EQ(clips[1].clip, "Armature|run fast");
}

// --clip takes TOML, as --set does: a name that begins with a quote would lose its quotes.
TEST(NamedClips, AreChosenByNumberWhereTheirNamesBeginWithAQuote) {
  const auto clips =
      scene::named_clips(with_clips({"\"walk\"", "'x'", " \"y\"", "it's", "1", "true"}), {"all"});
  Names chosen;
  for (const scene::NamedClip& clip : clips) chosen.push_back(clip.clip);
  EXPECT_EQ(chosen, (Names{"0", "1", "2", "it's", "1", "true"}));
}

// Folders differ even on file systems that ignore case, and none is hidden.
TEST(NamedClips, HaveFoldersUnlikeEachOther) {
  const Names hostile{"a|walk",
                      "b|Walk",
                      "../..",
                      "",
                      "\xff\x01/",
                      ".hidden",
                      std::string(500, 'x'),
                      "a|walk",
                      "1",
                      "|",
                      "..",
                      "\"$(id)\"",
                      "walk-0",
                      "clip-3",
                      "clip.hidden-5",
                      "batch.json",
                      "walk-0-12",
                      "two\nlines",
                      std::string("nul\0byte", 8),
                      std::string("nul\0bytes", 9)};
  const rig::Character character = with_clips(hostile);
  const auto clips = scene::named_clips(character, {"all"});
  ASSERT_EQ(clips.size(), hostile.size());
  std::set<std::string> seen;
  for (std::size_t k = 0; k < clips.size(); ++k) {
    const std::string& name = clips[k].file_name;
    std::string lower = name;
    for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    EXPECT_TRUE(seen.insert(lower).second) << name;
    EXPECT_FALSE(name.empty());
    EXPECT_NE(name.front(), '.') << name;
    EXPECT_LE(name.size(), 200u);
    EXPECT_TRUE(scene::is_job_name(name)) << name;
    EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-"),
              std::string::npos)
        << name;
    EXPECT_EQ(rig::find_clip(character, clips[k].clip), &character.clips[k]) << clips[k].clip;
  }
}

TEST(NamedClips, AreFoundAsTheClipOptionFindsThem) {
  const rig::Character character = with_clips({"Armature|walk", "Armature|run"});
  EXPECT_EQ(file_names_of(scene::named_clips(character, {"run", "0"})), (Names{"run", "walk"}));
  const auto refusal = [](const rig::Character& of, const Names& wanted) -> std::string {
    try {
      (void)scene::named_clips(of, wanted);
    } catch (const scene::SceneError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_NE(refusal(character, {"rum"}).find("run"), std::string::npos);
  EXPECT_NE(refusal(character, {"run", "1"}).find("twice"), std::string::npos);
  EXPECT_NE(refusal(with_clips({}), {"all"}).find("none"), std::string::npos);
}

// The generated bear has two clips.
TEST_F(ReadJobs, AllClipsAreThoseOfTheCharacter) {
  const scene::Jobs read = jobs("[job.bear]\nscene = \"crouch\"\nclips = \"all\"\n");
  ASSERT_EQ(read.jobs.size(), 2u);
  EXPECT_EQ(read.jobs[0].name, "bear-jump");
  EXPECT_EQ(read.jobs[1].name, "bear-bump");
  EXPECT_EQ(read.jobs[1].clip, "bump");
  for (const char* scene : {"bar-beta-1", "two-bears"})
    EXPECT_NE(refusal("[job.a]\nscene = \"" + std::string(scene) + "\"\nclips = \"all\"\n")
                  .find("a single character"),
              std::string::npos)
        << scene;
}

}  // namespace
}  // namespace fascicle::tests
