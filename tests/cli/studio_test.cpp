// fascicle studio as a user starts and ends it. tests/studio covers its conversation with the page.
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/cli/program.h"
#include "tests/studio/client.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

// A loopback socket; port 0 picks a free port.
class LoopbackSocket {
 public:
  explicit LoopbackSocket(std::uint16_t port) : descriptor_(::socket(AF_INET, SOCK_STREAM, 0)) {
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address_.sin_port = htons(port);
  }
  ~LoopbackSocket() { ::close(descriptor_); }
  LoopbackSocket(const LoopbackSocket&) = delete;
  LoopbackSocket& operator=(const LoopbackSocket&) = delete;

  bool connects() { return ::connect(descriptor_, plain(), sizeof address_) == 0; }
  std::uint16_t listen() {
    EXPECT_EQ(::bind(descriptor_, plain(), sizeof address_), 0);
    EXPECT_EQ(::listen(descriptor_, 1), 0);
    socklen_t size = sizeof address_;
    EXPECT_EQ(::getsockname(descriptor_, plain(), &size), 0);
    return ntohs(address_.sin_port);
  }

 private:
  sockaddr* plain() { return reinterpret_cast<sockaddr*>(&address_); }
  int descriptor_;
  sockaddr_in address_{};
};

std::uint16_t free_port() {
  return LoopbackSocket(0).listen();
}

void wait_until_open(std::uint16_t port, Program& program) {
  wait_until(program, [&] { return LoopbackSocket(port).connects(); });
}

TEST(StudioProgram, PrintsItsAddressAndEndsWithASignal) {
  const TemporaryFolder folder;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const std::uint16_t port = free_port();
    Program program({"studio", "bar-beta-1", "--headless", "--port", std::to_string(port), "-o",
                     folder / "session", "--device", "cpu"});
    wait_until_open(port, program);
    program.send(signal);
    const Outcome outcome = program.wait();
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const std::string begin = "http://127.0.0.1:" + std::to_string(port) + "/#";
    EXPECT_EQ(outcome.out.substr(0, begin.size()), begin);
    // A token of 32 digits and a newline, and nothing else.
    EXPECT_EQ(outcome.out.size(), begin.size() + 33) << outcome.out;
  }
}

TEST(StudioProgram, AFolderIsOneStudiosAndAPortToo) {
  const TemporaryFolder folder;
  const std::uint16_t port = free_port();
  Program first({"studio", "bar-beta-1", "--headless", "--port", std::to_string(port), "-o",
                 folder / "session", "--device", "cpu"});
  wait_until_open(port, first);
  const Outcome same_folder =
      fascicle({"studio", "bar-beta-1", "--headless", "-o", folder / "session", "--device", "cpu"});
  EXPECT_EQ(same_folder.status, 2);
  EXPECT_TRUE(contains(same_folder.err, "another fascicle is writing there")) << same_folder.err;
  const Outcome same_port = fascicle({"studio", "bar-beta-1", "--headless", "--port", std::to_string(port),
                                      "-o", folder / "other", "--device", "cpu"});
  EXPECT_EQ(same_port.status, 2);
  EXPECT_TRUE(contains(same_port.err, "cannot listen")) << same_port.err;
  first.send(SIGINT);
  EXPECT_EQ(first.wait().status, 0);
}

// Every user of a machine can read the command lines of all processes.
TEST(StudioProgram, TheTokenStandsInNoCommandLine) {
  const TemporaryFolder folder;
  write_text(folder / "xdg-open",
             "#!/bin/sh\ncd '" + folder.path().string() +
                 "'\ncp \"$1\" seen.html\nstat -c %a \"$1\" > mode\necho \"$@\" > line.part\n"
                 "mv line.part line\n");
  fs::permissions(folder / "xdg-open", fs::perms::owner_all);
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", (folder.path().string() + ":" + path).c_str(), 1);
  Program program({"studio", "bar-beta-1", "-o", folder / "session", "--device", "cpu"});
  ::setenv("PATH", path.c_str(), 1);
  wait_for_file(program, folder / "line");
  program.send(SIGINT);
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  std::string address = outcome.out.substr(0, outcome.out.find('\n'));
  const std::string line = read_text(folder / "line"), token = address.substr(address.find('#') + 1);
  EXPECT_EQ(token.size(), 32u);
  EXPECT_FALSE(contains(line, token)) << line;
  EXPECT_TRUE(contains(read_text(folder / "seen.html"), "url=" + address + "\""));
  EXPECT_EQ(read_text(folder / "mode"), "600\n");
  EXPECT_FALSE(fs::exists(line.substr(0, line.find('\n')))) << "the file outlives the studio";
}

