#include "host/formats/formats.h"

#include <algorithm>

namespace fascicle::formats {

const std::vector<Format>& named_formats() {
  static const std::vector<Format> formats{
      {.name = "abc", .file = "surface.abc", .make = make_abc_sink, .bytes = abc_bytes},
      {.name = "glb",
       .file = "surface.glb",
       .make = make_glb_sink,
       .bytes = glb_bytes,
       .spools = {glb_spool}},
      {.name = "mdd", .file = "surface.mdd", .make = make_mdd_sink, .bytes = mdd_bytes},
      {.name = "obj", .file = "obj/", .make = make_obj_sink, .bytes = obj_bytes},
      {.name = "pc2", .file = "surface.pc2", .make = make_pc2_sink, .bytes = pc2_bytes},
      {.name = "usda",
       .file = "surface.usda",
       .make = make_usda_sink,
       .bytes = usda_bytes,
       .spools = {usda_spool}},
      {.name = "vtp", .file = "vtp/", .make = make_vtp_sink, .bytes = vtp_bytes},
      // Its velocities are not in the frame cache.
      {.name = "vtu", .file = "vtu/", .make = make_vtu_sink, .bytes = vtu_bytes, .from_cache = false},
  };
  return formats;
}

std::vector<std::string> with_companions(std::vector<std::string> formats, const model::Model& model) {
  const auto has = [&](const char* name) {
    return std::find(formats.begin(), formats.end(), name) != formats.end();
  };
  if (has("vtu") && !has("vtp") && model.surface_count() > 0) formats.push_back("vtp");
  return formats;
}

}  // namespace fascicle::formats
