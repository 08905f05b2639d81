// The manual page and the shell completions, generated from the options.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace fascicle::cli {

// fascicle(1), in man macros (groff_man(7)).
std::string manual_page(const CLI::App& app);
std::string bash_completion(const CLI::App& app);
std::string zsh_completion(const CLI::App& app);
std::string fish_completion(const CLI::App& app);

}  // namespace fascicle::cli
