// A running studio of a scene, and a page connected to it.
#pragma once

#include <atomic>
#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "host/base/file.h"
#include "host/studio/studio.h"
#include "tests/studio/client.h"
#include "tests/studio/decoded.h"

namespace fascicle::tests {

namespace fs = std::filesystem;

inline constexpr const char* bar_text = R"(# A bar that hangs from a wall.
[scene]
fps = 60      # frames a second
end = 0.5

[bar]
size = [0.4, 0.1, 0.1]
vertices = [9, 3, 3]

[layers.body]
frequency = 6.0   # Hz: the bar's own
damping = 8.0

[pin.wall]
where = { below = { axis = "x", fraction = 0.0 } }

[probe.tip]
where = { above = { axis = "x", fraction = 1.0 } }
)";

// Runs the studio of a scene on its own thread.
class Running {
 public:
  Running(const std::string& scene, const fs::path& folder, const fs::path& cache,
          std::vector<fs::path> beside = {}) {
    studio::SessionOptions options;
    options.folder = folder;
    options.device = {.kind = pipeline::DeviceRequest::Kind::cpu};
    options.threads = 2;
    options.build.mesher = fs::path(FASCICLE_BINARY_DIR) / "fascicle-mesher";
    options.build.cache = cache;
    options.beside = std::move(beside);
    session_ = std::make_unique<studio::Session>(scene::load_scene(scene), options, pipeline::Say());
    start();
  }
  explicit Running(const fs::path& bake, std::vector<fs::path> beside = {}) {
    session_ = std::make_unique<studio::Session>(bake, std::move(beside), pipeline::Say());
    start();
  }
  ~Running() {
    stops_ = true;
    thread_.join();
  }

  std::uint16_t port() const { return port_; }
  const std::string& token() const { return token_; }
  std::unique_ptr<Client> open(const ClientOptions& options = {}) const {
    return std::make_unique<Client>(port_, token_, options);
  }

 private:
  void start() {
    std::promise<std::string> address;
    std::future<std::string> ready = address.get_future();
    thread_ = std::thread([this, &address] {
      studio::run_studio(*session_, {.page = {{"", "text/html", "page"}}}, stops_,
                         [&](const std::string& text) { address.set_value(text); });
    });
    const std::string text = ready.get();
    const std::size_t colon = text.rfind(':'), hash = text.find("/#");
    port_ = static_cast<std::uint16_t>(std::stoi(text.substr(colon + 1)));
    token_ = text.substr(hash + 2);
  }

  std::unique_ptr<studio::Session> session_;
  std::atomic<bool> stops_ = false;
  std::thread thread_;
  std::uint16_t port_ = 0;
  std::string token_;
};

// All messages sent at the start.
struct Start {
  std::map<std::string, Json> messages;
  std::map<std::string, DecodedArray> arrays;
};
inline Start start_of(Client& client) {
  Start start;
  while (const auto message = client.next()) {
    if (message->is_text) {
      const Json json = Json::parse(message->bytes);
      start.messages[json.at("type")] = json;
      if (json.at("type") == "ready") break;
    } else if (message->bytes[0] == 2) {
      DecodedArray array = decode_array(message->bytes);
      start.arrays[array.name] = std::move(array);
    }
  }
  EXPECT_EQ(start.messages.count("ready"), 1u);
  return start;
}

inline Json key_of(const Json& keys, const std::string& path) {
  for (const Json& group : keys.at("groups"))
    for (const Json& key : group.at("keys"))
      if (key.at("path") == path) return key;
  return nullptr;
}

class SessionTest : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("fascicle-studio-" + std::string(info->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    scene_ = folder_ / "bar.toml";
    base::write_whole(scene_, bar_text);
  }
  void TearDown() override { fs::remove_all(folder_); }

  Running open() { return Running(scene_.string(), folder_ / "session", folder_ / "cache"); }
  std::string read(const fs::path& path) { return base::read_input(path, 1 << 24); }

  fs::path folder_, scene_;
};

}  // namespace fascicle::tests
