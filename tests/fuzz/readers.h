// Every reader of untrusted files as a function of bytes, for libFuzzer and for tests that replay its finds.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fascicle::fuzz {

// Each passes the bytes to its reader. True: accepted; false: refused with the reader's documented exception
// and a one-line message. Any other exception propagates: it is a flaw of the reader.
bool medit(std::string_view bytes);
bool tetgen(std::string_view bytes);  // the .node file, a zero byte, the .ele file
bool gmsh(std::string_view bytes);
bool vtu(std::string_view bytes);
bool off(std::string_view bytes);
bool obj(std::string_view bytes);
bool ply(std::string_view bytes);
bool stl(std::string_view bytes);
bool gltf(std::string_view bytes);  // .glb or .gltf: character, rig, looks, and the document for output files
// A byte, and a bake's character.glb: one thing that an export or a bake makes of it, as the byte says. All
// of them would take ten times as long.
bool exports(std::string_view bytes);
bool picture(std::string_view bytes);  // a texture: PNG or JPEG
bool scene(std::string_view bytes);
bool set(std::string_view bytes);   // a value of --set
bool jobs(std::string_view bytes);  // a job list of `fascicle batch`
bool paint(std::string_view bytes);
// Our own formats. Those with a checksum are read twice, as they are and with a corrected checksum, so that
// the fuzzer gets past it.
bool frames(std::string_view bytes);
bool model(std::string_view bytes);
bool checkpoint(std::string_view bytes);
bool start(std::string_view bytes);  // a bake's start, in the cache
bool manifest(std::string_view bytes);
bool metrics(std::string_view bytes);  // metrics.csv
bool record(std::string_view bytes);   // a job's record
bool batch(std::string_view bytes);    // batch.json
bool plan(std::string_view bytes);     // plan.json of `fascicle batch --emit`
bool body(std::string_view bytes);     // a built body, in the cache
bool report(std::string_view bytes);   // of a model in the cache
bool results(std::string_view bytes);  // of `fascicle bench`, for --against
bool state(std::string_view bytes);    // a solver's saved state
// What fascicle-mesher returns for a tetrahedron: the filling, the report and the wrap. The wrap's lengths
// come before a zero byte.
bool filling(std::string_view bytes);
bool findings(std::string_view bytes);
bool wrap(std::string_view bytes);
// Messages to the studio, and its session file.
bool message(std::string_view bytes);
bool session(std::string_view bytes);
// The control: reads past its end if the bytes begin with "bone", and throws an undocumented exception if
// they begin with "fat". It computes an undefined value, leaks, does not end or takes
// 600 MiB for "overflow", "leak", "endless" and "huge".
bool planted(std::string_view bytes);
// The control for replaced numbers: throws for "length 1e300".
bool planted_number(std::string_view bytes);

// At least the number of exports: as many seeds have each another one.
inline constexpr unsigned most_exports = 12;

struct Reader {
  std::string name;
  bool (*read)(std::string_view);
};
// All but the control.
std::vector<Reader> readers();

// Valid files for each reader, generated here, from which the fuzzer starts.
struct Seed {
  std::string reader, name, bytes;
};
std::vector<Seed> seeds();

}  // namespace fascicle::fuzz
