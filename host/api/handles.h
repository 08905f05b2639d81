// The structs behind the C API's handles. Each shares ownership of what it needs, so that handles may be
// destroyed in any order.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>
#include <unistd.h>

#include "host/api/boundary.h"
#include "host/api/saved_state.h"
#include "host/bake/bake.h"
#include "host/drive/drive_source.h"
#include "host/drive/pose_drive.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/pipeline/device_choice.h"
#include "host/scene/scene.h"
#include "include/fascicle/fascicle.h"

namespace fascicle::api {

// A model with the scene it was built from. A model given as arrays has no scene and no substeps.
struct Body {
  std::optional<const scene::Scene> scene;
  std::uint32_t substeps = 0;  // per frame
  model::Model model;
  model::SolverOptions options;
  std::vector<fascicle_array> arrays;  // views into the model and into `bytes`
  std::deque<std::string> bytes;       // names, and values that the model does not store contiguously
};

// Fills `arrays`; the body must not move afterwards.
void list_arrays(Body& body);
// The inverse. Throws BadArgument for names, types and counts that do not match a model.
model::Model model_of_arrays(const fascicle_array* arrays, std::size_t count);

// Destroys a handle whose threads run in its own process only. In a fork they are gone, and waiting for them
// would never end: there the handle is left alone.
template <class Handle>
void destroy_in_own_process(Handle* handle) {
  if (handle != nullptr && handle->process == getpid()) delete handle;
}

// Throws BadArgument for null, and for a handle that was made before this process was forked.
template <class Handle>
void must_be_usable(const Handle* handle, const char* name) {
  must_have(handle, name);
  if (handle->process != getpid())
    throw BadArgument(std::string("the ") + name + " belongs to process " + std::to_string(handle->process) +
                      ", of which this is a fork; create one in this process");
}

}  // namespace fascicle::api

struct fascicle_scene {
  fascicle::scene::Scene scene;
};

struct fascicle_bake {
  fascicle::bake::BakeResult result;
  std::vector<std::string> files;
};

struct fascicle_device {
  pid_t process = getpid();  // a fork of it has no threads of the device
  std::shared_ptr<fascicle::pipeline::ChosenDevice> device;
  std::string text;
};

struct fascicle_model {
  std::shared_ptr<const fascicle::api::Body> body;
};

struct fascicle_solver {
  pid_t process = getpid();  // a fork of it has no threads of the solver
  std::shared_ptr<const fascicle::api::Body> body;
  std::shared_ptr<fascicle::pipeline::ChosenDevice> device;  // outlives the solver
  std::string device_text;
  std::unique_ptr<fascicle::model::Solver> solver;
  fascicle::model::SolverOptions options;
  std::optional<fascicle::drive::DriveSource> clip;
  std::optional<fascicle::drive::PoseDrive> poses;
  fascicle::api::Driven driven = fascicle::api::Driven::no;
  std::uint64_t frame = 0;
  double time = 0.0;               // s; scene time at the end of the frame
  fascicle::model::Frame shown{};  // the current frame
};
