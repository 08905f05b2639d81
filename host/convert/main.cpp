// fascicle-convert: converts characters in other formats to glTF with assimp, in a separate process.
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/version.h>
#include <fcntl.h>
#include <unistd.h>

#include "host/base/pending_output.h"
#include "host/base/sandbox.h"
#include "host/convert/character.h"
#include "host/convert/failure.h"
#include "host/convert/gltf.h"

namespace fascicle::convert {
namespace {

namespace fs = std::filesystem;

constexpr const char* help =
    "fascicle-convert turns characters with their skins and clips into glTF (assimp).\n"
    "\n"
    "  fascicle-convert IN.fbx|IN.dae OUT.glb\n"
    "      Metres, Y up, at rest in the pose that the skins were bound in.\n"
    "  fascicle-convert --help | --version\n"
    "\n"
    "Exit status: 0 done, 2 bad usage, 3 the file cannot be read, 4 the result cannot be written, 6 out of "
    "memory.\n";

constexpr std::uintmax_t largest_file = std::uintmax_t{1} << 30;

std::string bytes_of(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) throw Failure(unreadable, "is not a file");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) throw Failure(unreadable, "cannot be read: " + error.message());
  if (size > largest_file)
    throw Failure(unreadable, "has " + std::to_string(size) + " bytes, more than the " +
                                  std::to_string(largest_file) + " that are read");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Failure(unreadable, "cannot be opened; check its permissions");
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (in.bad()) throw Failure(unreadable, "cannot be read to its end");
  if (bytes.empty()) throw Failure(unreadable, "it is empty");
  return bytes;
}

std::string extension_of(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (extension.empty()) return extension;
  return extension.substr(1);
}

// Assimp guesses formats by content. Keeps only the one asked for, because others open further files.
void keep_only(Assimp::Importer& importer, const std::string& extension) {
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
    const aiImporterDesc* description = importer.GetImporterInfo(i);
    const std::string own = " " + std::string(description->mFileExtensions) + " ";
    if (own.find(" " + extension + " ") == std::string::npos)
      importer.UnregisterLoader(importer.GetImporter(i));
  }
}

std::string glb_from(const fs::path& input) {
  const std::string extension = extension_of(input);
  const std::string bytes = bytes_of(input);
  Assimp::Importer importer;
  keep_only(importer, extension);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_CAMERAS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_LIGHTS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, true);
  const aiScene* scene =
      importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate, extension.c_str());
  if (scene == nullptr || scene->mRootNode == nullptr) {
    // Assimp catches exceptions; without this, running out of memory would look like a bad file.
    if (const std::exception_ptr& thrown = importer.GetException()) std::rethrow_exception(thrown);
    throw Failure(unreadable, importer.GetErrorString());
  }
  Character character = character_of(*scene, source_of(bytes, extension == "fbx"));
  const std::string glb = glb_of(character, input);
  if (glb.size() > largest_file)
    throw Failure(unreadable, "would be larger than the largest glTF that is read");
  return glb;
}

void convert(const fs::path& input, const fs::path& output) {
  const std::string extension = extension_of(input);
  if (extension != "fbx" && extension != "dae")
    throw Failure(bad_usage, input.string() + " is neither .fbx nor .dae");
  if (extension_of(output) != "glb")
    throw Failure(bad_usage, output.string() + " does not end in .glb, the only format written");
  std::error_code ignored;
  if (fs::equivalent(input, output, ignored))
    throw Failure(bad_usage, output.string() + " is also the input; give another name");
  const auto not_written = [&](const std::system_error& error) {
    return Failure(cannot_write, output.string() + " cannot be written: " + error.code().message() +
                                     "; check its folder and the free space");
  };
  std::optional<base::PendingOutput> pending;
  try {
    pending.emplace(output.string());
  } catch (const std::system_error& error) {
    throw not_written(error);
  }
  // The file is untrusted, and assimp was not written for untrusted input.
  base::enter_sandbox({input.string()}, output.string());
  std::string glb;
  try {
    glb = glb_from(input);
  } catch (const Failure& failure) {
    throw Failure(failure.exit_code, input.string() + ": " + failure.what());
  } catch (const std::bad_alloc&) {
    throw Failure(out_of_memory, input.string() + ": out of memory");
  } catch (const std::exception& error) {
    throw Failure(unreadable, input.string() + ": " + error.what());
  }
  try {
    pending->finish(glb);
  } catch (const std::system_error& error) {
    throw not_written(error);
  }
}

int run(const std::vector<std::string>& arguments) {
  if (arguments.size() == 1 && (arguments[0] == "--help" || arguments[0] == "-h")) {
    std::fputs(help, stdout);
  } else if (arguments.size() == 1 && arguments[0] == "--version") {
    std::printf("fascicle-convert " FASCICLE_VERSION " (assimp %u.%u)\n", aiGetVersionMajor(),
                aiGetVersionMinor());
    std::printf("sandbox: %s\n", base::sandbox_words().c_str());
  } else if (arguments.size() == 2) {
    convert(arguments[0], arguments[1]);
  } else {
    throw Failure(bad_usage, "expected two file names; see --help");
  }
  return done;
}

// Opens standard input, output and error on /dev/null if they are closed: otherwise the next files opened
// would get their numbers. Makes a write beyond the file size limit fail, as on a full disk.
void prepare() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) < 0 && ::open("/dev/null", O_RDWR) != stream) std::_Exit(EXIT_FAILURE);
  std::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace
}  // namespace fascicle::convert

int main(int argument_count, char** arguments) {
  fascicle::convert::prepare();
  using fascicle::convert::Failure;
  try {
    return fascicle::convert::run(std::vector<std::string>(arguments + 1, arguments + argument_count));
  } catch (const Failure& failure) {
    std::fprintf(stderr, "fascicle-convert: %s\n", failure.what());
    return failure.exit_code;
  } catch (const std::bad_alloc&) {
    std::fputs("fascicle-convert: out of memory\n", stderr);
    return fascicle::convert::out_of_memory;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fascicle-convert: %s\n", error.what());
    return fascicle::convert::unreadable;
  }
}
