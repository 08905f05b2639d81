#include "host/scene/convert.h"

#include <system_error>

#include "host/scene/file.h"
#include "host/scene/helper_program.h"
#include "host/scene/scene.h"

namespace fascicle::scene {
namespace {

constexpr const char* converter_name = "fascicle-convert";
constexpr int out_of_memory = 6;  // as its --help has it

// The largest characters at hand take a quarter of a second and 200 MiB.
constexpr ProcessLimits converter_limits{.seconds = 120.0, .bytes = std::uint64_t{4} << 30};

std::string what_failed(const ProcessResult& result) {
  if (result.end == ProcessEnd::timed_out)
    return "took longer to convert than the 120 s of processor time allowed";
  if (result.end == ProcessEnd::stalled)
    return "was not converted: the converter got no processor time for 120 s; see what holds up this machine";
  if (result.end == ProcessEnd::signalled)
    return "cannot be read: the converter crashed on it (signal " + std::to_string(result.code) + ")";
  if (result.code == out_of_memory) return "cannot be read: it needs more than 4 GiB of memory";
  const std::string reason = last_line(result, converter_name);
  return "cannot be read: " + (reason.empty() ? "status " + std::to_string(result.code) : reason);
}

}  // namespace

bool is_convertible_file(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".fbx" || extension == ".dae";
}

bool can_convert() {
  return !find_helper(converter_name).empty();
}

std::string conversion_by_hand(const std::filesystem::path& path) {
  const std::string glb = std::filesystem::path(path).replace_extension(".glb").filename().string();
  return (lower_extension(path) == ".fbx" ? "Convert it with FBX2glTF, or import it in Blender and export `"
                                          : "Import it in Blender and export `") +
         glb + "`, with its armature and animations (File > Export > glTF 2.0)";
}

void convert_character(const std::filesystem::path& input, const std::filesystem::path& output) {
  ProcessResult result;
  try {
    result = run_process(find_helper(converter_name),
                         {std::filesystem::absolute(input).string(), output.string()}, converter_limits);
  } catch (const std::system_error& error) {
    throw SceneError(input.string() + ": " + converter_name + " cannot be started: " + error.what());
  }
  if (result.end != ProcessEnd::exited || result.code != 0)
    throw SceneError(input.string() + ": " + what_failed(result) + ". " + conversion_by_hand(input));
}

}  // namespace fascicle::scene
