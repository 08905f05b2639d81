#include "tests/formats/dressed_model.h"

#include <span>
#include <string>
#include <utility>

#include "host/base/part_file.h"
#include "host/formats/gltf_writer.h"
#include "host/formats/surface.h"
#include "tests/bake/fake_solver.h"

namespace fascicle::tests {

using nlohmann::json;

namespace {

constexpr double fps = 8.0;

// The model vertex of each render vertex.
constexpr std::array<std::uint32_t, 9> of_vertex{0, 1, 2, 0, 2, 3, 1, 4, 2};

// Y up to Z up: (x, y, z) to (x, -z, y).
std::vector<float> raw(const std::vector<float>& values) {
  std::vector<float> result;
  for (std::size_t i = 0; i < values.size(); i += 3)
    for (const float value : {values[i], -values[i + 2], values[i + 1]}) result.push_back(value);
  return result;
}

}  // namespace

const std::vector<float> dressed_uvs{0, 0, 1, 0, 0, 0.25f, 0.5f, 0.5f, 0.5f, 1, 0.75f, 0};
// The faces point along z, x and (1, 1, -1); the crease is the edge from vertex 0 to 2. One normal is tilted.
const std::vector<float> dressed_normals{0, 0, 1, 0.6f, 0, 0.8f, 0,    0, 1,    1,    0, 0,    1,   0,
                                         0, 1, 0, 0,    0, 0.6f, 0.8f, 0, 0.6f, 0.8f, 0, 0.6f, 0.8f};

model::Model dressed_model() {
  model::Model m = two_tetrahedra();
  m.surface_vertex.clear();
  m.surface_weight.clear();
  for (const std::uint32_t vertex : of_vertex)
    for (int corner = 0; corner < 4; ++corner) {
      m.surface_vertex.push_back(vertex);
      m.surface_weight.push_back(corner == 0 ? 1.0f : 0.0f);
    }
  m.surface_triangle = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  m.joint_count = 1;
  m.skin_offset = {0, 1, 2, 3, 4, 5};
  m.skin_joint.assign(5, 0);
  m.skin_weight.assign(5, 1.0f);
  return m;
}

void write_dressed(const std::filesystem::path& path,
                   const std::function<void(gltf::GltfDocument&)>& change) {
  const model::Model model = dressed_model();
  const std::vector<float> points =
      raw(formats::world_positions(formats::embed(model, model.rest), model.unit, model.rest_origin));
  const std::vector<float> normals = raw(dressed_normals);
  gltf::GltfDocument document;
  document.json = {{"asset", {{"version", "2.0"}}},
                   {"scene", 0},
                   {"scenes", {{{"nodes", {0, 1, 2}}}}},
                   {"accessors", json::array()},
                   {"bufferViews", json::array()}};
  const auto primitive = [&](std::size_t first, int material, bool with_uvs) {
    const auto part = [&](const std::vector<float>& values, std::size_t width) {
      return std::span<const float>(values).subspan(first * width, 3 * width);
    };
    const std::vector<std::uint16_t> joints(12, 0);
    const std::vector<float> weights{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    const std::vector<std::uint32_t> corners{0, 1, 2};
    json attributes{{"POSITION", formats::add_accessor(document, part(points, 3), 3, true)},
                    {"NORMAL", formats::add_accessor(document, part(normals, 3), 3)},
                    {"JOINTS_0", formats::add_accessor(document, std::span<const std::uint16_t>(joints), 4)},
                    {"WEIGHTS_0", formats::add_accessor(document, std::span<const float>(weights), 4)}};
    if (with_uvs) {
      const std::size_t number = formats::add_accessor(document, part(dressed_uvs, 2), 1);
      document.json["accessors"][number]["type"] = "VEC2";
      document.json["accessors"][number]["count"] = 3;
      attributes["TEXCOORD_0"] = number;
    }
    return json{{"attributes", attributes},
                {"indices", formats::add_accessor(document, std::span<const std::uint32_t>(corners))},
                {"material", material}};
  };
  document.json["meshes"] = {{{"primitives", {primitive(0, 0, true), primitive(3, 1, true)}}},
                             {{"primitives", {primitive(6, 2, false)}}}};
  document.json["nodes"] = {{{"name", "root"}},
                            {{"name", "Body.001"}, {"mesh", 0}, {"skin", 0}},
                            {{"name", "Body.001"}, {"mesh", 1}, {"skin", 0}}};
  // Column-major: raw (x, -z, y) to (x, y, z).
  const std::vector<float> inverse_bind{1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1};
  document.json["skins"] = {
      {{"joints", {0}},
       {"inverseBindMatrices", formats::add_accessor(document, std::span<const float>(inverse_bind), 16)}}};
  // Our readers do not decode images.
  const std::size_t image = formats::add_view(document, "no picture");
  document.json["images"] = {{{"bufferView", image}, {"mimeType", "image/png"}}};
  document.json["textures"] = {{{"source", 0}}};
  document.json["materials"] = {
      {{"name", "Skin"},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {0.5, 0.25, 0.125, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 0.75}}}},
      {{"name", "Cloth/Red"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}},
      {{"doubleSided", true}}};
  if (change) change(document);
  base::write_whole(path, formats::glb_text(std::move(document)));
}

model::Frame turned(const model::Model& model, std::uint64_t k) {
  model::Frame frame{.index = k,
                     .origin = model.rest_origin,
                     .positions = model.rest,
                     .velocities = model.rest,
                     .surface = {}};
  for (std::size_t i = 0; i < frame.positions.size(); i += 3) {
    float &x = frame.positions[i], &y = frame.positions[i + 1];
    for (std::uint64_t quarter = 0; quarter < k; ++quarter) {
      const float before = x;
      x = -y;
      y = before;
    }
  }
  frame.origin[0] += static_cast<double>(k * k);
  frame.surface = formats::embed(model, frame.positions);
  return frame;
}

void write_dressed_frames(std::unique_ptr<formats::FrameSink> sink, const std::filesystem::path& folder,
                          const DressedOptions& options) {
  write_dressed(folder / "character.glb");
  write_turned_frames(std::move(sink), folder, options);
}

void write_turned_frames(std::unique_ptr<formats::FrameSink> sink, const std::filesystem::path& folder,
                         const DressedOptions& options) {
  const model::Model model = dressed_model();
  const model::Frame initial = turned(model, 0);
  sink->begin({.model = &model,
               .folder = folder,
               .scene_name = "s",
               .fps = fps,
               .start = 1.5,
               .frames = 3,
               .first = 0,
               .initial = &initial,
               .character = folder / "character.glb",
               .glb = options.glb,
               .first_number = options.first_number,
               .usd_skel = options.usd_skel});
  for (std::uint64_t k = 0; k < 4; ++k) sink->write(turned(model, k));
  sink->finish();
}

std::array<double, 3> dressed_point(std::uint64_t k, std::size_t vertex) {
  const model::Model model = dressed_model();
  const model::Frame frame = turned(model, k);
  std::array<double, 3> point{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    point[axis] = frame.origin[axis] + model.unit * double{frame.positions[3 * of_vertex[vertex] + axis]};
  return point;
}

std::array<double, 3> dressed_normal(std::uint64_t k, std::size_t vertex) {
  std::array<double, 3> n{};
  for (std::size_t axis = 0; axis < 3; ++axis) n[axis] = double{dressed_normals[3 * vertex + axis]};
  for (std::uint64_t quarter = 0; quarter < k; ++quarter) n = {-n[1], n[0], n[2]};
  return n;
}

}  // namespace fascicle::tests
