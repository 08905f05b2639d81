// The formats there are. Each is one file, NAME_sink.cpp, that ends with `Format NAME_format()`, and one line
// in formats.cpp.
//
// Of all of them: metres, Y up, right-handed, frame k at k / fps seconds, the first frame is 0, or
// BakeInfo::first_number. Those of the render mesh have its own vertex order and topology. What has objects
// has each object of the file with its name, its texture coordinates (v up) and its materials
// (SurfaceObjects); a body without a file is one, "surface". Normals are the file's own, turned along
// (SurfaceNormals). Velocities of the render mesh are the derivative of the positions that are written
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
  std::string name;  // of --format; empty: always written
  std::string file;  // in the folder; ends in / for a folder of frame_NNNNNN files, named after its extension
  std::unique_ptr<FrameSink> (*make)();
  // Bytes of `frames` frames.
  std::uint64_t (*bytes)(const model::Model& model, std::uint64_t frames);
  // Paths in the folder of what else it may leave there: files beside those of frames, and streams beside an
  // unfinished file, without their .part.
  std::vector<std::string> beside = {};
  bool from_cache = true;  // can be made again from the frame cache, by `fascicle export`
};

// `make` of a format.
template <class Sink>
std::unique_ptr<FrameSink> make_sink() {
  return std::make_unique<Sink>();
}

// Those of other programs, by name.
const std::vector<Format>& named_formats();
// One that there is.
const Format& format_named(std::string_view name);

// The formats with those that come along: vtp with vtu where the scene has a surface.
std::vector<std::string> with_companions(std::vector<std::string> formats, const model::Model& model);

}  // namespace fascicle::formats
