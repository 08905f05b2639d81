// The C API in C++20: handles that free themselves, spans, and fascicle::error in place of status codes. This
// header only wraps calls of fascicle.h, which documents the arguments, units and threads of each function.
// It also refuses what C could not see: a text with a NUL character, and NaN for an optional number.
//
//   fascicle::scene scene("man.glb");
//   fascicle::bake_result bake = fascicle::bake(scene, {.folder = "out", .formats = {"glb", "pc2"}});
//   std::cout << bake.position_hash() << '\n';
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "fascicle.h"

namespace fascicle {

// what() says what failed, where, and what to do.
class error : public std::runtime_error {
 public:
  error(fascicle_status status, const std::string& message) : std::runtime_error(message), status_(status) {}
  fascicle_status status() const noexcept { return status_; }

 private:
  fascicle_status status_;
};

inline void check(fascicle_status status) {
  if (status != FASCICLE_OK) throw error(status, fascicle_last_message());
}

using log_function = std::function<void(fascicle_severity severity, const std::string& message)>;
// Returns whether to continue. May throw: the call is then cancelled and throws the same exception.
using progress_function = std::function<bool(fascicle_phase phase, std::uint64_t done, std::uint64_t total)>;

namespace detail {

template <auto destroy>
struct deleter {
  template <class Handle>
  void operator()(Handle* handle) const noexcept {
    destroy(handle);
  }
};

// Passes a call's C++ callbacks through C, together with their exceptions.
struct callbacks {
  const log_function& log;
  const progress_function& progress;
  std::exception_ptr thrown = nullptr;

  static void on_log(void* user, fascicle_severity severity, const char* message) noexcept {
    auto& self = *static_cast<callbacks*>(user);
    try {
      self.log(severity, message);
    } catch (...) {
      if (!self.thrown) self.thrown = std::current_exception();
    }
  }
  static int on_progress(void* user, fascicle_phase phase, std::uint64_t done, std::uint64_t total) noexcept {
    auto& self = *static_cast<callbacks*>(user);
    try {
      return self.thrown || (self.progress && !self.progress(phase, done, total)) ? 1 : 0;
    } catch (...) {
      self.thrown = std::current_exception();
      return 1;
    }
  }
  void check(fascicle_status status) const {
    if (thrown) std::rethrow_exception(thrown);
    fascicle::check(status);
  }
};

// In C, NaN means "not given".
inline double number(const std::optional<double>& value, const char* name) {
  if (value && std::isnan(*value)) throw error(FASCICLE_BAD_ARGUMENT, std::string(name) + " is NaN");
  return value ? *value : std::nan("");
}
// C would not see what follows a NUL.
inline const char* text(const std::string& value, const char* name) {
  if (value.find('\0') != std::string::npos)
    throw error(FASCICLE_BAD_ARGUMENT, std::string(name) + " holds a NUL character");
  return value.c_str();
}
inline const char* text(const std::optional<std::string>& value, const char* name) {
  return value ? text(*value, name) : nullptr;
}
inline std::vector<const char*> pointers(const std::vector<std::string>& texts, const char* name) {
  std::vector<const char*> result;
  for (const std::string& each : texts) result.push_back(text(each, name));
  return result;
}
// A handle that was moved away owns nothing, and some functions of C take null for a default.
template <class Handle>
Handle* owned(Handle* handle, const char* name) {
  if (handle == nullptr) throw error(FASCICLE_BAD_ARGUMENT, std::string("the ") + name + " was moved from");
  return handle;
}

}  // namespace detail

struct scene_options {
  std::vector<std::string> set = {};  // "layers.fat.alpha=0.2"
  std::optional<std::string> clip = {};
  std::optional<double> fps = {}, start = {}, end = {};
  std::optional<double> softness = {}, exaggerate = {};
  std::optional<std::string> converter = {};
};

class scene {
 public:
  explicit scene(const std::string& name, const scene_options& options = {}) {
    make(options, [&](const fascicle_scene_options* c, fascicle_scene** made) {
      return fascicle_scene_load(detail::text(name, "name"), c, made);
    });
  }
  // From a scene file's text; its file names are relative to `folder`.
  static scene parse(const std::string& text, const std::string& folder = "",
                     const scene_options& options = {}) {
    scene parsed;
    parsed.make(options, [&](const fascicle_scene_options* c, fascicle_scene** made) {
      return fascicle_scene_parse(detail::text(text, "text"), detail::text(folder, "folder"), c, made);
    });
    return parsed;
  }

