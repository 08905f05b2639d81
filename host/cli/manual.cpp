// fascicle manual: the files that a package installs with the program. Hidden, because only build scripts use
// it.
#include "host/cli/manual.h"

#include <algorithm>
#include <iostream>
#include <memory>
#include <vector>

#include "host/bake/bake.h"
#include "host/bake/outputs.h"
#include "host/base/version.h"
#include "host/cli/command.h"
#include "host/cli/text.h"

namespace fascicle::cli {
namespace {

// An option, with what each shell's completion needs.
struct Described {
  std::vector<std::string> names;  // with their dashes; empty: a positional
  std::string positional;          // its name
  std::string value;               // name of its value; empty: a flag
  std::string text;
  bool is_list = false;  // of formats, separated by commas
  bool takes_file = false;
};

// Subcommands that --help lists.
std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_group().empty(); });
}

std::vector<Described> options_of(const CLI::App& app);

// A command's options, plus those of its subcommands without duplicates: shells complete them alike.
std::vector<Described> all_options_of(const CLI::App& app) {
  std::vector<Described> result = options_of(app);
  for (const CLI::App* command : commands_of(app))
    for (Described& option : options_of(*command)) {
      const auto has_its_name = [&](const Described& known) { return known.names == option.names; };
      if (std::none_of(result.begin(), result.end(), has_its_name)) result.push_back(std::move(option));
    }
  return result;
}

std::vector<Described> options_of(const CLI::App& app) {
  std::vector<Described> result;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    Described described;
    for (const std::string& name : option->get_snames()) described.names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) described.names.push_back("--" + name);
    if (described.names.empty()) described.positional = option->get_name();
    described.text = option->get_description();
    if (option->get_items_expected_max() > 0) {
      described.value = option->get_option_text();
      if (described.value.empty() || described.value == " ") described.value = option->get_type_name();
    }
    const auto has = [&](const char* name) {
      return std::find(described.names.begin(), described.names.end(), name) != described.names.end();
    };
    described.is_list = has("--format") || has("--to");
    described.takes_file = !described.positional.empty() || described.value == "DIR" ||
                           described.value == "FILE" || has("--output") || has("--model");
    result.push_back(std::move(described));
  }
  return result;
}

// Literal text in roff: dashes stay dashes, and no line starts with a control character.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n'))
      out += std::string("\\&") + c;
    else
      out += c;
  }
  return out;
}

std::string roff_option(const Described& option) {
  std::string line;
  for (const std::string& name : option.names)
    line += (line.empty() ? "" : ", ") + ("\\fB" + roff(name) + "\\fR");
  if (option.names.empty()) line = "\\fI" + roff(option.positional) + "\\fR";
  if (!option.value.empty() && !option.names.empty()) line += " \\fI" + roff(option.value) + "\\fR";
  return ".TP\n" + line + "\n" + roff(option.text) + "\n";
}

std::string first_sentence(const std::string& text) {
  return text.substr(0, std::min(text.find(';'), text.size()));
}

std::string joined(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + word;
  return line;
}

std::string names_of_commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : commands_of(app)) names.push_back(command->get_name());
  return joined(names);
}

std::string names_of_options(const std::vector<Described>& options) {
  std::vector<std::string> names;
  for (const Described& option : options) names.insert(names.end(), option.names.begin(), option.names.end());
  return joined(names);
}

std::string scene_names() {
  std::vector<std::string> names;
  for (const scene::BuiltinScene& scene : scene::builtin_scenes()) names.push_back(scene.name);
  return joined(names);
}

}  // namespace

std::string manual_page(const CLI::App& app) {
  std::string page = ".\\\" Made by `fascicle manual man`.\n.TH FASCICLE 1 \"\" \"fascicle " +
                     std::string(base::fascicle_version) + "\" \"User Commands\"\n.SH NAME\nfascicle \\- " +
                     "bake how muscle and fat of animated characters move\n.SH SYNOPSIS\n"
                     ".B fascicle\n.I COMMAND\n[\\fIOPTIONS\\fR]\n.SH DESCRIPTION\n" +
                     roff(app.get_description()) + "\n.SH OPTIONS\n";
  for (const Described& option : options_of(app)) page += roff_option(option);
  page += ".SH COMMANDS\n";
  for (const CLI::App* command : commands_of(app)) {
    page += ".SS fascicle " + roff(command->get_name()) + "\n" + roff(command->get_description()) + "\n";
    for (const Described& option : options_of(*command)) page += roff_option(option);
    for (const CLI::App* own : commands_of(*command)) {
      page += ".SS fascicle " + roff(command->get_name() + " " + own->get_name()) + "\n" +
              roff(own->get_description()) + "\n";
      for (const Described& option : options_of(*own)) page += roff_option(option);
    }
  }
  page += ".SH EXIT STATUS\n" + roff(app.get_footer()) +
          "\n.SH ENVIRONMENT\n.TP\n.B FASCICLE_CACHE_DIR\n"
          "Folder for filled bodies, starts and compiled shaders; without it $XDG_CACHE_HOME/fascicle or "
          "~/.cache/fascicle.\n.SH SEE ALSO\n"
          "The scene file's keys: \\fBfascicle schema\\fR; those of a character: \\fBfascicle scenes "
          "CHARACTER\\fR.\n";
  return page;
}

