# Writes OUTPUT, a C++ file with the text of the studio's page as raw string literals, so that the executable
# needs no extra files. FOLDER holds studio.html, studio.js and studio.css.
set(code "// Made by embed_bundle.cmake from web/bundle.\n#include \"host/studio/bundle.h\"\n\n")
string(APPEND code "namespace fascicle::studio {\n\nstd::vector<ServedFile> page_bundle() {\n")
set(list "")
foreach(file "html,,text/html; charset=utf-8" "js,studio.js,text/javascript; charset=utf-8"
        "css,studio.css,text/css; charset=utf-8")
  string(REPLACE "," "|" parts "${file}")
  string(REGEX MATCH "^([a-z]+)\\|([a-z.]*)\\|(.*)$" matched "${parts}")
  set(kind ${CMAKE_MATCH_1})
  set(name "${CMAKE_MATCH_2}")
  set(type "${CMAKE_MATCH_3}")
  file(READ "${FOLDER}/studio.${kind}" text)
  string(APPEND code "  static constexpr char ${kind}[] = R\"fascicle(${text})fascicle\";\n")
  string(APPEND list "{\"${name}\", \"${type}\", std::string_view(${kind}, sizeof ${kind} - 1)}, ")
endforeach()
string(APPEND code "  return {${list}};\n}\n\n}  // namespace fascicle::studio\n")
file(WRITE "${OUTPUT}" "${code}")
