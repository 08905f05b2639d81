#include "host/pipeline/kept_model.h"

#include <string_view>
#include <utility>

#include "host/bake/bake.h"
#include "host/bake/model_file.h"
#include "host/base/content_hash.h"
#include "host/build/byte_archive.h"
#include "host/build/cache.h"
#include "host/build/filled_body.h"
#include "host/build/report_fields.h"
#include "host/scene/input_files.h"
#include "host/scene/scene_json.h"

namespace fascicle::pipeline {
namespace {

// All parameters except those that only describe the motion and its timing.
scene::Json parameters_of(const scene::Scene& scene) {
  scene::Json parameters = json_of(scene);
  // Its values are included one by one.
  parameters.erase("text");
  // If it decides anything, contact.self differs.
  parameters["contact"].erase("unless_torn");
  // Several characters share one clip that combines theirs, and its poses determine how their bodies are
  // filled.
  if (!scene.characters.empty()) return parameters;
  for (const char* key : {"fps", "start", "end", "frames", "gravity", "motion"}) parameters.erase(key);
  // A channel of the clip may drive muscles.
  if (scene.muscles.empty()) {
    parameters.erase("clip");
    parameters.erase("clip_name");
  }
  return parameters;
}

}  // namespace

std::optional<std::string> kept_model_key(const scene::Scene& scene, const build::BuildOptions& options) {
  // A scene made in memory, not read, has nothing that identifies its geometry.
  if (options.cache.empty() || scene.input_hashes.empty() || scene::is_converted(scene)) return std::nullopt;
  const std::optional<std::string> programs = build::hash_of_programs(options);
  if (!programs) return std::nullopt;
  base::ContentHash hash;
  hash.add(std::string_view("model"));
  hash.add(*programs);
  hash.add(scene::dump(parameters_of(scene)));
  for (const auto& [file, file_hash] : scene.input_hashes) hash.add(file_hash);
  return hash.text();
}

std::optional<KeptModel> find_kept_model(const std::string& key, const build::BuildOptions& options) {
  const std::optional<std::string> bytes = build::Cache(options.cache).find(key);
  if (!bytes) return std::nullopt;
  try {
    KeptModel kept;
    build::ByteReader read(*bytes);
    read(kept.report);
    if (!build::is_usable(kept.report.fill.cage.ends)) return std::nullopt;
    kept.model = bake::decode_model(read.rest());
    return kept;
  } catch (const build::ByteReader::Damaged&) {
    return std::nullopt;
  } catch (const bake::BakeError&) {
    return std::nullopt;
  }
}

void keep_model(const std::string& key, const model::Model& model, const build::Report& report,
                const build::BuildOptions& options) {
  std::string bytes;
  build::ByteWriter write(bytes);
  write(report);
  bytes += bake::encode_model(model);
  build::Cache(options.cache).put(key, bytes);
}

}  // namespace fascicle::pipeline
