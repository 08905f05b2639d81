// Every reader of files from strangers as a function of bytes, for clang's fuzzer and for tests that replay
// what it found.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fascicle::fuzz {

// Each gives the bytes to its reader. True: they were taken; false: refused by the reader's documented error,
// with one line that says why. Whatever else is thrown leaves the function: it is a flaw of the reader.
bool medit(std::string_view bytes);
bool tetgen(std::string_view bytes);  // the .node file, a zero byte, the .ele file
bool gmsh(std::string_view bytes);
bool vtu(std::string_view bytes);
bool off(std::string_view bytes);
bool obj(std::string_view bytes);
bool ply(std::string_view bytes);
bool stl(std::string_view bytes);
bool gltf(std::string_view bytes);     // .glb or .gltf: character, rig, looks, and the document to hand on
bool picture(std::string_view bytes);  // of a texture: PNG or JPEG
bool scene(std::string_view bytes);
bool set(std::string_view bytes);   // what --set takes
bool jobs(std::string_view bytes);  // of `fascicle batch`
bool paint(std::string_view bytes);
// What this program wrote. Where there is a checksum, the bytes are read twice: as they are, and with the
// checksum that they should have, so that what lies behind it is read too.
bool frames(std::string_view bytes);
bool model(std::string_view bytes);
bool checkpoint(std::string_view bytes);
bool start(std::string_view bytes);  // of a bake, in the cache
bool manifest(std::string_view bytes);
bool metrics(std::string_view bytes);  // metrics.csv
bool record(std::string_view bytes);   // of a job
bool batch(std::string_view bytes);    // batch.json
bool body(std::string_view bytes);     // in the cache
bool report(std::string_view bytes);   // of a kept model, in the cache
// The studio's.
bool message(std::string_view bytes);
bool session(std::string_view bytes);
// The control: reads past its bytes where they begin with "bone", and throws what it does not say where they
// begin with "fat".
bool planted(std::string_view bytes);

struct Reader {
  std::string name;
  bool (*read)(std::string_view);
};
// All but the control.
std::vector<Reader> readers();

// Files that each reader takes, made here: what the fuzzer begins with.
struct Seed {
  std::string reader, name, bytes;
};
std::vector<Seed> seeds();

}  // namespace fascicle::fuzz