TEST(StudioProgram, WhatCannotBeOpenedIsSaid) {
  const TemporaryFolder folder;
  const Outcome no_bake = fascicle({"studio", folder.path().string(), "--headless"});
  EXPECT_EQ(no_bake.status, 3);
  EXPECT_TRUE(contains(no_bake.err, "holds no bake")) << no_bake.err;
  const Outcome no_scene = fascicle({"studio", "bar-beta-11", "--headless"});
  EXPECT_EQ(no_scene.status, 3);
  EXPECT_TRUE(contains(no_scene.err, "bar-beta-1")) << no_scene.err;
  const Outcome nothing_beside = fascicle(
      {"studio", "bar-beta-1", "--headless", "--beside", folder.path().string(), "-o", folder / "session"});
  EXPECT_EQ(nothing_beside.status, 3);
  EXPECT_TRUE(contains(nothing_beside.err, "--beside takes a bake's folder")) << nothing_beside.err;
  EXPECT_EQ(fascicle({"studio", "bar-beta-1", "--headless", "--port", "65536"}).status, 2);
  EXPECT_EQ(fascicle({"studio", "bar-beta-1", "--headless", "--device", "cuda"}).status, 2);
  EXPECT_EQ(fascicle({"studio", "bar-beta-1", "--headless", "-o", "/proc/nowhere"}).status, 3);
}

// `auto` takes no software device, so this one claims to be a GPU. It is lost at the given call.
std::vector<std::string> lost_at(int call, const std::string& cache) {
  return {"VK_INSTANCE_LAYERS=VK_LAYER_FASCICLE_faults",
          "VK_LAYER_PATH=" FASCICLE_FAULT_LAYER_FOLDER,
          "NODEVICE_SELECT=1",
          "FASCICLE_FAULT_DISCRETE=1",
          "FASCICLE_CACHE_DIR=" + cache,
          "FASCICLE_FAULT=" + std::to_string(call) + " -4"};
}

// At one call after another, of which the first ones come before the page opens.
TEST(StudioProgram, OpensWithTheCpuIfTheGpuFails) {
  NEEDS_VULKAN();
  long told = 0;
  for (const int call : {15, 50, 80, 120, 160, 200, 250, 300}) {
    SCOPED_TRACE("call " + std::to_string(call));
    const TemporaryFolder folder;
    const std::uint16_t port = free_port();
    Program program(
        {"studio", "bar-hang-along", "--headless", "--port", std::to_string(port), "-o", folder / "session"},
        lost_at(call, folder / "cache"));
    wait_until_open(port, program);
    program.send(SIGTERM);
    const Outcome outcome = program.wait();
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    told += contains(outcome.err, "; the CPU takes over") ? 1 : 0;
  }
  EXPECT_GT(told, 0);
}

