#include "host/formats/usd_text.h"

#include <utility>
#include <vector>

#include "host/base/text.h"

namespace fascicle::formats {

namespace {

std::string color(const std::array<double, 3>& c) {
  return '(' + base::number_text(c[0]) + ", " + base::number_text(c[1]) + ", " + base::number_text(c[2]) +
         ')';
}

std::string bound_to(const SurfaceMaterial& material, const std::string& path) {
  return "rel material:binding = <" + usd_material_path(material, path) + '>';
}

std::string texture_shaders(const SurfaceMaterial& material, const std::string& of, int level) {
  const std::array<double, 3>& c = material.color;
  const std::string scale = '(' + base::number_text(c[0]) + ", " + base::number_text(c[1]) + ", " +
                            base::number_text(c[2]) + ", " + base::number_text(material.alpha) + ')';
  const auto wrap = [](gltf::TextureWrap way) {
    return way == gltf::TextureWrap::clamp ? "clamp" : way == gltf::TextureWrap::mirror ? "mirror" : "repeat";
  };
  const std::string alpha = is_opaque(material) ? "" : usd_line(level + 1, "float outputs:a");
  return usd_line(level, "def Shader \"Texture\"") + usd_line(level, "{") +
         usd_line(level + 1, "uniform token info:id = \"UsdUVTexture\"") +
         usd_line(level + 1, "asset inputs:file = @./" + material.texture + '@') +
         usd_line(level + 1, "float4 inputs:scale = " + scale) +
         usd_line(level + 1, "token inputs:sourceColorSpace = \"sRGB\"") +
         usd_line(level + 1, "float2 inputs:st.connect = <" + of + "/Coordinates.outputs:result>") +
         usd_line(level + 1, std::string("token inputs:wrapS = \"") + wrap(material.wrap_across) + '"') +
         usd_line(level + 1, std::string("token inputs:wrapT = \"") + wrap(material.wrap_up) + '"') + alpha +
         usd_line(level + 1, "float3 outputs:rgb") + usd_line(level, "}") +
         usd_line(level, "def Shader \"Coordinates\"") + usd_line(level, "{") +
         usd_line(level + 1, "uniform token info:id = \"UsdPrimvarReader_float2\"") +
         usd_line(level + 1, "string inputs:varname = \"st\"") +
         usd_line(level + 1, "float2 outputs:result") + usd_line(level, "}");
}

std::string material_prim(const SurfaceMaterial& material, const std::string& path, int level) {
  const std::string own = usd_material_path(material, path);
  std::string text =
      usd_line(level, "def Material \"" + material.identifier + "\" (") +
      usd_line(level + 1, "displayName = " + usd_string(material.name)) + usd_line(level, ")") +
      usd_line(level, "{") +
      usd_line(level + 1, "token outputs:surface.connect = <" + own + "/Surface.outputs:surface>") +
      usd_line(level + 1, "def Shader \"Surface\"") + usd_line(level + 1, "{") +
      usd_line(level + 2, "uniform token info:id = \"UsdPreviewSurface\"");
  text +=
      material.texture.empty()
          ? usd_line(level + 2, "color3f inputs:diffuseColor = " + color(material.color))
          : usd_line(level + 2, "color3f inputs:diffuseColor.connect = <" + own + "/Texture.outputs:rgb>");
  text += usd_line(level + 2, "color3f inputs:emissiveColor = " + color(material.emission)) +
          usd_line(level + 2, "float inputs:metallic = " + base::number_text(material.metallic));
  const bool is_masked = material.alpha_mode == gltf::AlphaMode::mask;
  const bool is_textured = !material.texture.empty() && !is_opaque(material);
  text += is_textured
              ? usd_line(level + 2, "float inputs:opacity.connect = <" + own + "/Texture.outputs:a>")
              : usd_line(level + 2, "float inputs:opacity = " + base::number_text(opacity_of(material)));
  if (is_masked)
    text +=
        usd_line(level + 2, "float inputs:opacityThreshold = " + base::number_text(material.alpha_cutoff));
  text += usd_line(level + 2, "float inputs:roughness = " + base::number_text(material.roughness));
  if (material.specular)
    text += usd_line(level + 2, "color3f inputs:specularColor = " + color(*material.specular)) +
            usd_line(level + 2, "int inputs:useSpecularWorkflow = 1");
  text += usd_line(level + 2, "token outputs:surface") + usd_line(level + 1, "}");
  if (!material.texture.empty()) text += texture_shaders(material, own, level + 1);
  return text + usd_line(level, "}");
}

}  // namespace

std::string usd_line(int level, const std::string& text) {
  return std::string(static_cast<std::size_t>(level) * 4, ' ') + text + '\n';
}

std::string usd_string(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

std::string usd_tuples(std::span<const float> values, std::size_t width) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); i += width) {
    text += i == 0 ? "(" : ", (";
    for (std::size_t axis = 0; axis < width; ++axis) {
      if (axis > 0) text += ", ";
      text += base::number_text(values[i + axis]);
    }
    text += ')';
  }
  return text + ']';
}

