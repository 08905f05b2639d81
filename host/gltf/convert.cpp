#include "host/gltf/convert.h"

#include <cstring>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "host/base/errors.h"
#include "host/base/file.h"
#include "host/base/helper_program.h"
#include "host/rig/character.h"

namespace fascicle::gltf {
namespace {

constexpr const char* converter_name = "fascicle-convert";
constexpr int cannot_write = 4, out_of_memory = 6;  // exit codes listed in its --help

// The last line of its output names the input file; callers add that name themselves.
std::string reason_of(const base::ProcessResult& result, const std::string& given) {
  const std::string name = std::string(converter_name) + ": ";
  const std::string reason = base::last_line(result, name + given);
  return reason.rfind(name, 0) == 0 ? base::last_line(result, converter_name) : reason;
}

// "120 s", "4 GiB", "0.3 s".
std::string amount(double value, const char* unit) {
  std::ostringstream text;
  text << value << ' ' << unit;
  return text.str();
}

std::string what_failed(const base::ProcessResult& result, const base::ProcessLimits& limits,
                        const std::string& given) {
  const std::string seconds = amount(limits.seconds, "s");
  if (result.end == base::ProcessEnd::timed_out)
    return "took longer to convert than the " + seconds + " of processor time allowed";
  if (result.end == base::ProcessEnd::stalled)
    return "was not converted: the converter got no processor time for " + seconds +
           "; see what keeps this machine busy";
  if (result.end == base::ProcessEnd::signalled)
    return "cannot be read: the converter crashed on it (signal " + std::to_string(result.code) + ")";
  if (result.code == out_of_memory)
    return "cannot be read: it needs more than " +
           amount(static_cast<double>(limits.bytes) / static_cast<double>(std::uint64_t{1} << 30), "GiB") +
           " of memory";
  const std::string reason = reason_of(result, given);
  return "cannot be read: " + (reason.empty() ? "status " + std::to_string(result.code) : reason);
}

}  // namespace

bool is_convertible_file(const std::filesystem::path& path) {
  const std::string extension = base::lower_extension(path);
  return extension == ".fbx" || extension == ".dae";
}

bool can_convert() {
  return !base::find_helper(converter_name).empty();
}

std::string conversion_by_hand(const std::filesystem::path& path) {
  const std::string glb = std::filesystem::path(path).replace_extension(".glb").filename().string();
  return (base::lower_extension(path) == ".fbx"
              ? "Convert it with FBX2glTF, or import it in Blender and export `"
              : "Import it in Blender and export `") +
         glb + "`, with its armature and animations (File > Export > glTF 2.0)";
}

void fail_to_convert(const std::filesystem::path& input, const std::string& what) {
  throw std::runtime_error(
      input.string() + ": cannot run " + converter_name + ": " + what +
      "; check the free space and permissions of the folder for temporary files (TMPDIR)");
}

void convert_character(const std::filesystem::path& input, const std::filesystem::path& output,
                       const Converter& converter) {
  const std::filesystem::path program =
      converter.program.empty() ? base::find_helper(converter_name) : converter.program;
  if (!converter.program.empty() && !base::is_program(program))
    throw base::SceneError(program.string() + ": no such program; give the path of " + converter_name);
  const std::string given = std::filesystem::absolute(input).string();
  base::ProcessResult result;
  try {
    result = base::run_process(program, {given, output.string()}, converter.limits);
  } catch (const std::system_error& error) {
    fail_to_convert(input, error.what());
  }
  if (base::was_killed_from_outside(result))
    throw std::runtime_error(input.string() + ": " + converter_name + " was killed from outside (" +
                             ::strsignal(result.code) +
                             ") while converting it, often for lack of memory; free or request more memory, "
                             "and try again");
  if (result.end == base::ProcessEnd::exited && result.code == cannot_write)
    fail_to_convert(input, reason_of(result, given));
  if (result.end != base::ProcessEnd::exited || result.code != 0)
    throw base::SceneError(input.string() + ": " + what_failed(result, converter.limits, given) + ". " +
                           conversion_by_hand(input));
}

}  // namespace fascicle::gltf