  std::string name() const { return fascicle_scene_name(detail::owned(get(), "scene")); }
  double fps() const { return fascicle_scene_fps(get()); }
  std::uint64_t frame_count() const { return fascicle_scene_frame_count(get()); }
  std::size_t joint_count() const { return fascicle_scene_joint_count(get()); }
  std::string joint_name(std::size_t joint) const {
    return text_or_throw(fascicle_scene_joint_name(get(), joint));
  }
  std::int32_t joint_parent(std::size_t joint) const { return fascicle_scene_joint_parent(get(), joint); }
  std::size_t clip_count() const { return fascicle_scene_clip_count(get()); }
  std::string clip_name(std::size_t clip) const {
    return text_or_throw(fascicle_scene_clip_name(get(), clip));
  }

  const fascicle_scene* get() const noexcept { return handle_.get(); }

 private:
  scene() = default;
  static std::string text_or_throw(const char* text) {
    if (text == nullptr) throw std::out_of_range("fascicle::scene: there are not so many");
    return text;
  }
  template <class Make>
  void make(const scene_options& options, const Make& call) {
    fascicle_scene_options c = fascicle_scene_options_default();
    const std::vector<const char*> set = detail::pointers(options.set, "set");
    c.set = set.data();
    c.set_count = set.size();
    c.clip = detail::text(options.clip, "clip");
    c.fps = detail::number(options.fps, "fps");
    c.start = detail::number(options.start, "start");
    c.end = detail::number(options.end, "end");
    c.softness = detail::number(options.softness, "softness");
    c.exaggerate = detail::number(options.exaggerate, "exaggerate");
    c.converter = detail::text(options.converter, "converter");
    fascicle_scene* made = nullptr;
    check(call(&c, &made));
    handle_.reset(made);
  }
  std::unique_ptr<fascicle_scene, detail::deleter<fascicle_scene_destroy>> handle_;
};

struct bake_options {
  std::string folder = {};
  std::vector<std::string> formats = {};
  std::string device = "auto";
  std::uint32_t threads = 0;
  std::optional<std::string> mesher = {};
  std::optional<std::string> cache = {};  // "": none
  bool overwrite = false, resume = false, usd_skel = false, keep_frames = true;
  std::optional<std::uint32_t> first_frame = {};
  std::uint64_t glb_stride = 1;
  std::optional<double> glb_error = {}, glb_tolerance = {}, glb_compress = {};  // m
  log_function log = {};
  progress_function progress = {};
};

class bake_result {
 public:
  explicit bake_result(fascicle_bake* made) : handle_(made) {}
  std::uint64_t frames() const { return fascicle_bake_frames(get()); }
  std::string position_hash() const {
    return fascicle_bake_position_hash(detail::owned(get(), "bake_result"));
  }
  double look() const { return fascicle_bake_look(get()); }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (std::size_t k = 0; k < fascicle_bake_file_count(get()); ++k)
      names.emplace_back(fascicle_bake_file(get(), k));
    return names;
  }
  const fascicle_bake* get() const noexcept { return handle_.get(); }

 private:
  std::unique_ptr<fascicle_bake, detail::deleter<fascicle_bake_destroy>> handle_;
};

inline bake_result bake(const scene& scene, const bake_options& options) {
  detail::callbacks callbacks{options.log, options.progress};
  fascicle_bake_options c = fascicle_bake_options_default();
  const std::vector<const char*> formats = detail::pointers(options.formats, "formats");
  c.folder = detail::text(options.folder, "folder");
  c.formats = formats.data();
  c.format_count = formats.size();
  c.device = detail::text(options.device, "device");
  c.threads = options.threads;
  c.mesher = detail::text(options.mesher, "mesher");
  c.cache = detail::text(options.cache, "cache");
  c.overwrite = options.overwrite ? 1 : 0;
  c.resume = options.resume ? 1 : 0;
  c.usd_skel = options.usd_skel ? 1 : 0;
  c.keep_frames = options.keep_frames ? 1 : 0;
  if (options.first_frame) c.first_frame = *options.first_frame;
  c.glb_stride = options.glb_stride;
  c.glb_error = detail::number(options.glb_error, "glb_error");
  c.glb_tolerance = detail::number(options.glb_tolerance, "glb_tolerance");
  c.glb_compress = detail::number(options.glb_compress, "glb_compress");
  if (options.log) c.log = detail::callbacks::on_log;
  c.progress = detail::callbacks::on_progress;
  c.log_user = c.progress_user = &callbacks;
  fascicle_bake* made = nullptr;
  const fascicle_status status = fascicle_bake_run(scene.get(), &c, &made);
  bake_result result(made);
  callbacks.check(status);
  return result;
}

