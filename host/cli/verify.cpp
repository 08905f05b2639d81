// fascicle verify: reads a bake's folder completely and checks it against its checksums.
#include "host/bake/verify.h"

#include <iostream>
#include <memory>

#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/cli/command.h"
#include "host/cli/interrupt.h"
#include "host/cli/progress.h"
#include "host/cli/text.h"

namespace fascicle::cli {
namespace {

struct VerifyArguments {
  std::string bake;
  bool json = false;
};

void print_json(const bake::VerifyResult& result) {
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  for (const bake::VerifiedFile& file : result.files)
    files.push_back({{"file", file.name}, {"good", file.is_good}, {"finding", file.finding}});
  std::cout << nlohmann::ordered_json{{"status", result.status},
                                      {"in_use_here", result.in_use_here},
                                      {"good", result.is_good()},
                                      {"files", files}}
                   .dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
            << "\n";
}

void print_text(const bake::VerifyResult& result) {
  std::vector<std::pair<std::string, std::string>> rows;
  for (const bake::VerifiedFile& file : result.files)
    rows.emplace_back(file.name, (file.is_good ? "" : "WRONG: ") + file.finding);
  std::cout << columns_text(rows);
}

ExitCode verify(const VerifyArguments& arguments, Log& log) {
  std::unique_ptr<Progress> progress;
  const bake::VerifyResult result =
      bake::verify_bake({.bake = arguments.bake,
                         .interrupted = &interrupts(),
                         .on_frame = [&](std::uint64_t frame, std::uint64_t frames) {
                           if (!progress) progress = std::make_unique<Progress>(log, "reading", frames);
                           progress->update(frame);
                         }});
  log.clear_bar();
  if (result.interrupted) {
    log.warning("interrupted; not everything was checked");
    return ExitCode::interrupted;
  }
  arguments.json ? print_json(result) : print_text(result);
  if (!result.is_good())
    throw base::BakeError(arguments.bake +
                          ": the bake is damaged or incomplete; --resume writes again what it can "
                          "from good frames, otherwise bake again with --overwrite");
  if (!arguments.json)
    std::cout
        << arguments.bake << ": all files present are intact; the bake "
        << (result.status == "running" && !result.in_use_here
                ? "says that it is running, but nothing on this computer writes there; if nothing elsewhere "
                  "does, it was killed, and --resume continues it"
                : "is " + result.status)
        << "\n";
  return ExitCode::done;
}

}  // namespace

void add_verify(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand("verify", "Check the files of a bake against their checksums");
  const auto arguments = std::make_shared<VerifyArguments>();
  subcommand->add_option("DIR", arguments->bake, "Folder of a bake")->required()->option_text(" ");
  subcommand->add_flag("--json", arguments->json, "Print one JSON object");
  add_log_options(*subcommand, command.log);
  subcommand->callback([arguments, &command] {
    command.watches_interrupts = true;
    command.run = [arguments](Log& log) { return verify(*arguments, log); };
  });
}

}  // namespace fascicle::cli
