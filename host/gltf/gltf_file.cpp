#include "host/gltf/gltf_file.h"

#include <span>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "host/base/errors.h"
#include "host/base/file.h"
#include "host/base/helper_program.h"
#include "host/base/text.h"
#include "host/gltf/convert.h"
#include "host/rig/character.h"

namespace fascicle::gltf {
namespace {

constexpr std::size_t deepest_nesting = 64;
constexpr std::size_t most_values = 10'000'000;

std::uint32_t little_endian(const std::vector<unsigned char>& bytes, std::size_t at) {
  return static_cast<std::uint32_t>(bytes[at]) | static_cast<std::uint32_t>(bytes[at + 1]) << 8 |
         static_cast<std::uint32_t>(bytes[at + 2]) << 16 | static_cast<std::uint32_t>(bytes[at + 3]) << 24;
}

constexpr std::uint32_t magic_glb = 0x46546C67, chunk_json = 0x4E4F534A, chunk_binary = 0x004E4942;

// Bounds a JSON text before it is parsed: nesting, for the stack, and the number of values, for memory. A
// separate pass, because the library's callback during parsing takes time quadratic in an array's length.
class Bounds final : public nlohmann::json_sax<nlohmann::json> {
 public:
  explicit Bounds(const std::filesystem::path& path) : path_(path) {}

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const string_t&) override { return value(); }
  bool string(string_t&) override { return value(); }
  bool binary(binary_t&) override { return value(); }
  bool key(string_t&) override { return true; }
  bool start_object(std::size_t) override { return start(); }
  bool start_array(std::size_t) override { return start(); }
  bool end_object() override { return end(); }
  bool end_array() override { return end(); }
  // The parser that follows reports syntax errors.
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    return false;
  }

 private:
  bool value() {
    if (depth_ > deepest_nesting) {
      gltf_error(path_, "/", "the JSON is nested deeper than " + std::to_string(deepest_nesting) + " levels");
    }
    if (++values_ > most_values)
      gltf_error(path_, "/", "the JSON has more than " + std::to_string(most_values) + " values");
    return true;
  }
  bool start() {
    value();
    ++depth_;
    return true;
  }
  bool end() {
    --depth_;
    return true;
  }

  const std::filesystem::path& path_;
  std::size_t depth_ = 0, values_ = 0;
};

nlohmann::json parse(const std::filesystem::path& path, const unsigned char* text, std::size_t size) {
  Bounds bounds(path);
  nlohmann::json::sax_parse(text, text + size, &bounds);
  try {
    return nlohmann::json::parse(text, text + size);
  } catch (const nlohmann::json::exception& error) {
    gltf_error(path, "/", std::string("not valid JSON: ") + error.what());
  }
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

bool is_inside(const std::filesystem::path& folder, const std::filesystem::path& file) {
  auto f = file.begin();
  for (const auto& part : folder) {
    if (f == file.end() || *f != part) return false;
    ++f;
  }
  return f != file.end();
}

// What a file that is neither kind of glTF is instead, and what to do; empty if that is unclear.
std::string other_kind(std::span<const unsigned char> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.empty()) return "is empty; export it again";
  if (text.starts_with("version https://git-lfs"))
    return "is a pointer of Git LFS, and the file itself is not here; `git lfs pull` gets it";
  if (text.starts_with("Kaydara FBX Binary")) return "is an FBX file; give it a name that ends in .fbx";
  const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first == std::string_view::npos || text[first] != '{')
    return "is not glTF, which begins with `glTF` or, as text, with `{`; export it again";
  return {};
}

// `path` is only for messages.
GltfFile parse_gltf(const std::filesystem::path& path, const std::vector<unsigned char>& bytes) {
  GltfFile file;
  file.path = path;
  if (bytes.size() < 4 || little_endian(bytes, 0) != magic_glb) {
    if (const std::string other = other_kind(bytes); !other.empty())
      throw base::SceneError(path.string() + " " + other);
    file.document = parse(path, bytes.data(), bytes.size());
    return file;
  }

  const auto fail = [&](std::size_t at, const std::string& what) {
    gltf_error(path, "byte " + std::to_string(at), what);
  };
  if (bytes.size() < 20)
    fail(0, "a GLB needs at least 20 bytes, the file has " + std::to_string(bytes.size()));
  if (little_endian(bytes, 4) != 2)
    fail(4, "GLB version " + std::to_string(little_endian(bytes, 4)) + "; only 2 is read");
  if (little_endian(bytes, 8) != bytes.size()) {
    fail(8, "the header says " + std::to_string(little_endian(bytes, 8)) + " bytes, the file has " +
                std::to_string(bytes.size()) + "; it is truncated or damaged");
  }
  std::size_t at = 12, chunk = 0;
  while (at < bytes.size()) {
    if (bytes.size() - at < 8) fail(at, "a chunk's header is cut off");
    const std::size_t length = little_endian(bytes, at);
    const std::uint32_t type = little_endian(bytes, at + 4);
    const std::size_t left = bytes.size() - at - 8;
    if (length > left) {
      fail(at, "a chunk of " + std::to_string(length) + " bytes where " + std::to_string(left) + " are left");
    }
    const unsigned char* data = bytes.data() + at + 8;
    if (chunk == 0 && type != chunk_json) fail(at + 4, "the first chunk must hold JSON");
    if (chunk > 0 && type == chunk_json) fail(at + 4, "a second JSON chunk");
    if (type == chunk_json) file.document = parse(path, data, length);
    if (chunk == 1 && type == chunk_binary) {
      file.has_binary = true;
      file.binary.assign(data, data + length);
    }
    at += 8 + length;
    ++chunk;
  }
  return file;
}