// A page of a studio whose GPU is lost while it is open.
class LostGpu : public testing::Test {
 protected:
  void open(int call) {
    const std::uint16_t port = free_port();
    program_ =
        std::make_unique<Program>(std::vector<std::string>{"studio", "bar-hang-along", "--headless", "--port",
                                                           std::to_string(port), "-o", folder_ / "session"},
                                  lost_at(call, folder_ / "cache"));
    wait_until_open(port, *program_);
    std::string address;
    wait_until(*program_, [&] {
      address = program_->printed();
      return address.ends_with('\n');
    });
    const std::string token = address.substr(address.find('#') + 1);
    page_ = std::make_unique<Client>(port, token.substr(0, token.size() - 1));
    EXPECT_TRUE(contains(page_->wait_for("hello").at("device"), "vulkan:0, "));
  }
  // Until a frame shows it.
  void change(const std::string& path, double value) {
    page_->say({{"type", "set"}, {"changes", {{path, value}}}});
    const std::uint32_t revision = seen("changed").at("revision");
    while (seen("applied").at("revision") < revision) {
    }
  }
  // The next message of a type; notes on the way whether the CPU took over.
  Json seen(const std::string& type) {
    while (const auto message = page_->next()) {
      if (!message->is_text) continue;
      Json said = Json::parse(message->bytes);
      EXPECT_NE(said.value("what", ""), "change") << said;
      has_cpu_ = has_cpu_ || said.at("type") == "device";
      if (said.at("type") == type) return said;
    }
    ADD_FAILURE() << "no message \"" << type << "\" came";
    return {};
  }
  void is_with_cpu() {
    const std::string device = page_->wait_for("device").at("device");
    EXPECT_TRUE(device.starts_with("cpu, ") && contains(device, "the GPU failed")) << device;
  }
  // The whole clip has the bits of a bake, so the body is the one that the page has asked for.
  void records_what_is_baked(const std::string& beta) {
    page_->say({{"type", "record"}});
    const Json recorded = page_->wait_for("recorded");
    const Outcome baked = fascicle({"bake", "bar-hang-along", "-o", folder_ / "bake", "--device", "cpu", "-q",
                                    "--set", "layers.body.beta=" + beta, "--set", "scene.end=0.5"});
    ASSERT_EQ(baked.status, 0) << baked.err;
    const Json manifest = Json::parse(read_text(folder_ / "bake/manifest.json"));
    EXPECT_EQ(recorded.at("position_hash"), manifest.at("position_hashes").back());
  }
  void end() {
    program_->send(SIGTERM);
    const Outcome outcome = program_->wait();
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "vulkan:0: ") && contains(outcome.err, "; the CPU takes over"))
        << outcome.err;
  }

  const TemporaryFolder folder_;
  std::unique_ptr<Program> program_;
  std::unique_ptr<Client> page_;
  bool has_cpu_ = false;
};

TEST_F(LostGpu, TheCpuPlaysOn) {
  NEEDS_VULKAN();
  open(700);
  is_with_cpu();
  // Playback was interrupted.
  while (page_->wait_for("player").at("state") != "playing") {
  }
  for (int k = 0; k < 10; ++k) page_->wait_for_frame([](const std::string& bytes) { return bytes[0] == 1; });
  change("scene.end", 0.5);
  records_what_is_baked("1");
  end();
}

TEST_F(LostGpu, TheCpuTakesTheChangeThatMetTheLoss) {
  NEEDS_VULKAN();
  // Far more calls than it takes to open the page and to pause.
  open(2000);
  page_->say({{"type", "pause"}});
  while (page_->wait_for("player").at("state") != "paused") {
  }
  change("scene.end", 0.5);
  EXPECT_FALSE(has_cpu_) << "lost before the changes began";
  // Every change makes a solver, until one of them meets the loss.
  std::string beta;
  for (int k = 1; k <= 100 && !has_cpu_; ++k) {
    beta = k % 2 == 0 ? "0.5" : "0.7";
    change("layers.body.beta", std::stod(beta));
  }
  EXPECT_TRUE(has_cpu_);
  records_what_is_baked(beta);
  end();
}

TEST_F(LostGpu, TheHandLetsGo) {
  NEEDS_VULKAN();
  open(1500);
  page_->say({{"type", "hand"},
              {"action", "grab"},
              {"vertex", 100},
              {"place", {0.0, -0.2, 0.1}},
              {"of", "vertices"}});
  EXPECT_TRUE(seen("hand").at("is_held"));
  EXPECT_FALSE(has_cpu_) << "lost before the hand held anything";
  EXPECT_FALSE(seen("hand").at("is_held"));
  if (!has_cpu_) is_with_cpu();
  change("scene.end", 0.5);
  records_what_is_baked("1");
  end();
}

TEST_F(LostGpu, WhatIsPausedStaysSo) {
  NEEDS_VULKAN();
  open(1500);
  page_->say({{"type", "speed"}, {"factor", 2}});
  is_with_cpu();
  page_->say({{"type", "pause"}});
  change("scene.end", 0.5);
  page_->say({{"type", "pause"}, {"id", 1}});
  page_->wait_for("done");
  page_->say({{"type", "loop"}, {"on", true}});
  EXPECT_EQ(page_->wait_for("player").at("state"), "paused");
  records_what_is_baked("1");
  end();
}

TEST_F(LostGpu, ARecordingCanBeMadeAgain) {
  NEEDS_VULKAN();
  open(1500);
  page_->say({{"type", "record"}});  // of ten seconds: more than the calls that are left
  is_with_cpu();
  change("scene.end", 0.5);
  records_what_is_baked("1");
  end();
}

}  // namespace
}  // namespace fascicle::tests
