// fascicle paint: writes a paint file's values as attributes into the character's own file.
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "host/base/file.h"
#include "host/cli/command.h"
#include "host/cli/text.h"
#include "host/formats/painted_gltf.h"
#include "host/gltf/gltf.h"
#include "host/pipeline/bake_scene.h"
#include "host/scene/input_files.h"
#include "host/scene/paint_file.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;

struct PaintArguments {
  std::string character, paint, output;
  bool overwrite = false;
};

void refuse_output(const PaintArguments& arguments) {
  const fs::path path(arguments.output);
  if (base::lower_extension(path) != ".glb")
    throw UsageError("-o " + arguments.output +
                     ": a painted character is a .glb; give a name that ends in .glb");
  if (fs::is_directory(path)) throw UsageError(arguments.output + ": is a folder; choose another -o");
  if (!arguments.overwrite && fs::exists(path))
    throw UsageError(arguments.output + ": already exists; --overwrite replaces it, or choose another -o");
  refuse_unwritable("-o", arguments.output);
}

ExitCode write_painted(const PaintArguments& arguments, Log& log) try {
  refuse_output(arguments);
  const fs::path file(arguments.character), paint_file(arguments.paint);
  if (!scene::reads_as_character(file))
    throw UsageError(arguments.character +
                     ": is not a character; characters are .glb, .gltf, .vrm, .fbx or "
                     ".dae");
  rig::Character character = gltf::read_gltf(file);
  const rig::Paint paint = scene::parse_paint(scene::read_text_file(paint_file, scene::most_paint_bytes),
                                              paint_file, character.surface);
  rig::lay_over(paint, character);
  std::vector<std::string> missing;
  base::write_whole_beside_others(fs::absolute(arguments.output),
                                  formats::painted_glb(file, character, paint, missing));
  for (const std::string& image : missing)
    log.warning(image + ": not found next to the character; a white pixel replaces it");
  std::string painted;
  for (const rig::PaintedVertices& attribute : paint.attributes)
    painted += (painted.empty() ? "" : ", ") + attribute.name + " on " + count_text(attribute.vertex.size());
  std::cout << "wrote " << arguments.output << ": of " << count_text(paint.vertices) << " vertices "
            << (painted.empty() ? "none is painted" : painted) << "\n";
  return ExitCode::done;
} catch (const scene::InputFileError& error) {
  throw scene::SceneError(error.what());
}

}  // namespace

void add_paint(CLI::App& app, Command& command) {
  auto* subcommand =
      app.add_subcommand("paint", "Write a character with the contents of a paint file as glTF attributes");
  const auto arguments = std::make_shared<PaintArguments>();
  subcommand->add_option("CHARACTER", arguments->character, "The character that was painted")
      ->required()
      ->option_text(" ");
  subcommand->add_option("PAINT", arguments->paint, "The paint file, as in character.paint")
      ->required()
      ->option_text(" ");
  subcommand->add_option("-o,--output", arguments->output, "The file to write, NAME.glb")
      ->required()
      ->option_text("FILE");
  subcommand->add_flag("--overwrite", arguments->overwrite, "Replace an existing file");
  add_log_options(*subcommand, command.log);
  subcommand->callback([arguments, &command] {
    command.run = [arguments](Log& log) { return write_painted(*arguments, log); };
  });
}

}  // namespace fascicle::cli