// The converter's notes contain names from the file, so their number is untrusted.
std::vector<std::string> notes_of(const nlohmann::json& document) {
  constexpr std::size_t most_notes = 20;
  const nlohmann::json all =
      document.value(nlohmann::json::json_pointer("/asset/extras/notes"), nlohmann::json::array());
  std::vector<std::string> notes;
  for (const nlohmann::json& note : all) {
    if (!note.is_string()) continue;
    if (notes.size() == most_notes) {
      notes.push_back("and " + std::to_string(all.size() - most_notes) + " more of this kind");
      break;
    }
    std::string text = note.get<std::string>();
    for (char& c : text)
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    notes.push_back(std::move(text));
  }
  return notes;
}

// The converted document is not cached: reading the file again converts it again, in a fraction of a second.
GltfFile read_converted(const std::filesystem::path& path, const std::filesystem::path& converter) try {
  const base::TemporaryFolder folder;
  const std::filesystem::path glb = folder.path() / "character.glb";
  convert_character(path, glb, {.program = converter});
  GltfFile file = parse_gltf(path, base::read_input_bytes(glb, gltf_largest_file));
  file.notes = notes_of(file.document);
  return file;
} catch (const base::InputError& error) {
  throw base::SceneError(path.string() + ": as converted, it " + error.reason);
} catch (const std::system_error& error) {
  fail_to_convert(path, error.what());
}

// False for what cannot be read; reading it says why.
bool is_glb_file(const std::filesystem::path& path) {
  try {
    std::string head(4, '\0');
    return base::File(path, base::FileMode::read).read_at(0, head) && head == "glTF";
  } catch (const std::runtime_error&) {
    return false;
  }
}

}  // namespace

void gltf_error(const std::filesystem::path& path, const std::string& pointer, const std::string& what) {
  // Both may quote the file.
  throw base::SceneError(path.string() + ": " + base::shown_text(pointer + ": " + what));
}

GltfFile read_gltf_file(const std::filesystem::path& path, const std::filesystem::path& converter) {
  if (is_convertible_file(path)) {
    if (is_glb_file(path))
      throw base::SceneError(path.string() + " is glTF; give it a name that ends in .glb");
    return read_converted(path, converter);
  }
  return parse_gltf(path, base::read_input_bytes(path, gltf_largest_file));
}

std::filesystem::path gltf_buffer_file(const std::filesystem::path& gltf, const std::string& pointer,
                                       const std::string& uri) {
  const auto fail = [&](const std::string& what) {
    gltf_error(gltf, pointer, "`" + uri.substr(0, 100) + "` " + what);
  };
  const std::string advice = "; buffers must be files in the folder of the glTF file";
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      name += uri[i];
      continue;
    }
    const int high = i + 1 < uri.size() ? hex_digit(uri[i + 1]) : -1;
    const int low = i + 2 < uri.size() ? hex_digit(uri[i + 2]) : -1;
    if (high < 0 || low < 0) fail("has a `%` without two hexadecimal digits");
    const char c = static_cast<char>(high * 16 + low);
    // An honest file name never needs these encoded; encoding them only serves to bypass a check.
    if (c == '/' || c == '\\' || c == '.' || c == '%' || c == ':') {
      fail("hides `" + std::string(1, c) + "` behind percent-encoding" + advice);
    }
    name += c;
    i += 2;
  }
  for (const char c : name) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) fail("has a control character");
  }
  if (name.empty()) fail("names no file");
  if (name.find('\\') != std::string::npos) fail("has a backslash; separate folders with `/`");
  if (name.find(':') != std::string::npos) fail("has a scheme or drive" + advice);
  if (name.front() == '/') fail("is an absolute path" + advice);
  const std::filesystem::path relative(name);
  for (const auto& part : relative) {
    if (part == "..") fail("leads out of the folder" + advice);
  }

  std::error_code error;
  const std::filesystem::path folder = std::filesystem::canonical(
      gltf.has_parent_path() ? gltf.parent_path() : std::filesystem::path("."), error);
  if (error) fail("lies in a folder that cannot be opened: " + error.message());
  const std::filesystem::path file = std::filesystem::canonical(folder / relative, error);
  if (error) fail("cannot be opened: " + error.message());
  if (!is_inside(folder, file)) fail("leads out of the folder through a symbolic link" + advice);
  return file;
}

std::vector<unsigned char> read_gltf_buffer(const std::filesystem::path& gltf, const std::string& pointer,
                                            const std::string& uri,
                                            std::vector<std::filesystem::path>& files_read) {
  const std::filesystem::path file = gltf_buffer_file(gltf, pointer, uri);
  try {
    std::vector<unsigned char> bytes = base::read_input_bytes(file, gltf_largest_file, base::Links::refused);
    files_read.push_back(file);
    return bytes;
  } catch (const base::InputError& refused) {
    gltf_error(gltf, pointer, "`" + uri.substr(0, 100) + "` " + refused.reason);
  }
}

}  // namespace fascicle::gltf
