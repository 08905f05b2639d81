#include "tests/drive/character_walk.h"

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

void write_box(const std::filesystem::path& file, const Vector3d& low, const Vector3d& high) {
  std::ofstream out(file);
  for (unsigned k = 0; k < 8; ++k)
    out << "v " << (k & 1 ? high : low).x() << " " << (k & 2 ? high : low).y() << " "
        << (k & 4 ? high : low).z() << "\n";
  for (const char* face : {"1 3 4", "1 4 2", "5 6 8", "5 8 7", "1 2 6", "1 6 5", "3 7 8", "3 8 4", "1 5 7",
                           "1 7 3", "2 4 8", "2 8 6"})
    out << "f " << face << "\n";
}

}  // namespace fascicle::tests
