// The pages in the program match their sources, according to esbuild, TypeScript and node.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/program.h"
#include "tests/support/web.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

const fs::path bundle(FASCICLE_SOURCE_DIR "/web/bundle/view.html");

TEST(WebBundle, IsWhatTheSourcesGive) {
  FASCICLE_NEEDS_WEB_TOOLS;
  const TemporaryFolder folder;
  ASSERT_EQ(run_web("node build.mjs rebuilt", folder / "log"), 0) << read_text(folder / "log");
  EXPECT_TRUE(read_text(web_tools() / "rebuilt/view.html") == read_text(bundle))
      << "web/bundle/view.html is out of date; run ./do web";
}

TEST(WebBundle, CarriesTheNoticeOfThreeAndReachesForNothing) {
  const std::string page = read_text(bundle);
  EXPECT_TRUE(contains(page, "three.js authors"));
  EXPECT_TRUE(contains(page, "The above copyright notice and this permission notice shall be included"));
  EXPECT_TRUE(contains(page, "default-src 'none'"));
  EXPECT_FALSE(contains(page, "unsafe-inline"));
  EXPECT_FALSE(contains(page, "unsafe-eval"));
  for (const char* outside : {"src=\"http", "href=\"http", "@import", "import("})
    EXPECT_FALSE(contains(page, outside)) << outside;
  // The limit is 1 MB gzipped; 1 MB unpacked is stricter.
  EXPECT_LT(page.size(), 1'000'000u);
}

// The lock file pins packages by their content, and names no host.
TEST(WebBundle, ItsToolsArePinned) {
  const std::string lock = read_text(fs::path(FASCICLE_SOURCE_DIR) / "web/package-lock.json");
  EXPECT_FALSE(contains(lock, "resolved"));
  EXPECT_FALSE(contains(lock, "http"));
  const nlohmann::json tools =
      nlohmann::json::parse(read_text(fs::path(FASCICLE_SOURCE_DIR) / "web/package.json"));
  for (const char* kind : {"dependencies", "devDependencies"})
    for (const auto& [name, version] : tools[kind].items())
      EXPECT_EQ(version.get<std::string>().find_first_not_of("0123456789."), std::string::npos) << name;
}

TEST(WebSources, HaveTheTypesTheySay) {
  FASCICLE_NEEDS_WEB_TOOLS;
  const TemporaryFolder folder;
  EXPECT_EQ(run_web("npx --no-install tsc --noEmit", folder / "log"), 0) << read_text(folder / "log");
}

TEST(WebSources, PassTheirTests) {
  FASCICLE_NEEDS_WEB_TOOLS;
  const TemporaryFolder folder;
  EXPECT_EQ(run_web("node test.mjs", folder / "log"), 0) << read_text(folder / "log");
}

}  // namespace
}  // namespace fascicle::tests
