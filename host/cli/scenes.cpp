// fascicle scenes: the built-in scenes, listed or printed as files.
#include <iostream>
#include <memory>

#include "host/cli/command.h"
#include "host/cli/text.h"

namespace fascicle::cli {
namespace {

ExitCode scenes(const std::string& name) {
  if (name.empty()) {
    std::vector<std::pair<std::string, std::string>> rows;
    for (const scene::BuiltinScene& scene : scene::builtin_scenes())
      rows.emplace_back(scene.name,
                        scene.description + (scene.name == scene::default_scene ? " (default)" : ""));
    std::cout << columns_text(rows);
    return ExitCode::done;
  }
  for (const scene::BuiltinScene& scene : scene::builtin_scenes())
    if (scene.name == name) {
      std::cout << scene.text;
      if (!scene.text.ends_with('\n')) std::cout << '\n';
      return ExitCode::done;
    }
  throw scene::SceneError("there is no built-in scene \"" + name + "\"" + nearest_scene_hint(name));
}

}  // namespace

void add_scenes(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand("scenes", "List the built-in scenes, or print one as a scene file");
  const auto name = std::make_shared<std::string>();
  subcommand->add_option("NAME", *name, "The scene to print")->option_text(" ");
  add_log_options(*subcommand, command.log);
  subcommand->callback([name, &command] { command.run = [name](Log&) { return scenes(*name); }; });
}

}  // namespace fascicle::cli
