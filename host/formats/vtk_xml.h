// VTK's XML files with compressed raw appended data, and ParaView collections of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/formats/frame_files.h"
#include "host/formats/sink.h"

namespace fascicle::formats {

// One array in the form of appended data. Header (uint64): number of blocks, their size, the size of the last
// if smaller, and the compressed sizes; then the blocks of at most 1 MiB, each compressed by zlib.
std::string vtk_compressed(std::string_view bytes);
// Upper bound of its size.
std::uint64_t vtk_compressed_bound(std::uint64_t bytes);

// Builds the text and the appended data of one file, array by array.
class VtkArrays {
 public:
  // Adds an array, given its compressed form; returns its tag.
  std::string add(const std::string& type, const std::string& name, std::size_t components,
                  std::string_view compressed);
  template <class T>
  std::string add(const std::string& type, const std::string& name, std::size_t components,
                  std::span<const T> values) {
    return add(type, name, components,
               vtk_compressed({reinterpret_cast<const char*>(values.data()), values.size_bytes()}));
  }
  // The complete file around `pieces`, the contents of a `kind` ("PolyData") element.
  std::string file(const std::string& kind, const std::string& pieces) const;

 private:
  std::string data_;
};

// Field data: the time (s) and lists of names.
struct VtkNames {
  std::string name;
  std::vector<std::string> values;
};
std::string vtk_field_data(double time, std::span<const VtkNames> names);

inline constexpr const char* vtk_series = "series.pvd";
inline constexpr std::uint8_t vtk_tetra = 10;  // VTK cell type

// A bake's frames: one file each, and vtk_series, the collection with their times.
class VtkFrames {
 public:
  VtkFrames(const BakeInfo& info, const std::string& extension);

  double time_of(std::uint64_t frame) const;  // s
  void write(std::uint64_t frame, std::string_view text) { files_.write(frame, text); }
  void sync() { files_.sync(); }
  // Call after the last frame.
  void finish();

 private:
  double start_, fps_;
  std::uint64_t frames_;
  std::string extension_;
  FrameFiles files_;
};

// The same for a list of numbers.
template <class T>
std::string vtk_compressed_values(const std::vector<T>& values) {
  return vtk_compressed({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}

}  // namespace fascicle::formats
