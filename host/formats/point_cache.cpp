#include "host/formats/point_cache.h"

#include <filesystem>
#include <limits>

#include "host/base/errors.h"
#include "host/base/text.h"
#include "host/formats/surface.h"

namespace fascicle::formats {

base::PartFile open_point_cache(const BakeInfo& info, const std::string& format,
                                const PointCacheHeader& header) {
  constexpr std::uint64_t most = std::numeric_limits<std::int32_t>::max();
  require_surface(*info.model, format);
  const std::uint64_t points = info.model->surface_count(), samples = info.frames + 1;
  if (points > most || samples > most)
    throw base::BakeError(format + ": the format counts to " + base::number_text(most) +
                          " points and frames, and this bake has " + base::number_text(points) + " and " +
                          base::number_text(samples) + "; leave out --format " + format);
  const std::string head = header(static_cast<std::int32_t>(points), static_cast<std::int32_t>(samples));
  const std::filesystem::path path = info.folder / ("surface." + format);
  if (info.first > 0)
    return base::PartFile::resume(path, head.size() + info.first * points * 3 * sizeof(float));
  base::PartFile file = base::PartFile::start(path);
  file.write(head);
  return file;
}

}  // namespace fascicle::formats
