#include "host/mesh/mesh_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <new>
#include <string>
#include <system_error>

#include <unistd.h>

#include "host/base/errors.h"
#include "host/base/file.h"
#include "host/mesh/mesh_readers.h"

namespace fascicle::mesh {
namespace {

namespace fs = std::filesystem;

bool is_one_of(const std::string& extension, std::initializer_list<const char*> list) {
  return std::any_of(list.begin(), list.end(), [&](const char* each) { return extension == each; });
}

// Reads NAME.node and NAME.ele, whichever of them `path` names; the other extension has the same case.
TetMesh read_tetgen_pair(const fs::path& path) {
  const bool upper = path.extension() == ".NODE" || path.extension() == ".ELE";
  fs::path node = path;
  fs::path ele = path;
  node.replace_extension(upper ? ".NODE" : ".node");
  ele.replace_extension(upper ? ".ELE" : ".ele");
  for (const fs::path& each : {node, ele}) {
    std::error_code none;
    if (!fs::exists(each, none)) {
      throw base::SceneError(each.string() +
                             ": no such file; a TetGen mesh is a .node and an .ele file of the same name, "
                             "put both into one folder");
    }
  }
  const std::string nodes = read_whole_file(node);
  const std::string elements = read_whole_file(ele);
  return read_tetgen(node.string(), nodes, ele.string(), elements);
}

template <typename Read>
auto with_memory_checked(const fs::path& path, Read read) {
  try {
    return read();
  } catch (const std::bad_alloc&) {
    throw base::SceneError(path.string() + ": not enough memory to read this mesh; use a coarser one");
  }
}

void append_number(std::string& text, double value) {
  std::array<char, 32> digits;  // the shortest round-trip form has at most 24 characters
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text.append(digits.data(), end);
}

// Removes the file unless it was renamed to its final name.
class PendingFile {
 public:
  explicit PendingFile(const fs::path& path)
      : path_(path), file_(path.string() + ".part-" + std::to_string(::getpid()), base::FileMode::replace) {}
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;
  ~PendingFile() {
    if (!is_placed_) ::unlink(file_.path().c_str());
  }

  void write(std::string_view text) { file_.write(text); }

  void place() {
    file_.sync();
    file_.close();
    base::rename_over(file_.path(), path_);
    is_placed_ = true;
  }

 private:
  fs::path path_;
  base::File file_;
  bool is_placed_ = false;
};

}  // namespace

std::string read_whole_file(const fs::path& path) {
  return base::read_input(path, largest_mesh_file);
}

std::string other_cells(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " volume cell is not a tetrahedron of four vertices"
                                             : " volume cells are not tetrahedra of four vertices");
}

bool is_tet_mesh_file(const fs::path& path) {
  return is_one_of(base::lower_extension(path), {".mesh", ".node", ".ele", ".msh", ".vtu"});
}

TetMesh read_tet_mesh(const fs::path& path) {
  const std::string extension = base::lower_extension(path);
  return with_memory_checked(path, [&] {
    if (is_one_of(extension, {".node", ".ele"})) return read_tetgen_pair(path);
    if (!is_tet_mesh_file(path)) {
      throw base::SceneError(
          path.string() +
          ": not a tetrahedral mesh file by its extension; use .mesh, .node, .ele, .msh or .vtu");
    }
    const std::string text = read_whole_file(path);
    if (extension == ".mesh") return read_medit(path.string(), text);
    if (extension == ".msh") return read_gmsh(path.string(), text);
    return read_vtu(path.string(), text);
  });
}

bool is_surface_mesh_file(const fs::path& path) {
  return is_one_of(base::lower_extension(path), {".off", ".obj", ".ply", ".stl"});
}

SurfaceMesh read_surface_mesh(const fs::path& path) {
  const std::string extension = base::lower_extension(path);
  return with_memory_checked(path, [&] {
    if (!is_surface_mesh_file(path)) {
      throw base::SceneError(path.string() +
                             ": not a surface file by its extension; use .off, .obj, .ply or .stl");
    }
    const std::string content = read_whole_file(path);
    if (extension == ".off") return read_off(path.string(), content);
    if (extension == ".obj") return read_obj(path.string(), content);
    if (extension == ".ply") return read_ply(path.string(), content);
    return read_stl(path.string(), content);
  });
}

void write_off(const fs::path& path, const SurfaceMesh& mesh) {
  constexpr std::size_t block = std::size_t{1} << 20;
  PendingFile file(path);
  std::string text =
      "OFF\n" + std::to_string(mesh.vertices.size()) + " " + std::to_string(mesh.triangles.size()) + " 0\n";
  const auto flush_over = [&](std::size_t limit) {
    if (text.size() <= limit) return;
    file.write(text);
    text.clear();
  };
  for (const Vector3d& vertex : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) {
      append_number(text, vertex[axis]);
      text += axis < 2 ? ' ' : '\n';
    }
    flush_over(block);
  }
  for (const auto& triangle : mesh.triangles) {
    text += '3';
    for (const std::uint32_t vertex : triangle) text.append(" ").append(std::to_string(vertex));
    text += '\n';
    flush_over(block);
  }
  flush_over(0);
  file.place();
}

}  // namespace fascicle::mesh
