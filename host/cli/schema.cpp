// fascicle schema: the JSON Schema of the scene file.
#include <iostream>

#include "host/cli/command.h"

namespace fascicle::cli {

void add_schema(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand("schema", "Print the JSON Schema of the scene file");
  add_log_options(*subcommand, command.log);
  subcommand->callback([&command] {
    command.run = [](Log&) {
      const std::string schema = scene::scene_schema();
      std::cout << schema << (schema.ends_with('\n') ? "" : "\n");
      return ExitCode::done;
    };
  });
}

}  // namespace fascicle::cli
