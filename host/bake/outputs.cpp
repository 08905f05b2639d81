#include "host/bake/outputs.h"

#include <algorithm>

#include "host/bake/checkpoint.h"
#include "host/bake/model_file.h"
#include "host/bake/read_frame_cache.h"

namespace fascicle::bake {

const std::vector<formats::Format>& all_formats() {
  static const std::vector<formats::Format> formats = [] {
    std::vector<formats::Format> all{
        {.name = "", .file = cache_name, .make = make_cache_sink, .bytes = cache_bytes, .from_cache = false},
        {.name = "",
         .file = metrics_name,
         .make = [] { return make_metrics_sink(); },
         .bytes = metrics_bytes,
         .from_cache = false},
    };
    all.insert(all.end(), formats::named_formats().begin(), formats::named_formats().end());
    return all;
  }();
  return formats;
}

const std::vector<std::string>& format_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const formats::Format& format : formats::named_formats())
      if (!format.name.empty()) list.push_back(format.name);
    return list;
  }();
  return names;
}

std::uint64_t output_bytes(const scene::Scene& scene, const model::Model& model,
                           const std::vector<std::string>& formats, const formats::GlbOptions& glb) {
  const std::uint64_t samples = scene::frame_count(scene) + 1;
  std::uint64_t bytes = checkpoint_bytes(model) + encoded_bytes(model);
  const std::vector<std::string> written = formats::with_companions(formats, model);
  for (const formats::Format& format : all_formats())
    if (format.name.empty() || std::find(written.begin(), written.end(), format.name) != written.end())
      bytes +=
          format.bytes(model, format.name == "glb" ? formats::glb_target_count(samples - 1, glb) : samples);
  // The manifest: a line per frame, and the scene's text. rest.obj: about 36 characters per vertex and 20 per
  // triangle.
  bytes += samples * 25 + 4000 + scene.text.size();
  if (model.surface_count() > 0)
    bytes += std::uint64_t{36} * model.surface_count() + model.surface_triangle.size() / 3 * 20;
  return bytes;
}

}  // namespace fascicle::bake