std::string usd_numbers(std::span<const std::uint32_t> values) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) text += (i == 0 ? "" : ", ") + base::number_text(values[i]);
  return text + ']';
}

std::string usd_material_path(const SurfaceMaterial& material, const std::string& path) {
  return path + '/' + material.identifier;
}

std::string usd_materials(const SurfaceObjects& surface, const std::string& path, int level) {
  if (surface.materials.empty()) return {};
  std::string text =
      usd_line(level, "def Scope \"" + path.substr(path.rfind('/') + 1) + '"') + usd_line(level, "{");
  for (const SurfaceMaterial& material : surface.materials) text += material_prim(material, path, level + 1);
  return text + usd_line(level, "}");
}

UsdBinding usd_binding(const SurfaceObjects& surface, const SurfaceObject& object, const std::string& path,
                       int level) {
  UsdBinding binding;
  if (object.face_sets.empty()) return binding;
  std::size_t bound = 0;
  bool double_sided = true;
  for (const FaceSet& set : object.face_sets) {
    bound += set.triangles.size();
    double_sided = double_sided && surface.materials[set.material].double_sided;
  }
  const bool all = 3 * bound == object.triangle.size();
  if (double_sided) binding.properties += usd_line(level, "uniform bool doubleSided = 1");
  if (all && object.face_sets.size() == 1) {
    binding.properties +=
        usd_line(level, bound_to(surface.materials[object.face_sets.front().material], path));
    return binding;
  }
  binding.properties += usd_line(level, std::string("uniform token subsetFamily:materialBind:familyType = ") +
                                            (all ? "\"partition\"" : "\"nonOverlapping\""));
  for (const FaceSet& set : object.face_sets) {
    const SurfaceMaterial& material = surface.materials[set.material];
    binding.subsets += usd_line(level, "def GeomSubset \"" + material.identifier + "\" (") +
                       usd_line(level + 1, "prepend apiSchemas = [\"MaterialBindingAPI\"]") +
                       usd_line(level, ")") + usd_line(level, "{") +
                       usd_line(level + 1, "uniform token elementType = \"face\"") +
                       usd_line(level + 1, "uniform token familyName = \"materialBind\"") +
                       usd_line(level + 1, "int[] indices = " + usd_numbers(set.triangles)) +
                       usd_line(level + 1, bound_to(material, path)) + usd_line(level, "}");
  }
  return binding;
}

UsdMesh usd_mesh(const SurfaceObjects& surface, const SurfaceObject& object, const std::string& materials,
                 const std::string& schemas, int level) {
  const UsdBinding binding = usd_binding(surface, object, materials, level + 1);
  std::string list = schemas.empty() ? "" : usd_string(schemas);
  if (!object.face_sets.empty()) list += (list.empty() ? "" : ", ") + usd_string("MaterialBindingAPI");
  std::string head = usd_line(level, "def Mesh \"" + object.identifier + "\" (") +
                     usd_line(level + 1, "displayName = " + usd_string(object.name));
  if (!list.empty()) head += usd_line(level + 1, "prepend apiSchemas = [" + list + ']');
  head += usd_line(level, ")") + usd_line(level, "{") +
          usd_line(level + 1, "int[] faceVertexCounts = " +
                                  usd_numbers(std::vector<std::uint32_t>(object.triangle.size() / 3, 3))) +
          usd_line(level + 1, "int[] faceVertexIndices = " + usd_numbers(object.triangle)) +
          usd_line(level + 1, "uniform token orientation = \"rightHanded\"") +
          usd_line(level + 1, "uniform token subdivisionScheme = \"none\"") + binding.properties;
  if (!object.uvs.empty())
    head += usd_line(level + 1, "texCoord2f[] primvars:st = " + usd_tuples(object.uvs, 2) + " (") +
            usd_line(level + 2, "interpolation = \"vertex\"") + usd_line(level + 1, ")");
  return {.head = std::move(head), .tail = binding.subsets + usd_line(level, "}")};
}

}  // namespace fascicle::formats
