#include "host/bake/options.h"

#include <algorithm>

#include "host/bake/outputs.h"
#include "host/base/text.h"
#include "host/formats/formats.h"

namespace fascicle::bake {

std::vector<std::string> accepted_formats() {
  std::vector<std::string> names = format_names();
  names.push_back(no_format);
  return names;
}

std::vector<std::string> formats_to_write(const BakeOutput& output) {
  std::vector<std::string> formats = output.formats;
  const bool is_none = std::erase(formats, no_format) > 0;
  if (is_none && !formats.empty())
    throw ContradictingOptions("--format " + std::string(no_format) + " and --format " + formats.front() +
                               " exclude each other; leave one out");
  if (!output.keep_frames && formats.empty() && !is_none)
    throw ContradictingOptions(
        "--keep-frames false without --format would leave no motion; give a format, or --format none if you "
        "want only the metrics");
  return formats;
}

BakeOptions checked(BakeOptions options, const model::Model& model) {
  if (options.overwrite && options.resume)
    throw BakeError("--overwrite and --resume exclude each other; give one");
  if (options.checkpoint_frames == 0) throw BakeError("checkpoint_frames is 0; it must be at least 1");
  std::vector<std::string> formats, left = formats::with_companions(formats_to_write(options), model);
  std::string names;
  for (const std::string& name : format_names()) {
    names += (names.empty() ? "" : ", ") + name;
    if (std::erase(left, name) > 0) formats.push_back(name);
  }
  if (!left.empty()) throw BakeError("--format " + left.front() + ": no such format; use any of " + names);
  options.formats = std::move(formats);
  return options;
}

std::uint64_t number_of_first(const scene::Scene& scene, const BakeOutput& output) {
  const std::uint64_t handles = scene.motion.handles;
  return first_written(output.first_number.value_or(handles), handles);
}

std::uint32_t substeps_of(const scene::Scene& scene, const BakeOptions& options) {
  return options.substeps ? *options.substeps : scene::stated_substeps(scene);
}

std::uint32_t iterations_of(const scene::Scene& scene, const BakeOptions& options) {
  return options.iterations.value_or(scene.solver.iterations.value_or(model::SolverOptions{}.iterations));
}

std::uint64_t first_written(std::uint64_t first_of_range, std::uint64_t handles) {
  if (first_of_range < handles)
    throw BakeError("--first-frame " + base::number_text(first_of_range) + ": " + base::number_text(handles) +
                    " handles before it would have negative numbers; give at least " +
                    base::number_text(handles));
  return first_of_range - handles;
}

}  // namespace fascicle::bake
