# Writes OUTPUT, a C++ file with the texts of the scene files in SCENES (separated by "|") as raw string literals, so that
# the executable needs no data files beside it.
string(REPLACE "|" ";" SCENES "${SCENES}")
set(code "// Made by embed_scenes.cmake from scenes/*.toml.\n#include \"host/scene/builtin_scenes.h\"\n\n")
string(APPEND code "namespace fascicle::scene {\n\nstd::span<const EmbeddedScene> embedded_scenes() {\n")
string(APPEND code "  static constexpr EmbeddedScene scenes[] = {\n")
foreach(path IN LISTS SCENES)
  cmake_path(GET path STEM LAST_ONLY name)
  file(READ "${path}" text)
  string(APPEND code "      {\"${name}\", R\"scene(${text})scene\"},\n")
endforeach()
string(APPEND code "  };\n  return scenes;\n}\n\n}  // namespace fascicle::scene\n")
file(WRITE "${OUTPUT}" "${code}")
