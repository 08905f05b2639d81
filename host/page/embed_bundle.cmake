# Writes OUTPUT, a C++ file with the text of BUNDLE as a raw string literal, so that the executable needs no
# extra files.
file(READ "${BUNDLE}" text)
set(code "// Made by embed_bundle.cmake from web/bundle.\n#include \"host/page/bundle.h\"\n\n")
string(APPEND code "namespace fascicle::page {\n\nstd::string_view view_bundle() {\n")
string(APPEND code "  static constexpr char text[] = R\"fascicle(${text})fascicle\";\n")
string(APPEND code "  return {text, sizeof text - 1};\n}\n\n}  // namespace fascicle::page\n")
file(WRITE "${OUTPUT}" "${code}")
