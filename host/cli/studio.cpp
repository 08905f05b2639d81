// fascicle studio: a page on loopback that shows moving flesh and lets the user touch it.
#include "host/studio/studio.h"

#include <cstdlib>
#include <iostream>
#include <memory>
#include <string_view>
#include <system_error>

#include <unistd.h>

#include "host/bake/folder.h"
#include "host/base/private_file.h"
#include "host/base/process.h"
#include "host/cli/command.h"
#include "host/cli/interrupt.h"
#include "host/cli/text.h"
#include "host/pipeline/bake_scene.h"
#include "host/pipeline/device_choice.h"
#include "host/studio/bundle.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;

struct StudioArguments {
  SceneArguments scene;
  std::string folder;
  std::vector<std::string> beside;
  std::string device = "auto";
  unsigned threads = 0;
  std::uint16_t port = 0;
  bool headless = false;
};

// The path of a program given by name; empty if it is not on PATH.
fs::path on_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path != nullptr ? path : "";
  while (!rest.empty()) {
    const std::size_t colon = rest.find(':');
    const fs::path file = fs::path(rest.substr(0, colon)) / program;
    if (file.is_absolute() && ::access(file.c_str(), X_OK) == 0) return file;
    rest.remove_prefix(colon == std::string_view::npos ? rest.size() : colon + 1);
  }
  return {};
}

// A file that redirects a browser to the address while the studio runs. The address contains the token, and
// any user of the machine can read a command line, so the browser is started with this file instead, which
// only its owner can read.
class WayToAddress {
 public:
  WayToAddress(fs::path file, const std::string& address) : file_(std::move(file)) {
    base::write_private(file_,
                        "<!doctype html><meta charset=\"utf-8\"><title>fascicle studio</title>"
                        "<meta name=\"referrer\" content=\"no-referrer\">"
                        "<meta http-equiv=\"refresh\" content=\"0; url=" +
                            address + "\"><a href=\"" + address + "\">the studio</a>\n");
  }
  ~WayToAddress() {
    std::error_code ignored;
    fs::remove(file_, ignored);
  }
  WayToAddress(const WayToAddress&) = delete;
  WayToAddress& operator=(const WayToAddress&) = delete;
  const fs::path& file() const { return file_; }

 private:
  fs::path file_;
};

// Optional, since the address is printed anyway. `folder`: the session's; empty: none.
std::unique_ptr<WayToAddress> open_browser(const std::string& address, const fs::path& folder, Log& log) {
  const fs::path opener = on_path("xdg-open");
  if (opener.empty()) {
    log.info("xdg-open was not found; open the address in a browser");
    return nullptr;
  }
  try {
    const std::string name = "fascicle-studio-" + std::to_string(::getpid()) + ".html";
    auto way = std::make_unique<WayToAddress>(
        fs::absolute(folder.empty() ? fs::temp_directory_path() : folder) / name, address);
    base::start_process({opener.string(), way->file().string()}, base::no_output);
    return way;
  } catch (const std::system_error& error) {
    log.info(std::string("the browser could not be started: ") + error.what());
    return nullptr;
  }
}

std::unique_ptr<studio::Session> open_session(StudioArguments arguments, Log& log) {
  const Say say = say_on(log);
  if (arguments.scene.name.empty()) arguments.scene.name = scene::default_scene;
  const fs::path input(arguments.scene.name);
  std::error_code none;
  std::vector<fs::path> beside;
  for (const std::string& folder : arguments.beside) {
    if (!bake::holds_bake(folder))
      throw bake::BakeError(folder + ": holds no bake; --beside takes a bake's folder");
    beside.emplace_back(folder);
  }
  if (fs::is_directory(input, none)) {
    if (!bake::holds_bake(input))
      throw bake::BakeError(input.string() + ": holds no bake; give a bake's folder, a scene or a character");
    if (scene::has_overrides(arguments.scene.overrides))
      throw UsageError("a bake's frames cannot be changed; leave out the scene options, or open its scene");
    return std::make_unique<studio::Session>(input, std::move(beside), say);
  }
  const std::vector<DeviceRequest> devices = parse_device_order(arguments.device);
  scene::Scene scene = load(arguments.scene);
  if (arguments.folder.empty()) arguments.folder = (fs::path("out") / (scene.name + "-studio")).string();
  refuse_unwritable("-o", (fs::path(arguments.folder) / "").string(), true);
  studio::SessionOptions options;
  options.folder = arguments.folder;
  options.device = devices.front();
  options.device.cache = build_options(arguments.scene.no_cache).cache;
  options.device.keeps_pipelines = !options.device.cache.empty();
  options.threads = arguments.threads;
  options.build = build_options(arguments.scene.no_cache);
  options.beside = std::move(beside);
  return std::make_unique<studio::Session>(std::move(scene), std::move(options), say);
}

ExitCode run_studio(const StudioArguments& arguments, Log& log) {
  const std::atomic<bool>& interrupted = interrupts();
  catch_hangups();
  log.info("loading and building; the address follows when the studio is ready");
  const std::unique_ptr<studio::Session> session = open_session(arguments, log);
  std::unique_ptr<WayToAddress> way;
  const auto ready = [&](const std::string& address) {
    std::cout << address << std::endl;
    if (arguments.headless) return;
    log.info("studio of " + shown_text(session->name()) + (session->is_restored() ? ", as it was left" : "") +
             "; Ctrl-C ends it, and changes are kept");
    way = open_browser(address, session->folder(), log);
  };
  try {
    studio::run_studio(*session, {.port = arguments.port, .page = studio::page_bundle()}, interrupted, ready);
  } catch (const std::system_error& error) {
    if (arguments.port == 0) throw;
    throw UsageError("--port " + std::to_string(arguments.port) + ": " + error.what() + "; choose another");
  }
  return ExitCode::done;
}

}  // namespace

void add_studio(CLI::App& app, Command& command) {
  auto* subcommand =
      app.add_subcommand("studio", "Preview and tune flesh in the browser while it moves; save and bake");
  const auto arguments = std::make_shared<StudioArguments>();
  add_scene_options(
      *subcommand, arguments->scene,
      std::string("Scene file, mesh, character or built-in name, or the folder of a bake; default: ") +
          scene::default_scene,
      false);
  subcommand
      ->add_option("-o,--output", arguments->folder,
                   "Folder of the session, for changes, saved scenes and bakes; default: out/NAME-studio")
      ->option_text("DIR");
  subcommand
      ->add_option(
          "--beside", arguments->beside,
          "Folder of a bake to play beside the scene, in sync; repeatable, and the page chooses among them")
      ->option_text("DIR")
      ->allow_extra_args(false)
      ->take_all();
  subcommand->add_option("--port", arguments->port, "Port on the loopback interface; default: any free port")
      ->check(CLI::Range(0, 65535).description(""))
      ->option_text("N");
  subcommand->add_flag("--headless", arguments->headless, "Print the address and do not open a browser");
  subcommand
      ->add_option(
          "--device", arguments->device,
          "auto, cpu, cpu:LEVEL, vulkan or vulkan:N; auto is a real GPU if there is one, else the CPU")
      ->option_text("NAME");
  subcommand->add_option("--threads", arguments->threads, "Threads of the CPU solver; 0: one per core")
      ->check(CLI::Range(0U, 1024U).description(""))
      ->option_text("N");
  add_log_options(*subcommand, command.log);
  subcommand->callback([arguments, &command] {
    command.watches_interrupts = true;
    command.run = [arguments](Log& log) { return run_studio(*arguments, log); };
  });
}

}  // namespace fascicle::cli
