// fascicle schema: the JSON Schema of the scene file, or a readable version of it.
#include <iostream>
#include <memory>

#include "host/cli/command.h"

namespace fascicle::cli {

void add_schema(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand("schema", "Print the JSON Schema of the scene file");
  add_log_options(*subcommand, command.log);
  auto markdown = std::make_shared<bool>(false);
  subcommand->add_flag("--markdown", *markdown, "Print every key as Markdown instead");
  subcommand->callback([&command, markdown] {
    command.run = [markdown](Log&) {
      const std::string text = *markdown ? scene::scene_reference() : scene::scene_schema();
      std::cout << text << (text.ends_with('\n') ? "" : "\n");
      return ExitCode::done;
    };
  });
}

}  // namespace fascicle::cli
