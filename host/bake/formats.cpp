#include "host/bake/formats.h"

#include <algorithm>

#include "host/bake/bake.h"
#include "host/bake/checkpoint.h"
#include "host/bake/model_file.h"
#include "host/bake/read_frame_cache.h"

namespace fascicle::bake {

const std::vector<Format>& all_formats() {
  static const std::vector<Format> formats{
      {.name = "", .file = cache_name, .make = make_cache_sink, .bytes = cache_bytes, .from_cache = false},
      {.name = "",
       .file = "metrics.csv",
       .make = make_metrics_sink,
       .bytes = metrics_bytes,
       .from_cache = false},
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

const std::vector<std::string>& format_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Format& format : all_formats())
      if (!format.name.empty()) list.push_back(format.name);
    return list;
  }();
  return names;
}

std::vector<std::string> with_companions(std::vector<std::string> formats, const model::Model& model) {
  const auto has = [&](const char* name) {
    return std::find(formats.begin(), formats.end(), name) != formats.end();
  };
  if (has("vtu") && !has("vtp") && model.surface_count() > 0) formats.push_back("vtp");
  return formats;
}

std::uint64_t output_bytes(const scene::Scene& scene, const model::Model& model,
                           const std::vector<std::string>& formats, const GlbOptions& glb) {
  const std::uint64_t samples = scene::frame_count(scene) + 1;
  std::uint64_t bytes = checkpoint_bytes(model) + encoded_bytes(model);
  const std::vector<std::string> written = with_companions(formats, model);
  for (const Format& format : all_formats())
    if (format.name.empty() || std::find(written.begin(), written.end(), format.name) != written.end())
      bytes += format.bytes(model, format.name == "glb" ? glb_target_count(samples - 1, glb) : samples);
  // The manifest's line for each frame and its text; rest.obj with about 36 and 20 characters a vertex and a
  // triangle.
  bytes += samples * 25 + 4000 + scene.text.size();
  if (model.surface_count() > 0)
    bytes += std::uint64_t{36} * model.surface_count() + model.surface_triangle.size() / 3 * 20;
  return bytes;
}

}  // namespace fascicle::bake
