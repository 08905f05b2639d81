#define TETLIBRARY
#include "host/mesher/tetgen_run.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <new>

#include <tetgen.h>
#include <unistd.h>

#include "host/mesher/exit_codes.h"

namespace fascicle::mesher {
namespace {

// A terminate handler receives no context, so its data must be global.
std::string& part_to_remove() {
  static std::string part;
  return part;
}

[[noreturn]] void leave(int code, const char* what) {
  std::fprintf(stderr, "fascicle-mesher: %s\n", what);
  if (!part_to_remove().empty()) ::unlink(part_to_remove().c_str());
  // Skips exit handlers: TetGen's memory is in an unknown state.
  _exit(code);
}

[[noreturn]] void on_terminate() {
  try {
    const std::exception_ptr thrown = std::current_exception();
    if (thrown) std::rethrow_exception(thrown);
  } catch (int reason) {  // see terminatetetgen() in tetgen.h
    switch (reason) {
      case 1:
        leave(out_of_memory, "TetGen ran out of memory");
      case 3:
        leave(self_intersecting, "TetGen found that the surface crosses itself");
      case 4:
        leave(tetgen_failed, "TetGen found a detail too small for its tolerance");
      case 5:
        leave(tetgen_failed, "TetGen found two triangles too close to each other");
      case 10:
        leave(tetgen_failed, "TetGen refused the surface");
      default:
        leave(tetgen_failed, "TetGen failed with an internal error");
    }
  } catch (const std::bad_alloc&) {
    leave(out_of_memory, "out of memory");
  } catch (const std::exception& error) {
    leave(tetgen_failed, error.what());
  } catch (...) {
  }
  leave(tetgen_failed, "TetGen failed");
}

// tetgenio frees its arrays with delete[].
void set_surface(tetgenio& io, const Surface& surface, const std::vector<Point>& inside) {
  io.numberofpoints = static_cast<int>(surface.vertices.size() + inside.size());
  io.pointlist = new double[3 * (surface.vertices.size() + inside.size())];
  double* coordinate = io.pointlist;
  for (const auto* points : {&surface.vertices, &inside}) {
    for (const Point& point : *points) coordinate = std::copy(point.begin(), point.end(), coordinate);
  }
  io.numberoffacets = static_cast<int>(surface.triangles.size());
  io.facetlist = new tetgenio::facet[surface.triangles.size()];
  io.facetmarkerlist = new int[surface.triangles.size()];
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    const auto& t = surface.triangles[i];
    io.facetmarkerlist[i] = static_cast<int>(i) + 1;  // 0 means unmarked
    tetgenio::facet& facet = io.facetlist[i];
    facet.numberofholes = 0;
    facet.holelist = nullptr;
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    facet.polygonlist[0].numberofvertices = 3;
    facet.polygonlist[0].vertexlist = new int[3]{t[0], t[1], t[2]};
  }
}

tetgenbehavior parsed(std::string switches) {
  tetgenbehavior behavior;
  if (!behavior.parse_commandline(switches.data()))
    throw Failure(tetgen_failed, "TetGen refused its switches");
  return behavior;
}

// Redirects stdout into a file during its lifetime.
class CapturedStdout {
 public:
  explicit CapturedStdout(std::FILE* file) : file_(file) {
    std::fflush(stdout);
    saved_ = ::dup(STDOUT_FILENO);
    ::dup2(::fileno(file_), STDOUT_FILENO);
  }
  CapturedStdout(const CapturedStdout&) = delete;
  CapturedStdout& operator=(const CapturedStdout&) = delete;
  ~CapturedStdout() {
    std::fflush(stdout);
    if (saved_ >= 0) {
      ::dup2(saved_, STDOUT_FILENO);
      ::close(saved_);
    }
  }

  // The facets of the first line "  Facet #A VERB facet #B at ...", as printed by TetGen's -d.
  std::optional<std::array<int, 2>> first_pair() {
    std::fflush(stdout);
    std::rewind(file_);
    std::array<char, 512> line;
    while (std::fgets(line.data(), static_cast<int>(line.size()), file_) != nullptr) {
      std::array<int, 2> pair{};
      if (std::sscanf(line.data(), " Facet #%d %*s facet #%d", &pair[0], &pair[1]) == 2) return pair;
    }
    return std::nullopt;
  }

 private:
  std::FILE* file_;
  int saved_ = -1;
};

}  // namespace

void install_terminate_handler(const std::string& part) {
  part_to_remove() = part;
  std::set_terminate(on_terminate);
}

Volume fill(const Surface& surface, const std::vector<Point>& inside, double max_volume, double quality) {
  tetgenio in;
  tetgenio out;
  set_surface(in, surface, inside);
  // p: a surface. q: quality. Y: no new points on the surface. M: flat neighbours are not merged, so that no
  // edge of the surface flips. J: no point is dropped, so that vertex numbers stay. Q: quiet.
  tetgenbehavior behavior = parsed("pqYMJQ");
  behavior.minratio = quality;
  if (max_volume > 0.0) {
    behavior.fixedvolume = 1;
    behavior.maxvolume = max_volume;
  }
  tetrahedralize(&behavior, &in, &out);

  Volume volume;
  volume.vertices.resize(static_cast<std::size_t>(out.numberofpoints));
  for (std::size_t i = 0; i < volume.vertices.size(); ++i) {
    std::copy_n(out.pointlist + 3 * i, 3, volume.vertices[i].begin());
  }
  volume.tetrahedra.resize(static_cast<std::size_t>(out.numberoftetrahedra));
  for (std::size_t i = 0; i < volume.tetrahedra.size(); ++i) {
    std::copy_n(out.tetrahedronlist + 4 * i, 4, volume.tetrahedra[i].begin());
  }
  return volume;
}

std::optional<std::string> find_intersection(const Surface& surface, std::FILE* listed) {
  tetgenio in;
  tetgenio out;
  set_surface(in, surface, {});
  tetgenbehavior behavior = parsed("pd");
  CapturedStdout captured(listed);
  tetrahedralize(&behavior, &in, &out);
  const auto pair = captured.first_pair();
  if (!pair) return std::nullopt;
  std::string text = "triangles " + std::to_string((*pair)[0] - 1) + " and " +
                     std::to_string((*pair)[1] - 1) + " (counted from 0) cross";
  if ((*pair)[0] >= 1 && static_cast<std::size_t>((*pair)[0]) <= surface.triangles.size()) {
    const int vertex = surface.triangles[static_cast<std::size_t>((*pair)[0] - 1)][0];
    const Point& p = surface.vertices[static_cast<std::size_t>(vertex)];
    std::array<char, 96> place;
    std::snprintf(place.data(), place.size(), " near (%.6g %.6g %.6g)", p[0], p[1], p[2]);
    text += place.data();
  }
  return text + "; " + std::to_string(out.numberoftrifaces) + " triangles cross others";
}

}  // namespace fascicle::mesher
