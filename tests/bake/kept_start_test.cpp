// The result of the steps before frame 0, kept for the next bake.
#include <map>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "tests/bake/fake_bakes.h"
#include "tests/drive/bending_bar.h"

namespace fascicle::tests {
namespace {

using bake::bake;
using bake::BakeOptions;

// Counts the frames stepped by another solver.
class CountingSolver final : public model::Solver {
 public:
  CountingSolver(model::Solver& solver, std::uint64_t& frames) : solver_(solver), frames_(frames) {}
  void submit(const model::Drive& drive, model::Read what, model::Probe* probe) override {
    ++frames_;
    solver_.submit(drive, what, probe);
  }
  model::Frame collect() override { return solver_.collect(); }
  model::State save() const override { return solver_.save(); }
  void load(const model::State& state) override { solver_.load(state); }

 private:
  model::Solver& solver_;
  std::uint64_t& frames_;
};

// The steps before frame 0 are reused by the same bake, whatever formats it writes, but not by a different
// bake.
TEST(KeptStart, IsNotSteppedAgainAndGivesTheSameBytes) {
  const TemporaryFolder folder;
  BendingBar bar = bending_bar(0.2);
  bar.scene.motion.preroll = 0.1;
  bar.scene.motion.settle = 0.1;
  std::map<std::string, std::string> kept;
  const auto baked = [&](const char* name, const std::vector<std::string>& formats) {
    BakeOptions options;
    options.folder = folder / name;
    options.formats = formats;
    options.find_start = [&](const std::string& key) {
      const auto found = kept.find(key);
      return found == kept.end() ? std::nullopt : std::optional<std::string>(found->second);
    };
    options.keep_start = [&](const std::string& key, std::string_view bytes) { kept[key] = bytes; };
    const auto solver = cpu_reference::make_cpu_solver(bar.model, {}, 1);
    std::uint64_t frames = 0;
    CountingSolver counting(*solver, frames);
    bake(bar.scene, bar.model, counting, options);
    return frames;
  };
  EXPECT_GT(baked("first", {}), 12u + 6u);  // the frames of the clip, of the preroll and of settling
  EXPECT_EQ(baked("second", {"pc2"}), 12u);
  EXPECT_EQ(read_text(folder / "second" / "frames.fascicle"),
            read_text(folder / "first" / "frames.fascicle"));
  auto stepped = manifest_in(folder / "first")["lead_in"], found = manifest_in(folder / "second")["lead_in"];
  EXPECT_EQ(stepped["was_kept"], false);
  EXPECT_EQ(found["was_kept"], true);
  found["was_kept"] = false;
  EXPECT_EQ(found, stepped);

  // Damaged bytes and a start with another key are not used.
  const std::map<std::string, std::string> good = kept;
  kept.begin()->second[kept.begin()->second.size() / 2] ^= 1;
  EXPECT_GT(baked("third", {}), 12u + 6u);
  bar.scene.motion.preroll = 0.2;
  kept = good;
  EXPECT_GT(baked("fourth", {}), 12u + 12u);
  EXPECT_EQ(kept.size(), 2u);
}

}  // namespace
}  // namespace fascicle::tests
