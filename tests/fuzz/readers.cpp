#include "tests/fuzz/readers.h"

namespace fascicle::fuzz {

std::vector<Reader> readers() {
  return {{"medit", medit},     {"tetgen", tetgen},     {"gmsh", gmsh},
          {"vtu", vtu},         {"off", off},           {"obj", obj},
          {"ply", ply},         {"stl", stl},           {"gltf", gltf},
          {"exports", exports}, {"picture", picture},   {"scene", scene},
          {"set", set},         {"jobs", jobs},         {"paint", paint},
          {"frames", frames},   {"model", model},       {"checkpoint", checkpoint},
          {"start", start},     {"manifest", manifest}, {"metrics", metrics},
          {"record", record},   {"batch", batch},       {"plan", plan},
          {"body", body},       {"report", report},     {"results", results},
          {"state", state},     {"filling", filling},   {"findings", findings},
          {"wrap", wrap},       {"message", message},   {"session", session}};
}

}  // namespace fascicle::fuzz
