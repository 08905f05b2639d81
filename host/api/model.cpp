// Models of the C API.
#include <string_view>

#include "host/api/boundary.h"
#include "host/api/handles.h"
#include "host/pipeline/build_scene.h"

namespace fascicle::api {
namespace {

const model::Model* model_in(const fascicle_model* model) {
  return model == nullptr ? nullptr : &model->body->model;
}

}  // namespace
}  // namespace fascicle::api

using namespace fascicle;

void fascicle_build_options_init(fascicle_build_options* options, size_t struct_size) {
  api::fill(options, struct_size, fascicle_build_options{});
}

fascicle_status fascicle_model_build(const fascicle_scene* scene, const fascicle_build_options* options,
                                     fascicle_model** model) {
  return api::guarded_make(model, [&] {
    api::must_have(scene, "scene");
    const auto taken = api::taken(options, fascicle_build_options_init, "options");
    build::BuildOptions paths;
    paths.mesher = api::text_of(taken.mesher);
    paths.cache = api::cache_of(taken.cache);
    if (taken.progress != nullptr)
      paths.is_cancelled = [&taken] {
        return taken.progress(taken.progress_user, FASCICLE_PHASE_BUILD, 0, 0) != 0;
      };
    const pipeline::Say say = api::say_to(taken.log, taken.log_user);
    const auto body = std::make_shared<api::Body>();
    body->scene.emplace(scene->scene);
    pipeline::Built built = pipeline::build_scene(*body->scene, paths, say);
    pipeline::say_warnings(built.report, say);
    body->options = pipeline::solver_options(*body->scene, built.steps);
    body->substeps = built.steps.substeps;
    body->model = std::move(built.model);
    api::list_arrays(*body);
    return std::make_unique<fascicle_model>(fascicle_model{body});
  });
}

fascicle_status fascicle_model_create(const fascicle_array* arrays, size_t count, fascicle_model** model) {
  return api::guarded_make(model, [&] {
    const auto body = std::make_shared<api::Body>();
    body->model = api::model_of_arrays(arrays, count);
    if (body->model.is_implicit()) body->options.integrator = model::Integrator::implicit_step;
    api::list_arrays(*body);
    return std::make_unique<fascicle_model>(fascicle_model{body});
  });
}

void fascicle_model_destroy(fascicle_model* model) {
  delete model;
}

uint32_t fascicle_model_vertex_count(const fascicle_model* model) {
  return model == nullptr ? 0 : api::model_in(model)->vertex_count;
}

uint32_t fascicle_model_tetrahedron_count(const fascicle_model* model) {
  return model == nullptr ? 0 : api::model_in(model)->tetrahedron_count();
}

uint32_t fascicle_model_surface_vertex_count(const fascicle_model* model) {
  return model == nullptr ? 0 : api::model_in(model)->surface_count();
}

uint32_t fascicle_model_joint_count(const fascicle_model* model) {
  return model == nullptr ? 0 : api::model_in(model)->joint_count;
}

uint32_t fascicle_model_substeps(const fascicle_model* model) {
  return model == nullptr ? 0 : model->body->substeps;
}

fascicle_status fascicle_model_array_at(const fascicle_model* model, size_t index, fascicle_array* array) {
  return api::guarded([&] {
    api::must_have(model, "model");
    api::must_have(array, "array");
    const auto& arrays = model->body->arrays;
    if (index >= arrays.size())
      throw api::BadArgument("there is no array " + std::to_string(index) + ", only " +
                             std::to_string(arrays.size()));
    *array = arrays[index];
  });
}

fascicle_status fascicle_model_array(const fascicle_model* model, const char* name, fascicle_array* array) {
  return api::guarded([&] {
    api::must_have(model, "model");
    api::must_have(name, "name");
    api::must_have(array, "array");
    for (const fascicle_array& found : model->body->arrays)
      if (std::string_view(found.name) == name) {
        *array = found;
        return;
      }
    throw api::BadArgument("there is no array \"" + std::string(name) + "\" in a model");
  });
}