class device {
 public:
  explicit device(const std::string& name = "auto", std::uint32_t threads = 0,
                  const std::optional<std::string>& cache = {}) {
    fascicle_device_options c = fascicle_device_options_default();
    c.threads = threads;
    c.cache = detail::text(cache, "cache");
    fascicle_device* made = nullptr;
    check(fascicle_device_open(detail::text(name, "name"), &c, &made));
    handle_.reset(made);
  }
  std::string text() const { return fascicle_device_text(detail::owned(get(), "device")); }
  bool is_exact() const { return fascicle_device_is_exact(get()) != 0; }
  const fascicle_device* get() const noexcept { return handle_.get(); }

 private:
  std::unique_ptr<fascicle_device, detail::deleter<fascicle_device_destroy>> handle_;
};

struct build_options {
  std::optional<std::string> mesher = {};
  std::optional<std::string> cache = {};  // "": none
  log_function log = {};
  progress_function progress = {};
};

class model {
 public:
  explicit model(const scene& scene, const build_options& options = {}) {
    detail::callbacks callbacks{options.log, options.progress};
    fascicle_build_options c = fascicle_build_options_default();
    c.mesher = detail::text(options.mesher, "mesher");
    c.cache = detail::text(options.cache, "cache");
    if (options.log) c.log = detail::callbacks::on_log;
    c.progress = detail::callbacks::on_progress;
    c.log_user = c.progress_user = &callbacks;
    fascicle_model* made = nullptr;
    const fascicle_status status = fascicle_model_build(scene.get(), &c, &made);
    handle_.reset(made);
    callbacks.check(status);
  }
  // From your own arrays, which are copied.
  explicit model(std::span<const fascicle_array> arrays) {
    fascicle_model* made = nullptr;
    check(fascicle_model_create(arrays.data(), arrays.size(), &made));
    handle_.reset(made);
  }

  std::uint32_t vertex_count() const { return fascicle_model_vertex_count(get()); }
  std::uint32_t tetrahedron_count() const { return fascicle_model_tetrahedron_count(get()); }
  std::uint32_t surface_vertex_count() const { return fascicle_model_surface_vertex_count(get()); }
  std::uint32_t joint_count() const { return fascicle_model_joint_count(get()); }
  std::uint32_t substeps() const { return fascicle_model_substeps(get()); }
  // The data belongs to the model.
  std::vector<fascicle_array> arrays() const {
    std::vector<fascicle_array> all;
    for (fascicle_array array; fascicle_model_array_at(get(), all.size(), &array) == FASCICLE_OK;)
      all.push_back(array);
    return all;
  }
  fascicle_array array(const std::string& name) const {
    fascicle_array found;
    check(fascicle_model_array(get(), detail::text(name, "name"), &found));
    return found;
  }
  const fascicle_model* get() const noexcept { return handle_.get(); }

 private:
  std::unique_ptr<fascicle_model, detail::deleter<fascicle_model_destroy>> handle_;
};

struct solver_options {
  std::optional<std::string> rotation =
      {};  // "qcp", "mueller2016"; absent, here and below: as the scene says
  std::optional<std::uint32_t> iterations = {};  // per implicit substep
  std::optional<double> viscosity = {};          // s, of an implicit model
};

class solver {
 public:
  // On the device that "auto" selects: device_text() says which.
  explicit solver(const model& model, const solver_options& options = {}) { make(model, nullptr, options); }
  solver(const model& model, const device& device, const solver_options& options = {}) {
    make(model, detail::owned(device.get(), "device"), options);
  }

