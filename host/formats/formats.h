// The sinks there are. A new format is one file with its sink, a line here and a line in formats.cpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
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
  std::vector<std::string> spools = {};  // streams beside an unfinished file, without their .part
  bool from_cache = true;                // can be made again from the frame cache, by `fascicle export`
};

// Those of other programs, by name.
const std::vector<Format>& named_formats();

// surface.pc2: Point Cache 2 of the render mesh in its vertex order, metres, Y up; rest.obj is the mesh it
// rides on.
//   char[12] "POINTCACHE2\0", int32 version 1, int32 points, float32 first frame, float32 frames a sample
//   1, int32 samples, then float32 x y z of each point of each sample; little-endian.
std::unique_ptr<FrameSink> make_pc2_sink();
std::uint64_t pc2_bytes(const model::Model& model, std::uint64_t frames);

// Of all formats below: metres, Y up, right-handed, frame k at k / fps seconds, the first frame is 0, or
// BakeInfo::first_number; the render mesh in its own vertex order and topology. Each object of the file is an
// object with its name, its texture coordinates (v up) and its materials (SurfaceObjects); a body without a
// file is one, "surface". Normals are the file's own, turned along (SurfaceNormals). Velocities are the
// derivative of the positions that are written (SurfaceVelocities), m/s.

// surface.mdd: LightWave MDD. Big-endian int32 frames, int32 points, float32 time of each frame (s), then
// float32 x y z of each point of each frame.
std::unique_ptr<FrameSink> make_mdd_sink();
std::uint64_t mdd_bytes(const model::Model& model, std::uint64_t frames);

// obj/frame_NNNNNN.obj: positions, texture coordinates, normals and triangles with their materials;
// obj/surface.mtl, where there are any.
std::unique_ptr<FrameSink> make_obj_sink();
std::uint64_t obj_bytes(const model::Model& model, std::uint64_t frames);
inline constexpr const char* obj_extension = "obj";
inline constexpr const char* obj_materials = "surface.mtl";

// surface.usda: a UsdGeomMesh /body/OBJECT for each object, with time samples of points, normals, velocities
// and extent, and the first frame at the default time; time code k is frame k. Materials are
// UsdPreviewSurfaces, bound to the mesh or to its GeomSubsets.
std::unique_ptr<FrameSink> make_usda_sink();
std::uint64_t usda_bytes(const model::Model& model, std::uint64_t frames);
inline constexpr const char* usda_spool = "surface.usda.samples";

// surface.abc: Alembic (Ogawa), an AbcGeom_PolyMesh_v1 /OBJECT for each object, with samples of P, N,
// .velocities and .selfBnds, its uv, and an AbcGeom_FaceSet_v1 below it for each material; the archive's
// bounds are /.childBnds.
std::unique_ptr<FrameSink> make_abc_sink();
std::uint64_t abc_bytes(const model::Model& model, std::uint64_t frames);

// surface.glb: glTF 2.0, the character with skeleton and looks, its flesh as sparse morph targets on top of
// skinning, one animation that moves both.
std::unique_ptr<FrameSink> make_glb_sink();
// At most this for so many morph targets; vertices that only follow the skeleton take nothing.
std::uint64_t glb_bytes(const model::Model& model, std::uint64_t targets);
std::uint64_t glb_target_count(std::uint64_t frames, const GlbOptions& options);
inline constexpr const char* glb_spool = "surface.glb.targets";

// vtu/frame_NNNNNN.vtu and vtu/series.pvd for ParaView: the tetrahedra in metres with displacement from frame
// 0 (m), velocity (m/s), layer (a number in the field data's list `layers`), kinematic, and source_vertex,
// the vertex's number in the input's tetrahedral mesh. Compressed.
std::unique_ptr<FrameSink> make_vtu_sink();
std::uint64_t vtu_bytes(const model::Model& model, std::uint64_t frames);
inline constexpr const char* vtu_extension = "vtu";
inline constexpr const char* vtk_series = "series.pvd";

// vtp/frame_NNNNNN.vtp and vtp/series.pvd: the render surface for ParaView with normals and texture
// coordinates; a triangle's object and material are numbers in the field data's lists `objects` and
// `materials`, -1: none. Written beside vtu where the scene has a surface.
std::unique_ptr<FrameSink> make_vtp_sink();
std::uint64_t vtp_bytes(const model::Model& model, std::uint64_t frames);
inline constexpr const char* vtp_extension = "vtp";

// The formats with those that come along.
std::vector<std::string> with_companions(std::vector<std::string> formats, const model::Model& model);

}  // namespace fascicle::formats
