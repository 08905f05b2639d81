// The output formats. Each is one file, NAME_sink.cpp, that ends with `Format NAME_format()`, and one line in
// formats.cpp.
//
// All formats use metres, Y up and right-handed axes. Frame k is at k / fps seconds; the first frame's number
// is 0, or BakeInfo::first_number. Formats of the render mesh keep its vertex order and topology. Formats
// with objects have every object of the file with its name, texture coordinates (v up) and materials
// (SurfaceObjects); a body without a file is one object, "surface". Normals are the file's own, rotated with
// the surface (SurfaceNormals). Velocities of the render mesh are the derivative of the written positions
// (SurfaceVelocities), m/s.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/formats/sink.h"
#include "host/model/model.h"

namespace fascicle::formats {

struct Format {
  std::string name;  // for --format; empty: always written
  std::string file;  // in the output folder; a trailing / means a folder of frame_NNNNNN files, named after
                     // their extension
  std::unique_ptr<FrameSink> (*make)();
  // Output size in bytes for `frames` frames, frame 0 included; for glb, for `frames` morph targets.
  std::uint64_t (*bytes)(const model::Model& model, std::uint64_t frames);
  // Other paths that it may leave in the output folder: files next to frame files, and temporary streams of
  // an unfinished file, without their .part.
  std::vector<std::string> beside = {};
  bool from_cache = true;  // `fascicle export` can make it again from the frame cache
};

// For Format::make.
template <class Sink>
std::unique_ptr<FrameSink> make_sink() {
  return std::make_unique<Sink>();
}

// The formats with a name, in alphabetical order.
const std::vector<Format>& named_formats();
// The name must be one of those.
const Format& format_named(std::string_view name);

// Adds formats that accompany others: vtp with vtu if the scene has a surface.
std::vector<std::string> with_companions(std::vector<std::string> formats, const model::Model& model);

}  // namespace fascicle::formats
