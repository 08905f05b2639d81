#include "host/formats/formats.h"

#include <algorithm>
#include <stdexcept>

namespace fascicle::formats {

// Lists every format once: declares NAME_format() and adds its row.
#define FASCICLE_FORMATS(FORMAT) \
  FORMAT(abc)                    \
  FORMAT(glb)                    \
  FORMAT(mdd)                    \
  FORMAT(obj)                    \
  FORMAT(pc2)                    \
  FORMAT(usda)                   \
  FORMAT(vtp)                    \
  FORMAT(vtu)

#define FASCICLE_DECLARED(name) Format name##_format();
FASCICLE_FORMATS(FASCICLE_DECLARED)

const std::vector<Format>& named_formats() {
#define FASCICLE_ROW(name) name##_format(),
  static const std::vector<Format> formats{FASCICLE_FORMATS(FASCICLE_ROW)};
  return formats;
}

const Format& format_named(std::string_view name) {
  for (const Format& format : named_formats())
    if (format.name == name) return format;
  throw std::invalid_argument("no format is called " + std::string(name));
}

std::vector<std::string> with_companions(std::vector<std::string> formats, const model::Model& model) {
  const auto has = [&](const char* name) {
    return std::find(formats.begin(), formats.end(), name) != formats.end();
  };
  if (has("vtu") && !has("vtp") && model.surface_count() > 0) formats.push_back("vtp");
  return formats;
}

}  // namespace fascicle::formats
