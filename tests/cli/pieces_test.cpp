// Parts of the command line that can be called directly: device requests, their candidates, numbers as text.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/cli/child_bake.h"
#include "host/cli/compare_devices.h"
#include "host/cli/exit_codes.h"
#include "host/cli/log.h"
#include "host/cli/rigid_rows.h"
#include "host/cli/text.h"
#include "host/pipeline/device_choice.h"

namespace fascicle::tests {
namespace {

using cli::DeviceRequest;

gpu::DeviceInfo device(std::uint32_t index, bool software, bool usable) {
  gpu::DeviceInfo info;
  info.index = index;
  info.software = software;
  info.usable = usable;
  return info;
}

std::vector<std::uint32_t> indices(const std::string& request, const std::vector<gpu::DeviceInfo>& devices) {
  std::vector<std::uint32_t> found;
  for (const gpu::DeviceInfo& info : cli::candidates(cli::parse_device(request), devices))
    found.push_back(info.index);
  return found;
}

TEST(DeviceChoice, RequestsAreParsed) {
  EXPECT_EQ(cli::parse_device("auto").kind, DeviceRequest::Kind::automatic);
  EXPECT_EQ(cli::parse_device("cpu").kind, DeviceRequest::Kind::cpu);
  EXPECT_EQ(cli::parse_device("cpu").simd, cpu_reference::Simd::automatic);
  EXPECT_EQ(cli::parse_device("cpu:scalar").simd, cpu_reference::Simd::scalar);
  EXPECT_EQ(cli::parse_device("cpu:avx2").kind, DeviceRequest::Kind::cpu);
  EXPECT_FALSE(cli::parse_device("vulkan").index.has_value());
  EXPECT_EQ(cli::parse_device("vulkan:12").index, 12u);
  for (const char* bad : {"", "gpu", "vulkan:", "vulkan:-1", "vulkan: 1", "vulkan:99999999999", "cpu ",
                          "cpu:", "cpu:auto", "cpu:mmx"})
    EXPECT_THROW(cli::parse_device(bad), cli::UsageError) << bad;
  EXPECT_EQ(cli::parse_device_list("cpu,vulkan,vulkan:1").size(), 3u);
  for (const char* bad : {"", ",cpu", "cpu,", "cpu,auto"})
    EXPECT_THROW(cli::parse_device_list(bad), cli::UsageError) << bad;
}

// A laptop's loader may list the small GPU of its display first.
TEST(DeviceChoice, DiscreteDevicesAndMoreMemoryComeFirst) {
  std::vector<gpu::DeviceInfo> devices;
  const auto add = [&](const char* type, std::uint64_t gibibytes) {
    devices.push_back(device(static_cast<std::uint32_t>(devices.size()), false, true));
    devices.back().type = type;
    devices.back().memory = gibibytes << 30;
  };
  add("integrated", 60);
  add("discrete", 2);
  add("virtual", 16);
  add("discrete", 80);
  add("discrete", 80);
  EXPECT_EQ(indices("auto", devices), (std::vector<std::uint32_t>{3, 4, 1, 2, 0}));
  EXPECT_EQ(indices("vulkan:0", devices), (std::vector<std::uint32_t>{0}));
}

TEST(DeviceChoice, RealDevicesComeFirstAndAutoTakesNoSoftware) {
  const std::vector<gpu::DeviceInfo> devices{device(0, true, true), device(1, false, false),
                                             device(2, false, true), device(3, false, true)};
  using Indices = std::vector<std::uint32_t>;
  EXPECT_EQ(indices("auto", devices), (Indices{2, 3}));
  EXPECT_EQ(indices("vulkan", devices), (Indices{2, 3, 0}));
  EXPECT_EQ(indices("vulkan:1", devices), (Indices{1}));
  EXPECT_EQ(indices("vulkan:9", devices), Indices{});
  EXPECT_EQ(indices("cpu", devices), Indices{});
}

TEST(Validation, OneDifferenceIsEnough) {
  cli::Validation validation;
  validation.comparisons.emplace_back();
  validation.oracle.emplace_back();
  EXPECT_TRUE(validation.holds());
  validation.comparisons[0].hashes.first_different_frame = 3;
  EXPECT_FALSE(validation.holds());
  validation.comparisons[0].hashes.first_different_frame.reset();
  validation.comparisons[0].difference.emplace();
  EXPECT_FALSE(validation.holds());
  validation.comparisons[0].difference.reset();
  validation.oracle[0].relative = 1.01 * cli::oracle_bound;
  EXPECT_FALSE(validation.holds());
  validation.oracle[0].relative = std::nan("");
  EXPECT_FALSE(validation.holds());
  // A device that is not exact must meet the bound, not the bits.
  validation.oracle.clear();
  validation.comparisons[0].exact = false;
  validation.comparisons[0].difference.emplace();
  validation.comparisons[0].relative = 0.5 * cli::oracle_bound;
  EXPECT_TRUE(validation.holds());
  validation.comparisons[0].relative = 2.0 * cli::oracle_bound;
  EXPECT_FALSE(validation.holds());
}

TEST(Text, NumbersAsPeopleReadThem) {
  EXPECT_EQ(cli::count_text(0), "0");
  EXPECT_EQ(cli::count_text(999), "999");
  EXPECT_EQ(cli::count_text(1234567), "1,234,567");
  EXPECT_EQ(cli::counted_text(1, "vertex", "vertices"), "1 vertex");
  EXPECT_EQ(cli::counted_text(0, "vertex", "vertices"), "0 vertices");
  EXPECT_EQ(cli::counted_text(1234, "vertex", "vertices"), "1,234 vertices");
  EXPECT_EQ(cli::bytes_text(1023), "1023 bytes");
  EXPECT_EQ(cli::bytes_text(1536), "1.5 KiB");
  EXPECT_EQ(cli::bytes_text(std::uint64_t{80} << 30), "80 GiB");
  EXPECT_EQ(cli::duration_text(0.25), "0.25 s");
  EXPECT_EQ(cli::duration_text(59.4), "59 s");
  EXPECT_EQ(cli::duration_text(200), "3 min 20 s");
  EXPECT_EQ(cli::duration_text(7500), "2 h 05 min");
  EXPECT_EQ(cli::duration_text(std::nan("")), "unknown");
  EXPECT_EQ(cli::bits_text(1.0f), "0x3f800000");
  EXPECT_EQ(cli::float_text(0.1f), "0.100000001");
}

TEST(Text, ColumnsAlignAfterLettersOfSeveralBytes) {
  EXPECT_EQ(cli::columns_text({{"h\u00fcfte.x", "a"}, {"spine.x", "b"}, {"\u8155.L", "c"}}),
            "  h\u00fcfte.x  a\n  spine.x  b\n  \u8155.L     c\n");
}

// Hair is often made of many equal cards.
TEST(RigidRows, EqualPartsShareALine) {
  const build::RigidReport eye{"Eye", "Head", "requested", 360}, card{"Hair", "Head", "a separate part", 24},
      bun{"Hair", "Head", "a separate part", 25}, dot{"Dot", "Hand", "requested", 1};
  const cli::RigidRows all = cli::rigid_rows({eye, card, card, bun, card, dot}, 20);
  using Rows = std::vector<std::pair<std::string, std::string>>;
  EXPECT_EQ(all.rows, (Rows{{"Eye", "follows Head, 360 vertices; requested"},
                            {"Hair", "3 parts follow Head, each of 24 vertices; a separate part"},
                            {"Hair", "follows Head, 25 vertices; a separate part"},
                            {"Dot", "follows Hand, 1 vertex; requested"}}));
  EXPECT_EQ(all.left_out, 0u);
  // The rows that are left out count by their parts.
  const cli::RigidRows first = cli::rigid_rows({eye, card, card, bun, card, dot}, 1);
  EXPECT_EQ(first.rows, (Rows{all.rows[0]}));
  EXPECT_EQ(first.left_out, 5u);
}

TEST(Log, AdvanceSaysShareRateAndTimeLeft) {
  const cli::Advance half{.what = "baking", .done = 60, .total = 120, .rate = 30.0, .seconds_left = 2.0};
  EXPECT_EQ(cli::advance_text(half, 0), "baking  50 %  frame 60/120  30 frames/s  2.00 s left");
  EXPECT_EQ(cli::advance_text(half, 4), "baking  [##--]  50 %  frame 60/120  30 frames/s  2.00 s left");
  const cli::Advance unknown{.what = "baking", .done = 0, .total = 0, .rate = 0.0, .seconds_left = -1.0};
  EXPECT_EQ(cli::advance_text(unknown, 0), "baking  100 %  frame 0/0");
}

TEST(ChildLog, OnlyLinesOfOurLogAreRead) {
  const auto said = cli::read_log_line(
      R"({"time":0.5,"level":"progress","message":"baking","frame":3,"frames":9,"rate":null,"eta":1.5})");
  ASSERT_TRUE(said);
  EXPECT_EQ(said->level, "progress");
  EXPECT_EQ(said->message, "baking");
  EXPECT_EQ(said->frame, 3u);
  EXPECT_EQ(said->frames, 9u);
  for (const char* line : {"", "words", "[1]", "{}", "3", "null", R"({"level":3,"message":"m","time":1})",
                           R"({"level":"error","message":{"a":1},"time":1})",
                           R"({"level":"error","message":"m"})", R"({"level":null,"time":null})"})
    EXPECT_FALSE(cli::read_log_line(line)) << line;
  for (const char* line : {R"({"time":1,"level":"progress","message":"m","frame":"3","frames":{}})",
                           R"({"time":1,"level":"progress","message":"m","frame":-3,"frames":1e30})"}) {
    const auto odd = cli::read_log_line(line);
    ASSERT_TRUE(odd) << line;
    EXPECT_FALSE(odd->frame || odd->frames) << line;
  }
}

}  // namespace
}  // namespace fascicle::tests
