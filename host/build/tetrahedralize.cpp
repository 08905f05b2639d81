#include "host/build/tetrahedralize.h"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

#include <Eigen/Geometry>
#include <string.h>

#include "host/build/mass.h"
#include "host/build/mesher.h"
#include "host/build/mesher_replies.h"
#include "host/build/spacing.h"
#include "host/build/weld.h"
#include "host/mesh/mesh_file.h"

namespace fascicle::build {
namespace {

namespace fs = std::filesystem;
using mesh::SurfaceMesh;
using mesh::TetMesh;
using scene::SceneError;
using scene::Vector3d;

// The largest volume of a tetrahedron for which the mean edge comes out as `edge`. A regular tetrahedron has
// edge^3/(6 sqrt 2). TetGen stays below its bound, so the bound is 1.2 times that: on the Stanford bunny at
// its own mean edge, factors of 1, 1.2 and 1.5 give 0.95, 1.00 and 1.06 of the target edge.
double largest_volume(double edge) {
  constexpr double factor = 1.2;
  return factor * edge * edge * edge / (6.0 * std::sqrt(2.0));
}

// The number of tetrahedra by volume alone at this edge; smaller surface triangles add more.
double count_by_volume(const SurfaceMesh& surface, double edge) {
  return std::abs(enclosed_volume(surface)) * 6.0 * std::sqrt(2.0) / (edge * edge * edge);
}

// The expected number: each triangle brings tetrahedra that grade from its size to that of the inner ones.
double count_due(const SurfaceMesh& surface, double edge, std::size_t point_count) {
  constexpr double beside_triangle = 10.0;
  return count_by_volume(surface, edge) +
         beside_triangle * static_cast<double>(surface.triangles.size() + point_count);
}

// Fails early if a run cannot succeed. TetGen takes more than 100 bytes per tetrahedron.
void check_count(const SurfaceMesh& surface, double edge, const BuildOptions& options) {
  constexpr double least_bytes = 100.0;
  const double count = count_by_volume(surface, edge);
  if (!(count * least_bytes > static_cast<double>(options.mesher_bytes))) return;
  throw SceneError("filling the surface needs about " + digits_of(std::round(count / 1e5) / 10.0) +
                   " million tetrahedra, more than the " + std::to_string(options.mesher_bytes >> 20) +
                   " MiB of memory allowed can hold; use a larger resolution (edge length)");
}

void write_points(const fs::path& path, const std::vector<Vector3d>& points) {
  std::ofstream file(path);
  file << std::to_string(points.size()) << '\n';  // a program's locale may group digits
  for (const Vector3d& p : points) {
    file << digits_of(p.x()) << ' ' << digits_of(p.y()) << ' ' << digits_of(p.z()) << '\n';
  }
  file.close();
  if (!file)
    throw std::system_error(std::make_error_code(std::errc::io_error), "cannot write " + path.string());
}

[[noreturn]] void fail_crossing(const ProcessResult& found) {
  throw SceneError("the surface crosses itself" + reason(found) +
                   "; separate or merge the parts that cross, or remesh the surface");
}

// Converts a failed run into one message.
[[noreturn]] void fail_run(const ProcessResult& result, const fs::path& mesher, const fs::path& surface,
                           std::size_t triangles, const ProcessLimits& limits, const BuildOptions& options) {
  const std::string what = "filling the surface with tetrahedra";
  const std::string cure = "use a larger resolution (edge length) or simplify the surface";
  check_time(result, limits, what, cure);
  check_machine(result, what);
  const bool crashed = result.end == ProcessEnd::signalled;
  if (!crashed && result.code == mesher_not_closed) {
    throw SceneError("the surface does not enclose a volume" + reason(result) +
                     " (counted from 0); weld its vertices, close its holes and remove loose parts");
  }
  if (!crashed && result.code == mesher_out_of_memory) fail_memory(limits, options, triangles, what, cure);
  if (!crashed && result.code == mesher_empty_result) {
    throw SceneError("no tetrahedra fit into the surface; check that it encloses a volume");
  }
  if (crashed || result.code == mesher_self_intersecting || result.code == mesher_failed) {
    // TetGen also crashes on self-intersecting surfaces: find the place.
    const ProcessResult search = run_mesher(mesher, {"intersections", surface.string()}, limits);
    if (search.end == ProcessEnd::exited && search.code == mesher_self_intersecting) fail_crossing(search);
    if (!crashed && result.code == mesher_self_intersecting) fail_crossing(result);
  }
  if (crashed) {
    // The last line is an assertion of a library or the allocator: nothing the user can act on.
    throw SceneError(std::string(mesher_name) + " crashed (" + ::strsignal(result.code) +
                     "); the surface may have triangles that nearly touch or overlap, remesh it");
  }
  if (result.code == mesher_failed) {
    throw SceneError("the surface could not be filled with tetrahedra" + reason(result) +
                     "; it may have triangles that nearly touch or overlap, remesh it");
  }
  throw SceneError(mesher.string() + " ended with exit status " + std::to_string(result.code) +
                   reason(result) + "; check that it belongs to this version of fascicle");
}

TetMesh fill_by_mesher(const SurfaceMesh& surface, double edge, const std::vector<Vector3d>& inside,
                       const BuildOptions& options) {
  const fs::path mesher = mesher_path(options);
  // Measured on the Stanford bunny at 4, 1 and 0.5 times its edge: 0.01, 0.1 and 0.2 KB per expected element.
  constexpr double bytes_each = 2048.0;
  const ProcessLimits limits = mesher_limits(options, count_due(surface, edge, inside.size()), bytes_each);
  const TemporaryFolder folder;
  const fs::path surface_file = folder.path() / "surface.off";
  const fs::path points_file = folder.path() / "inside.txt";
  const fs::path volume_file = folder.path() / "volume.mesh";
  mesh::write_off(surface_file, surface);
  std::vector<std::string> arguments = {"tetrahedralize", surface_file.string(), volume_file.string(),
                                        "--max-volume", digits_of(largest_volume(edge))};
  if (!inside.empty()) {
    write_points(points_file, inside);
    arguments.insert(arguments.end(), {"--points", points_file.string()});
  }
  const ProcessResult result = run_mesher(mesher, arguments, limits);
  if (result.end != ProcessEnd::exited || result.code != mesher_done) {
    fail_run(result, mesher, surface_file, surface.triangles.size(), limits, options);
  }
  if (!fs::exists(volume_file)) fail_result("there is no file");
  try {
    return mesh::read_tet_mesh(volume_file);
  } catch (const SceneError& error) {
    // The temporary folder is gone, so its name would help nobody.
    std::string what = error.what();
    if (what.rfind(volume_file.string(), 0) == 0) what.erase(0, volume_file.string().size() + 1);
    fail_result("line " + what);
  }
}

}  // namespace

TetMesh tetrahedralize(const SurfaceMesh& surface, double edge, const std::vector<Vector3d>& inside,
                       const BuildOptions& options) {
  if (surface.triangles.empty()) throw SceneError("the surface has no triangles; give a closed surface");
  if (!std::isfinite(edge) || edge < 0.0) {
    throw SceneError("the requested edge length of tetrahedra is " + digits_of(edge) +
                     "; give a positive number");
  }
  const double wanted_edge = edge > 0.0 ? edge : mean_edge(surface);
  if (!(largest_volume(wanted_edge) > 0.0) || !std::isfinite(largest_volume(wanted_edge))) {
    throw SceneError("the surface's edges are too short or too long to compute with; scale it");
  }
  check_count(surface, wanted_edge, options);
  try {
    TetMesh mesh = fill_by_mesher(surface, wanted_edge, inside, options);
    check_filling(mesh, surface);
    return mesh;
  } catch (const std::system_error& error) {
    base::fail_to_run(mesher_name, error);
  }
}

}  // namespace fascicle::build
