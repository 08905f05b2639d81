#include "tests/drive/character_walk.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <variant>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/drive/drive_source.h"
#include "host/drive/lead_in.h"
#include "host/formats/surface.h"
#include "host/scene/scene_file.h"

namespace fascicle::tests {

using Eigen::Vector3d;

const std::string flesh_on_bones =
    "[layers.flesh]\nalpha = 0.5\ndamping = 6.0\n"
    "[layers.bone]\nkinematic = true\nwhere = { bone_distance = { maximum = 0.03 } }\n"
    "[solver]\nsubsteps = 8\n";

std::string arm(const std::string& table, const std::string& more) {
  return "[" + table + "]\nmade = \"arm\"\nresolution = 0.03\n" + more;
}

namespace {

std::vector<Vector3d> world(const model::Model& model, const std::vector<float>& positions,
                            const std::array<double, 3>& origin) {
  const std::vector<float> surface = formats::embed(model, positions);
  std::vector<Vector3d> places;
  for (std::size_t i = 0; i < surface.size(); i += 3)
    places.emplace_back(double{surface[i]} * model.unit + origin[0],
                        double{surface[i + 1]} * model.unit + origin[1],
                        double{surface[i + 2]} * model.unit + origin[2]);
  return places;
}

}  // namespace

Walk walk(const std::string& text, std::uint64_t frames, const std::filesystem::path& folder) {
  Walk result;
  result.scene = scene::parse_scene({"test", "test.toml", text, folder}, {});
  build::BuildOptions options;
  options.mesher = FASCICLE_MESHER;
  result.model = build::build_model(result.scene, result.report, options);
  drive::DriveSource drives(result.scene, result.model);
  const auto solver =
      cpu_reference::make_cpu_solver(result.model, {.integrator = result.scene.solver.integrator}, 2);
  solver->load(drive::lead_in(result.scene, result.model, drives, *solver).state);
  const model::State start = solver->save();
  result.surface.push_back(world(result.model, start.positions, start.origin));
  for (std::uint64_t k = 1; k <= frames; ++k) {
    solver->submit(drives.drive(k), {.positions = true});
    const model::Frame frame = solver->collect();
    result.surface.push_back(world(result.model, frame.positions, frame.origin));
  }
  result.last = solver->save();
  return result;
}

Vector3d mean_move(const Walk& walk, const Walk& without, std::size_t character) {
  const rig::SurfacePart& part = std::get<rig::Character>(walk.scene.geometry).parts[character];
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = part.first_vertex; i < part.first_vertex + part.vertex_count; ++i)
    sum += walk.surface.back()[i] - without.surface.back()[i];
  return sum / part.vertex_count;
}

namespace {

constexpr std::array<std::array<std::uint16_t, 3>, 12> box_faces{{{0, 2, 3},
                                                                  {0, 3, 1},
                                                                  {4, 5, 7},
                                                                  {4, 7, 6},
                                                                  {0, 1, 5},
                                                                  {0, 5, 4},
                                                                  {2, 6, 7},
                                                                  {2, 7, 3},
                                                                  {0, 4, 6},
                                                                  {0, 6, 2},
                                                                  {1, 3, 7},
                                                                  {1, 7, 5}}};

}  // namespace

Vector3d corner_of(const Vector3d& low, const Vector3d& high, unsigned k) {
  return {((k & 1) != 0 ? high : low).x(), ((k & 2) != 0 ? high : low).y(), ((k & 4) != 0 ? high : low).z()};
}

void write_box(const std::filesystem::path& file, const Vector3d& low, const Vector3d& high) {
  std::ofstream out(file);
  for (unsigned k = 0; k < 8; ++k) out << "v " << corner_of(low, high, k).transpose() << "\n";
  for (const auto& face : box_faces)
    out << "f " << face[0] + 1 << " " << face[1] + 1 << " " << face[2] + 1 << "\n";
}

GltfBuilder boxes(const std::vector<Box>& all) {
  GltfBuilder b;
  b.document = {
      {"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", nlohmann::json::array()}}}}};
  std::vector<std::uint16_t> corners;
  for (const auto& face : box_faces) corners.insert(corners.end(), face.begin(), face.end());
  for (std::size_t n = 0; n < all.size(); ++n) {
    const Vector3d middle = (all[n].low + all[n].high) / 2.0;
    std::vector<float> places;
    for (unsigned k = 0; k < 8; ++k)
      for (int axis = 0; axis < 3; ++axis)
        places.push_back(static_cast<float>(corner_of(all[n].low, all[n].high, k)[axis] - middle[axis]));
    const std::size_t position = b.add("VEC3", places), index = b.add("SCALAR", corners);
    b.document["meshes"].push_back(
        {{"primitives", {{{"attributes", {{"POSITION", position}}}, {"indices", index}}}}});
    b.document["nodes"].push_back({{"name", "box " + std::to_string(n)},
                                   {"mesh", n},
                                   {"translation", {middle.x(), middle.y(), middle.z()}}});
    b.document["scenes"][0]["nodes"].push_back(n);
  }
  return b;
}

}  // namespace fascicle::tests
