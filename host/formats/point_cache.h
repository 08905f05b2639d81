// What point caches have in common: one file of a header and the render mesh's points in metres, frame by
// frame.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "host/base/part_file.h"
#include "host/formats/sink.h"

namespace fascicle::formats {

// The header of a file of so many points and samples, which are the frames with frame 0.
using PointCacheHeader = std::function<std::string(std::int32_t points, std::int32_t samples)>;

// surface.FORMAT: begun with its header, or gone on with behind the frames before `info.first`. Throws
// BakeError without a surface, and where there are more points or samples than the format counts.
base::PartFile open_point_cache(const BakeInfo& info, const std::string& format,
                                const PointCacheHeader& header);

}  // namespace fascicle::formats
