#include "host/bake/formats.h"

#include "host/bake/bake.h"
#include "host/bake/read_frame_cache.h"

namespace fascicle::bake {

const std::vector<Format>& all_formats() {
  static const std::vector<Format> formats{
      {"", cache_name, make_cache_sink, cache_bytes},
      {"", "metrics.csv", make_metrics_sink, metrics_bytes},
      {"pc2", "surface.pc2", make_pc2_sink, pc2_bytes},
      {"vtu", "vtu/", make_vtu_sink, vtu_bytes},
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

}  // namespace fascicle::bake
