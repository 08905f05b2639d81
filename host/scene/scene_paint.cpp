#include "host/scene/scene_paint.h"

#include <algorithm>
#include <array>

#include "host/base/errors.h"
#include "host/base/text.h"
#include "host/scene/paint_file.h"
#include "host/scene/scene_check.h"

namespace fascicle::scene {
namespace {

constexpr const char* layer_attribute = "_LAYER";
constexpr const char* stiffness_attribute = "_STIFFNESS";
constexpr std::array<const char*, 3> painted_layers{"bone", "muscle", "fat"};  // numbered from 1

bool asks_for(const Layer& layer, const std::string& attribute) {
  return std::any_of(layer.where.begin(), layer.where.end(), [&](const Shape& shape) {
    const auto* painted = std::get_if<Painted>(&shape);
    return painted != nullptr && painted->attribute == attribute;
  });
}

void give_layers(const std::vector<FilePaint>& paint, Scene& scene) {
  const bool is_said = std::any_of(scene.layers.begin(), scene.layers.end(),
                                   [](const Layer& layer) { return asks_for(layer, layer_attribute); });
  if (is_said) return;
  const auto named = [&](int number) -> Layer* {
    const auto found = std::find_if(scene.layers.begin(), scene.layers.end(), [&](const Layer& layer) {
      return layer.name == painted_layers[static_cast<std::size_t>(number) - 1];
    });
    return found == scene.layers.end() ? nullptr : &*found;
  };
  constexpr int last = static_cast<int>(painted_layers.size());
  for (const FilePaint& one : paint)
    for (const int number : one.layers) {
      Layer* layer = number <= last ? named(number) : nullptr;
      if (layer == nullptr)
        fail(one.source, one.key,
             "paints _LAYER " + std::to_string(number) + ", which no layer uses; " +
                 (number <= last ? "name a layer " +
                                       std::string(painted_layers.at(static_cast<std::size_t>(number) - 1)) +
                                       ", or give one"
                                 : std::string("give a layer")) +
                 " where = { painted = { attribute = \"_LAYER\", minimum = " + std::to_string(number) +
                 ", maximum = " + std::to_string(number) + " } }");
      layer->by_paint = {Painted{layer_attribute, number - 0.5, number + 0.5}};
    }
}

void give_stiffness(const std::vector<FilePaint>& paint, Scene& scene) {
  const auto has = std::find_if(paint.begin(), paint.end(),
                                [](const FilePaint& one) { return one.names.contains(stiffness_attribute); });
  if (has == paint.end()) return;
  if (scene.solver.integrator == Integrator::explicit_step)
    for (const FilePaint& one : paint)
      if (one.stiffest > 1.0f)
        fail(one.source, one.key,
             "paints _STIFFNESS up to " + base::short_text(double{one.stiffest}) +
                 ", but here it multiplies alpha, which takes 0 to 1; paint less, or give the "
                 "stiffness as youngs_modulus, frequency or material");
  const bool is_said = std::any_of(scene.layers.begin(), scene.layers.end(), [](const Layer& layer) {
    return layer.alpha_attribute == stiffness_attribute;
  });
  for (Layer& layer : scene.layers)
    if (!is_said && !layer.kinematic && layer.alpha_attribute.empty())
      layer.alpha_attribute = stiffness_attribute;
}

}  // namespace

FilePaint file_paint(const rig::Paint& paint, const toml::source_region& source, const std::string& key) {
  FilePaint of_file{source, key, {}, {}, 0.0f};
  for (const rig::PaintedVertices& attribute : paint.attributes) {
    of_file.names.insert(attribute.name);
    if (attribute.name == stiffness_attribute)
      of_file.stiffest = *std::max_element(attribute.value.begin(), attribute.value.end());
    if (attribute.name != layer_attribute) continue;
    for (const float value : attribute.value)
      if (value != 0.0f) of_file.layers.insert(static_cast<int>(value));
  }
  return of_file;
}

rig::Paint lay_paint_over(const std::filesystem::path& file, LoadedFiles* files, Scene& scene,
                          rig::Character& character) {
  const std::string text =
      files != nullptr ? files->text_of(file, most_paint_bytes) : read_text_file(file, most_paint_bytes);
  rig::Paint paint = parse_paint(text, file, character.surface);
  try {
    rig::lay_over(paint, character);
  } catch (const base::SceneError& error) {
    throw InputFileError(file.string() + ": " + error.what());
  }
  const std::pair<std::string, std::string> input(file.string(), hash_of(text));
  if (std::find(scene.input_hashes.begin(), scene.input_hashes.end(), input) == scene.input_hashes.end())
    scene.input_hashes.push_back(input);
  return paint;
}

void let_paint_act(const std::vector<FilePaint>& paint, Scene& scene) {
  give_layers(paint, scene);
  give_stiffness(paint, scene);
}

}  // namespace fascicle::scene
