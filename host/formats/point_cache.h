// Common code of point caches: one file with a header and the render mesh's points in metres, frame by frame.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "host/base/part_file.h"
#include "host/formats/sink.h"

namespace fascicle::formats {

// Makes the header of a file with this many points and samples (frames, frame 0 included).
using PointCacheHeader = std::function<std::string(std::int32_t points, std::int32_t samples)>;

// Opens surface.FORMAT: new with its header, or to append after the frames before `info.first`. Throws
// BakeError if there is no surface, or more points or samples than the format can count.
base::PartFile open_point_cache(const BakeInfo& info, const std::string& format,
                                const PointCacheHeader& header);

}  // namespace fascicle::formats
