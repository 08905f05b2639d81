// Level 1: bakes, and their devices.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "python/module.h"

namespace fascicle_python {

struct BakeResult {
  std::string folder;
  fascicle::bake_result result;
};

namespace {

using Path = std::filesystem::path;
using Length = std::optional<double>;

BakeResult run_bake(const fascicle::scene& scene, const Path& folder, const std::vector<std::string>& formats,
                    const std::string& device, std::uint32_t threads, const std::optional<Path>& mesher,
                    const std::optional<Path>& cache, bool overwrite, bool resume, bool keep_frames,
                    bool usd_skel, std::optional<std::uint32_t> first_frame, std::uint64_t glb_stride,
                    Length glb_error, Length glb_tolerance, Length glb_compress, const py::object& progress,
                    const py::object& log) {
  fascicle::bake_options options;
  options.folder = folder.string();
  options.formats = formats;
  options.device = device;
  options.threads = threads;
  options.mesher = path_text(mesher);
  options.cache = path_text(cache);
  options.overwrite = overwrite;
  options.resume = resume;
  options.keep_frames = keep_frames;
  options.usd_skel = usd_skel;
  options.first_frame = first_frame;
  options.glb_stride = glb_stride;
  options.glb_error = glb_error;
  options.glb_tolerance = glb_tolerance;
  options.glb_compress = glb_compress;
  options.progress = progress_to(progress);
  options.log = log_to(log);
  return without_lock([&] { return BakeResult{options.folder, fascicle::bake(scene, options)}; });
}

std::shared_ptr<Device> open_device(const std::string& name, std::uint32_t threads,
                                    const std::optional<Path>& cache) {
  return without_lock(
      [&] { return std::make_shared<Device>(Device{fascicle::device(name, threads, path_text(cache))}); });
}

constexpr const char* device_text = R"(A GPU or the CPU, ready to run solvers.

    name     "auto" (the best real GPU that passes its self-test, else the CPU), "cpu", "cpu:LEVEL" (scalar,
             baseline, sse4, avx2, avx512), "vulkan" or "vulkan:N"
    threads  of the CPU solver; 0: one per core
    cache    folder for compiled shaders; "": none; None: the program's default

Raises NoSuchDevice.)";

}  // namespace

void add_bake(py::module_& module) {
  using namespace py::literals;
  const py::none none;
  py::class_<BakeResult> result(module, "BakeResult", "The result of a bake.");
  result.attr("__module__") = "fascicle";
  result
      .def_property_readonly(
          "folder", [](const BakeResult& self) { return path_object(self.folder); },
          "The folder that was written.")
      .def_property_readonly(
          "frames", [](const BakeResult& self) { return self.result.frames(); }, "Frames done after frame 0.")
      .def_property_readonly(
          "position_hash", [](const BakeResult& self) { return self.result.position_hash(); },
          "The hash of the last frame, 16 hex digits, as the program prints it: equal hashes, equal bits.")
      .def_property_readonly(
          "look", [](const BakeResult& self) { return self.result.look(); },
          "The worst look score; 1 is the limit. NaN if it was not measured.")
      .def_property_readonly(
          "files",
          [](const BakeResult& self) {
            py::list files;
            for (const std::string& file : self.result.files()) files.append(path_object(file));
            return files;
          },
          "The files that were written.")
      .def("__repr__", [](const BakeResult& self) {
        return text_object("<fascicle.BakeResult '" + self.folder + "', " +
                           std::to_string(self.result.frames()) + " frames>");
      });
  module.def("run_bake", &run_bake, "scene"_a, "folder"_a, py::kw_only(), "formats"_a, "device"_a,
             "threads"_a, "mesher"_a.none(true), "cache"_a.none(true), "overwrite"_a, "resume"_a,
             "keep_frames"_a, "usd_skel"_a, "first_frame"_a.none(true), "glb_stride"_a,
             "glb_error"_a.none(true), "glb_tolerance"_a.none(true), "glb_compress"_a.none(true),
             "progress"_a.none(true), "log"_a.none(true), "See fascicle.bake.");
}

void add_device(py::module_& module) {
  using namespace py::literals;
  py::class_<Device, std::shared_ptr<Device>> device(module, "Device", device_text);
  device.attr("__module__") = "fascicle";
  define_init(device, &open_device, "name"_a = "auto", "threads"_a = 0, "cache"_a = py::none(),
              "Opens a device.");
  device
      .def_property_readonly(
          "text", [](const Device& self) { return text_object(self.device.text()); }, "One line for people.")
      .def_property_readonly(
          "is_exact", [](const Device& self) { return self.device.is_exact(); },
          "Whether it gives the same bits as every other exact device.")
      .def("__repr__",
           [](const Device& self) { return text_object("<fascicle.Device '" + self.device.text() + "'>"); });
}

}  // namespace fascicle_python