  void start_clip(const progress_function& progress = {}) {
    const log_function none;
    detail::callbacks callbacks{none, progress};
    callbacks.check(fascicle_solver_start_clip(get(), detail::callbacks::on_progress, &callbacks));
  }
  void step_clip() { check(fascicle_solver_step_clip(get())); }

  // 16 numbers per joint, row by row; see fascicle_pose.
  void start_pose(std::span<const double> joints) {
    check(fascicle_solver_start_pose(get(), joints.data(), joints.size()));
  }
  // One pose, or one for each substep. Throws std::invalid_argument unless the numbers form whole poses.
  void step_pose(std::span<const double> joints, double time = std::nan(""), bool jumps = false) {
    fascicle_pose pose = fascicle_pose_default();
    const std::size_t one = 16 * std::size_t{joint_count_};
    if (one == 0 ? !joints.empty() : joints.empty() || joints.size() % one != 0)
      throw std::invalid_argument("fascicle::solver::step_pose: " + std::to_string(joints.size()) +
                                  " numbers; a pose has " + std::to_string(one));
    pose.joints = joints.data();
    pose.pose_count = one == 0 ? 1 : joints.size() / one;
    pose.time = time;
    pose.jumps = jumps ? 1 : 0;
    check(fascicle_solver_step_pose(get(), &pose));
  }
  std::vector<double> clip_pose(std::uint64_t frame) {
    std::vector<double> joints(16 * std::size_t{joint_count_});
    check(fascicle_solver_clip_pose(get(), frame, joints.data(), joints.size()));
    return joints;
  }
  void step_drive(const fascicle_drive& drive) { check(fascicle_solver_step_drive(get(), &drive)); }

  // The arrays belong to the solver and are valid until it is next started, stepped or loaded.
  fascicle_frame frame() const {
    fascicle_frame frame;
    check(fascicle_solver_frame(get(), &frame));
    return frame;
  }
  // Metres in the world, 3 per vertex.
  void positions(std::span<float> metres) const {
    check(fascicle_solver_positions(get(), metres.data(), metres.size()));
  }
  void surface(std::span<float> metres) const {
    check(fascicle_solver_surface(get(), metres.data(), metres.size()));
  }
  std::vector<float> positions() const {
    std::vector<float> metres(3 * frame().vertex_count);
    positions(metres);
    return metres;
  }
  std::vector<float> surface() const {
    std::vector<float> metres(3 * frame().surface_vertex_count);
    surface(metres);
    return metres;
  }
  std::string position_hash() const {
    char text[17] = {};
    check(fascicle_solver_position_hash(get(), text));
    return text;
  }

  std::string device_text() const { return fascicle_solver_device_text(detail::owned(get(), "solver")); }

  std::vector<std::byte> save() const {
    std::size_t size = 0;
    check(fascicle_solver_save(get(), nullptr, 0, &size));
    std::vector<std::byte> bytes(size);
    check(fascicle_solver_save(get(), bytes.data(), bytes.size(), &size));
    return bytes;
  }
  void load(std::span<const std::byte> bytes) {
    check(fascicle_solver_load(get(), bytes.data(), bytes.size()));
  }

  fascicle_solver* get() const noexcept { return handle_.get(); }

 private:
  void make(const model& model, const fascicle_device* device, const solver_options& options) {
    fascicle_solver_options c = fascicle_solver_options_default();
    c.rotation = detail::text(options.rotation, "rotation");
    // In C, 0 means "as the scene says" and is not a number of iterations.
    if (options.iterations == 0u)
      throw error(FASCICLE_BAD_ARGUMENT, "solver_options.iterations is 0; it must be from 1 to 1000");
    c.iterations = options.iterations.value_or(0);
    c.viscosity = detail::number(options.viscosity, "viscosity");
    fascicle_solver* made = nullptr;
    check(fascicle_solver_create(model.get(), device, &c, &made));
    handle_.reset(made);
    joint_count_ = model.joint_count();
  }
  std::unique_ptr<fascicle_solver, detail::deleter<fascicle_solver_destroy>> handle_;
  std::uint32_t joint_count_ = 0;
};

inline std::string version() {
  return fascicle_version();
}

}  // namespace fascicle
