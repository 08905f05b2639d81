#include "host/build/wrap.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <system_error>
#include <unordered_map>
#include <vector>

#include <Eigen/Geometry>
#include <string.h>

#include "host/base/errors.h"
#include "host/base/file.h"
#include "host/build/box_tree.h"
#include "host/build/mesher.h"
#include "host/build/mesher_replies.h"
#include "host/build/surface_search.h"
#include "host/build/unions.h"
#include "host/mesh/mesh_file.h"

namespace fascicle::build {

namespace {

namespace fs = std::filesystem;
using scene::SceneError;

// Runs the mesher on so many triangles. `what` names the task in messages; `vertices` is the number it makes.
ProcessResult run(const std::string& what, const std::vector<std::string>& arguments, std::size_t triangles,
                  double vertices, const BuildOptions& options) {
  // Measured: a wrap of 20,000 vertices takes 4 KB per vertex, the check of 7000 triangles less than 1 KB
  // each.
  constexpr double bytes_each = 65536.0;
  const std::string cure = "use less cage_detail or a larger resolution, or simplify the surface";
  const fs::path mesher = mesher_path(options);
  const ProcessLimits limits = mesher_limits(options, static_cast<double>(triangles) + vertices, bytes_each);
  ProcessResult result = run_mesher(mesher, arguments, limits);
  check_time(result, limits, what, cure);
  check_machine(result, what);
  if (result.end == ProcessEnd::signalled)
    throw SceneError(std::string(mesher_name) + " crashed (" + ::strsignal(result.code) + ") while " + what +
                     "; simplify the surface");
  if (result.code == mesher_out_of_memory) fail_memory(limits, options, triangles, what, cure);
  if (result.code == mesher_wrap_failed)
    throw SceneError(what + " failed" + reason(result) + "; use another resolution or cage_detail");
  if (result.code != mesher_done)
    throw SceneError(mesher.string() + " ended with exit status " + std::to_string(result.code) +
                     reason(result) + "; check that it belongs to this version of fascicle");
  return result;
}

// The vertices of a wrap whose triangles have this edge, on both sides in case the surface is a sheet.
double vertices_at(const mesh::SurfaceMesh& surface, double edge) {
  double area = 0.0;
  for (const auto& t : surface.triangles) {
    const scene::Vector3d& a = surface.vertices[t[0]];
    area += 0.5 * (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a).norm();
  }
  return 4.0 / std::sqrt(3.0) * area / (edge * edge);
}

// The expected number of vertices of the wrap and of its filling. If thin parts make `alpha` smaller than the
// scene's gap, there are more.
double vertices_due(const mesh::SurfaceMesh& surface, const WrapOrder& order) {
  const double by_gap = vertices_at(surface, order.gap > 0.0 ? order.gap : order.alpha);
  if (order.edge) return by_gap + vertices_at(surface, *order.edge);
  return by_gap + order.vertices.value_or(0);
}

// Fails early if a run cannot succeed. CGAL takes more than 1 KB per vertex; if triangles lie in layers over
// each other, the wrap goes around the outermost.
void check_count(const mesh::SurfaceMesh& surface, const WrapOrder& order, const BuildOptions& options) {
  constexpr double least_bytes = 1024.0, most_sides = 16.0;
  const double count = vertices_at(surface, order.alpha) / most_sides;
  if (!(count * least_bytes > static_cast<double>(options.mesher_bytes))) return;
  throw SceneError(
      "wrapping the surface needs about " + digits_of(std::round(count / 1e5) / 10.0) +
      " million vertices, more than the " + std::to_string(options.mesher_bytes >> 20) +
      " MiB of memory allowed can hold; use less cage_detail or a larger resolution (edge length)");
}

// Some of a surface's triangles, with the vertices that they use.
mesh::SurfaceMesh part_of(const mesh::SurfaceMesh& surface,
                          const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  mesh::SurfaceMesh part;
  std::unordered_map<std::uint32_t, std::uint32_t> number;
  for (std::array<std::uint32_t, 3> t : triangles) {
    for (std::uint32_t& v : t) {
      const auto [entry, is_new] = number.try_emplace(v, static_cast<std::uint32_t>(part.vertices.size()));
      if (is_new) part.vertices.push_back(surface.vertices[v]);
      v = entry->second;
    }
    part.triangles.push_back(t);
  }
  return part;
}

// Runs `call` and converts system errors into one message.
template <class Call>
auto with_system_errors(Call call) {
  try {
    return call();
  } catch (const std::system_error& error) {
    base::fail_to_run(mesher_name, error);
  }
}

}  // namespace

SurfaceFindings find_defects(const mesh::SurfaceMesh& surface, const BuildOptions& options) {
  return with_system_errors([&] {
    const TemporaryFolder folder;
    const fs::path in = folder.path() / "surface.off", out = folder.path() / "report.txt";
    mesh::write_off(in, surface);
    run("examining the surface", {"report", in.string(), out.string()}, surface.triangles.size(), 0.0,
        options);
    try {
      return parse_findings(base::read_input(out, most_findings_bytes), surface.vertices.size());
    } catch (const base::InputError&) {
      fail_result("its report cannot be read");
    }
  });
}

Wrap wrap_surface(const mesh::SurfaceMesh& surface, const WrapOrder& order, const BuildOptions& options) {
  check_count(surface, order, options);
  return with_system_errors([&] {
    const TemporaryFolder folder;
    const fs::path in = folder.path() / "surface.off", out = folder.path() / "wrap.off";
    mesh::write_off(in, surface);
    std::vector<std::string> arguments{"wrap", in.string(), out.string(), "--alpha", digits_of(order.alpha)};
    if (order.offset > 0.0) arguments.insert(arguments.end(), {"--offset", digits_of(order.offset)});
    if (order.edge)
      arguments.insert(arguments.end(), {"--edge", digits_of(*order.edge)});
    else if (order.vertices)
      arguments.insert(arguments.end(), {"--vertices", std::to_string(*order.vertices)});
    Wrap wrap;
    const ProcessResult result = run("wrapping the surface", arguments, surface.triangles.size(),
                                     vertices_due(surface, order), options);
    const WrapLengths used = parse_wrap_lengths(base::last_line(result, mesher_name));
    wrap.alpha = used.alpha;
    wrap.offset = used.offset;
    try {
      wrap.surface = mesh::read_surface_mesh(out);
      drop_inner_shells(wrap.surface);
      if (wrap.surface.triangles.empty()) fail_result("its wrap has no triangles");
      return wrap;
    } catch (const SceneError& error) {
      std::string what = error.what();
      if (what.rfind(out.string(), 0) == 0) what.erase(0, out.string().size() + 1);
      fail_result("line " + what);
    }
  });
}

void drop_inner_shells(mesh::SurfaceMesh& surface) {
  Unions unions(surface.vertices.size());
  for (const auto& t : surface.triangles) {
    unions.join(t[0], t[1]);
    unions.join(t[1], t[2]);
  }
  std::map<std::uint32_t, std::vector<std::array<std::uint32_t, 3>>> parts;  // triangles, by lowest vertex
  for (const auto& t : surface.triangles) parts[unions.find(t[0])].push_back(t);
  if (parts.size() < 2) return;
  std::vector<char> is_inner(surface.vertices.size(), 0);  // by lowest vertex
  for (const auto& [first, triangles] : parts) {
    const mesh::SurfaceMesh part = part_of(surface, triangles);
    const BoundingBox box = box_around(part.vertices);
    std::vector<std::uint32_t> asked;
    for (const auto& [other, unused] : parts) {
      const scene::Vector3d& p = surface.vertices[other];
      if (other != first && (p.array() >= box.low.array()).all() && (p.array() <= box.high.array()).all())
        asked.push_back(other);
    }
    if (asked.empty()) continue;
    const SurfaceSearch search(part);
    for (const std::uint32_t other : asked)
      if (search.is_inside(surface.vertices[other])) is_inner[other] = 1;
  }
  std::erase_if(surface.triangles, [&](const auto& t) { return is_inner[unions.find(t[0])] != 0; });
  std::vector<std::uint32_t> number(surface.vertices.size());
  std::uint32_t count = 0;
  for (std::uint32_t v = 0; v < number.size(); ++v) {
    number[v] = count;
    if (is_inner[unions.find(v)] == 0) surface.vertices[count++] = surface.vertices[v];
  }
  surface.vertices.resize(count);
  for (auto& t : surface.triangles)
    for (std::uint32_t& v : t) v = number[v];
}

}  // namespace fascicle::build