std::string bash_completion(const CLI::App& app) {
  std::string text =
      "# bash completion of fascicle; made by `fascicle manual bash`.\n"
      "_fascicle() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} options= own=\n"
      "  COMPREPLY=()\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
      "    COMPREPLY=($(compgen -W " +
      in_quotes(names_of_commands(app) + " " + names_of_options(options_of(app))) +
      " -- \"$word\"))\n    return\n  fi\n"
      "  case $before in\n    --format|--to)\n"
      "      local head=\n      [[ $word != *,* ]] || head=${word%,*},\n"
      "      COMPREPLY=($(compgen -P \"$head\" -W " +
      in_quotes(joined(bake::format_names())) +
      " -- \"${word##*,}\"))\n      return;;\n  esac\n  case ${COMP_WORDS[1]} in\n";
  for (const CLI::App* command : commands_of(app))
    text += "    " + command->get_name() +
            ") options=" + in_quotes(names_of_options(all_options_of(*command))) +
            (commands_of(*command).empty() ? "" : " own=" + in_quotes(names_of_commands(*command))) + ";;\n";
  return text +
         "  esac\n"
         "  if [[ $word == -* ]]; then\n    COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n"
         "  else\n    COMPREPLY=($(compgen -W \"$own \"" +
         in_quotes(scene_names()) +
         " -- \"$word\") $(compgen -f -- \"$word\"))\n  fi\n}\n"
         "complete -o filenames -F _fascicle fascicle\n";
}

std::string zsh_completion(const CLI::App& app) {
  // Colons and brackets are special in _arguments.
  const auto escaped = [](const std::string& text) {
    std::string out;
    for (const char c : text)
      out += c == ':' || c == '[' || c == ']' ? std::string("\\") + c : std::string(1, c);
    return out;
  };
  const auto argument = [&](const Described& option, const std::string& name) {
    std::string spec = "*" + name + "[" + escaped(first_sentence(option.text)) + "]";
    if (option.value.empty()) return in_quotes(spec);
    spec += ":" + escaped(option.value) + ":";
    if (option.is_list) return in_quotes(spec + "_values -s , format " + joined(bake::format_names()));
    return in_quotes(spec + (option.takes_file ? "_files" : ""));
  };
  std::string text =
      "#compdef fascicle\n# Made by `fascicle manual zsh`.\n_fascicle() {\n  local -a commands=(\n";
  for (const CLI::App* command : commands_of(app))
    text += "    " + in_quotes(command->get_name() + ":" + escaped(command->get_description())) + "\n";
  text +=
      "  )\n  if (( CURRENT == 2 )); then\n    _describe command commands\n    return\n  fi\n  case "
      "$words[2] in\n";
  for (const CLI::App* command : commands_of(app)) {
    text += "    " + command->get_name() + ") shift words; (( CURRENT-- )); _arguments";
    const std::string own = commands_of(*command).empty() ? "" : names_of_commands(*command) + " ";
    for (const Described& option : all_options_of(*command)) {
      for (const std::string& name : option.names) text += " \\\n      " + argument(option, name);
      if (option.names.empty())
        text +=
            " \\\n      " + in_quotes("*:" + escaped(option.positional) + ":_alternative 'scenes:scene:(" +
                                      own + scene_names() + ")' 'files:file:_files'");
    }
    text += ";;\n";
  }
  return text + "  esac\n}\n_fascicle \"$@\"\n";
}

std::string fish_completion(const CLI::App& app) {
  // Within '...', fish has two escapes of its own, unlike other shells.
  const auto fish = [](const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    return out + "'";
  };
  std::string text = "# fish completion of fascicle; made by `fascicle manual fish`.\n";
  const auto line = [&](const std::string& condition, const Described& option) {
    std::string out = "complete -c fascicle -n " + fish(condition);
    for (const std::string& name : option.names)
      out += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    if (!option.value.empty()) out += option.takes_file ? " -r" : " -x";
    if (option.is_list) out += " -a " + fish("(__fish_append , " + joined(bake::format_names()) + ")");
    return out + " -d " + fish(first_sentence(option.text)) + "\n";
  };
  for (const Described& option : options_of(app))
    if (!option.names.empty()) text += line("__fish_use_subcommand", option);
  for (const CLI::App* command : commands_of(app)) {
    text += "complete -c fascicle -f -n __fish_use_subcommand -a " + command->get_name() + " -d " +
            fish(command->get_description()) + "\n";
    const std::string here = "__fish_seen_subcommand_from " + command->get_name();
    const std::string own = commands_of(*command).empty() ? "" : names_of_commands(*command) + " ";
    for (const Described& option : all_options_of(*command))
      text += option.names.empty()
                  ? "complete -c fascicle -n " + fish(here) + " -a " + fish(own + scene_names()) + "\n"
                  : line(here, option);
  }
  return text;
}

void add_manual(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand("manual", "Print the manual page, or a shell's completions");
  subcommand->group("");
  const auto kind = std::make_shared<std::string>("man");
  subcommand->add_option("KIND", *kind, "man, bash, zsh or fish")
      ->check(CLI::IsMember({"man", "bash", "zsh", "fish"}).description(""));
  subcommand->callback([&app, &command, kind] {
    command.run = [&app, kind](Log&) {
      std::cout << (*kind == "bash"   ? bash_completion(app)
                    : *kind == "zsh"  ? zsh_completion(app)
                    : *kind == "fish" ? fish_completion(app)
                                      : manual_page(app));
      return ExitCode::done;
    };
  });
}

}  // namespace fascicle::cli
