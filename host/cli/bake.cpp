// fascicle bake: a scene in, a folder of files out.
#include "host/bake/bake.h"

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include "host/bake/folder.h"
#include "host/bake/options.h"
#include "host/bake/outputs.h"
#include "host/cli/command.h"
#include "host/cli/estimate.h"
#include "host/cli/interrupt.h"
#include "host/cli/many_bakes.h"
#include "host/cli/memory.h"
#include "host/cli/progress.h"
#include "host/cli/text.h"
#include "host/formats/blender_script.h"
#include "host/formats/formats.h"
#include "host/formats/vtk_xml.h"
#include "host/pipeline/bake_scene.h"
#include "host/pipeline/device_choice.h"
#include "host/rig/pose.h"
#include "host/scene/input_files.h"
#include "host/scene/jobs.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;

struct BakeArguments {
  SceneArguments scene;
  std::vector<std::string> clips;    // bake several, each into its own folder; {"all"}
  std::vector<std::string> options;  // options from the command line that apply to each clip
  unsigned at_once = 0;
  std::string folder;       // output folder
  bake::BakeOutput output;  // everything except the folder
  std::string device = "auto";
  unsigned threads = 0;
  bool dry_run = false;
};

bool wants(const BakeArguments& arguments, const std::string& format) {
  return std::find(arguments.output.formats.begin(), arguments.output.formats.end(), format) !=
         arguments.output.formats.end();
}

// Size of the glTF file, whose morph targets can grow out of hand; empty if none is requested.
std::string glb_size_text(const BakeArguments& arguments, const scene::Scene& scene,
                          const model::Model& model) {
  if (!wants(arguments, "glb")) return "";
  const std::uint64_t targets = formats::glb_target_count(scene::frame_count(scene), arguments.output.glb);
  return "at most " + bytes_text(formats::format_named("glb").bytes(model, targets)) + ", " +
         counted_text(targets, "morph target", "morph targets") + " of " +
         counted_text(model.surface_count(), "vertex", "vertices");
}

std::string expected_look_text(const scene::Scene& scene, const std::optional<bake::ExpectedLook>& expected,
                               const std::optional<bake::TriedLook>& tried) {
  if (!expected) return "no free flesh on a skeleton";
  if (expected->score <= 0.0) return "nothing makes it swing";
  const auto& skeleton = std::get<rig::Character>(scene.geometry).skeleton;
  std::string text = "swing " + number_text(expected->score, 2) + " (1 is the limit), at joint \"" +
                     skeleton[expected->joint].name + "\" in frame " + std::to_string(expected->frame);
  if (tried)
    text += "; frames " + std::to_string(tried->first + 1) + " to " + std::to_string(tried->last) +
            " were simulated: look " + number_text(tried->worst.score, 3) + ", " + name_of(tried->cause);
  return text;
}

void print_estimate(const BakeArguments& arguments, const PreparedBake& prepared) {
  const scene::Scene& scene = prepared.scene;
  const model::Model& model = prepared.built.model;
  const Estimate estimate = estimate_of(prepared, arguments.output);
  const std::string glb = glb_size_text(arguments, scene, model);
  std::cout
      << "dry run of " << shown_text(scene.name) << ": nothing is written\n"
      << columns_text(
             {{"folder", arguments.folder},
              {"vertices", count_text(model.vertex_count)},
              {"tetrahedra", count_text(model.tetrahedron_count())},
              {"render vertices", count_text(model.surface_count())},
              {"frames", count_text(estimate.frames) + " at " + number_text(scene.fps) + " a second, " +
                             counted_text(prepared.built.steps.substeps, "substep", "substeps") + " each" +
                             (estimate.preroll_frames > 0
                                  ? ", after " + count_text(estimate.preroll_frames) + " of preroll"
                                  : "")},
              {"device", prepared.simulation.device.text()},
              {"solver memory", bytes_text(estimate.solver_bytes)},
              {"output", bytes_text(estimate.output_bytes)},
              {"surface.glb", glb.empty() ? "not asked for" : glb},
              {"expected look", expected_look_text(scene, prepared.expected, prepared.tried)},
              {"time", "about " + duration_text(estimate.seconds) + ", writing in parallel (" +
                           number_text(estimate.seconds_substep * 1e3, 3) + " ms per substep, measured)"}});
}

// "out/arm-worst.png" beside the bake "out/arm".
std::string beside(const std::string& folder, const std::string& ending) {
  fs::path path = (fs::path(folder) / "").lexically_normal().parent_path();
  const std::string name = path.filename().string();
  if (name.empty() || name == "." || name == "..") path = fs::path(folder) / "bake";
  return shell_word(path.string() + ending);
}

// Prints commands that show the kept frames.
void print_how_to_draw(const BakeArguments& arguments, bool has_skeleton) {
  const std::string& folder = arguments.folder;
  const std::string bake = shell_word(folder);
  std::cout << "  the studio: fascicle studio " << bake << "  (to change it while it moves: fascicle studio "
            << shell_word(arguments.scene.name) << ")\n";
  if (has_skeleton)
    std::cout << "  the worst frames beside skinning: fascicle render " << bake << " --compare -o "
              << beside(folder, "-worst.png") << "\n";
  else
    std::cout << "  pictures: fascicle render " << bake << " --sheet 4x2 -o " << beside(folder, "-sheet.png")
              << "\n";
  std::cout << "  a page of pictures and curves: fascicle report " << bake << " -o "
            << beside(folder, "-report.html") << "\n"
            << "  a page that plays it: fascicle view " << bake << " -o " << beside(folder, ".html") << "\n";
}

// Prints how to view each kind of file that was written.
void print_how_to_look(const BakeArguments& arguments, const model::Model& model,
                       const std::vector<fs::path>& files) {
  const auto with_extension = [&files](const std::string& extension) -> const fs::path* {
    for (const fs::path& file : files)
      if (file.extension() == extension) return &file;
    return nullptr;
  };
  std::cout << "to look at it\n";
  if (arguments.output.keep_frames) print_how_to_draw(arguments, model.has_skeleton());
  for (const fs::path& file : files)
    if (const fs::path series = file / formats::vtk_series; fs::exists(series))
      std::cout << "  ParaView: paraview " << shell_word(series.string()) << "  (Apply, then Play)\n";
  if (std::any_of(files.begin(), files.end(), formats::blender_loads))
    std::cout << "  Blender: blender --python "
              << shell_word((fs::path(arguments.folder) / formats::blender_script_name).string()) << "\n";
  if (const fs::path* pc2 = with_extension(".pc2"))
    std::cout << "    or by hand: import rest.obj, add the modifier Mesh Cache, format PC2, file "
              << pc2->string() << ", forward Y, up Z\n";
  if (const fs::path* csv = with_extension(".csv"))
    std::cout << "  any plotter: " << csv->string()
              << "  (energy, volume, largest displacement, probes; one row per frame)\n";
  if (!arguments.output.keep_frames)
    std::cout << "  the frames were not kept: nothing can be exported or drawn later\n";
  else if (bake::formats_to_write(arguments.output).empty())
    std::cout << "  for Blender: fascicle export " << shell_word(arguments.folder)
              << " --to glb,pc2; for ParaView: the same command with --overwrite --format vtu\n";
}

// Prints the frames before frame 0, how well a loop closes, and the lag of the flesh.
void print_motion(const BakeArguments& arguments, const model::Model& model, const bake::BakeResult& result) {
  const drive::LeadInSummary& led = result.lead_in;
  if (led.settled_speed)
    std::cout << "settled for " << counted_text(led.settle_frames, "frame", "frames") << ", to "
              << number_text(*led.settled_speed * 1e3, 3) << " mm/s\n";
  if (result.loop_jump)
    std::cout << "loop: " << counted_text(led.cycles, "cycle", "cycles") << " before it; its end is at most "
              << number_text(*result.loop_jump * 1e3, 3) << " mm from its beginning\n";
  if (result.look && result.look->worst > 0.0)
    std::cout << "look " << number_text(result.look->worst, 3) << " (1 is the limit): worst in frame "
              << result.look->frame << " at joint \"" << shown_text(result.look->joint) << "\", "
              << result.look->cause << "; " << counted_text(result.look->frames_over, "frame", "frames")
              << " over\n";
  for (const bake::PeakLag& peak : bake::peak_lags(arguments.folder, model))
    std::cout << "peak lag of " << peak.layer << ": " << number_text(peak.lag * 1e3, 3) << " mm in frame "
              << peak.frame << "\n";
}

void print_result(const BakeArguments& arguments, const scene::Scene& scene, const model::Model& model,
                  const bake::DeviceDescription& device, const bake::BakeResult& result) {
  std::cout << "baked " << shown_text(scene.name) << ": "
            << counted_text(result.frames_done, "frame", "frames") << " in "
            << duration_text(result.seconds_total) << " (solver " << duration_text(result.seconds_solver)
            << ", writing in parallel " << duration_text(result.seconds_writing) << ")\n"
            << "device: " << device.solver << ", " << device.name << "\n"
            << "position hash of the last frame: " << result.last_position_hash << "\n";
  print_motion(arguments, model, result);
  std::cout << "wrote\n";
  for (const fs::path& file : result.files) std::cout << "  " << file.string() << "\n";
  print_how_to_look(arguments, model, result.files);
}

// "auto" if it could choose a GPU: each bake then tests the GPU, and falls back to the CPU if it must.
std::string device_list(const std::string& device) {
  const std::vector<gpu::DeviceInfo> devices = devices_for(device);
  return device == "auto" && candidates({}, devices).empty() ? "cpu" : with_all_devices(device, devices);
}

ManyBakes bakes_of_clips(const BakeArguments& arguments) {
  if (arguments.scene.name.empty()) throw UsageError("--clips: name a character");
  const std::vector<std::string> formats = bake::formats_to_write(arguments.output);
  const scene::Scene scene = load(arguments.scene);
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  if (character == nullptr || !scene.characters.empty())
    throw UsageError("--clips: " + arguments.scene.name + " is not a single character; --clips needs one");
  ManyBakes many{
      .output = arguments.folder.empty() ? fs::path("out") / scene.name : fs::path(arguments.folder),
      .devices = device_list(arguments.device),
      .at_once = arguments.at_once,
      .threads = arguments.threads,
      .overwrite = arguments.output.overwrite,
      .resume = arguments.output.resume,
      .dry_run = arguments.dry_run};
  const bool is_kept = !arguments.scene.no_cache && !scene::is_converted(scene);
  for (const scene::NamedClip& clip : scene::named_clips(*character, arguments.clips)) {
    SceneArguments one = arguments.scene;
    one.overrides.clip = clip.clip;
    try {
      (void)load(one);  // report errors before the first bake starts
    } catch (const scene::SceneError& error) {
      throw scene::SceneError("clip " + clip.file_name + ": " + error.what());
    }
    OneBake bake{clip.file_name,
                 arguments.scene.name,
                 clip.clip,
                 one.overrides.set,
                 formats,
                 {"--clip=" + clip.clip},
                 is_kept ? "the character's" : ""};
    bake.options.insert(bake.options.end(), arguments.options.begin(), arguments.options.end());
    many.bakes.push_back(std::move(bake));
  }
  return many;
}

// The command line's options as given, except those that bake_many sets for each bake.
std::vector<std::string> shared_options(const CLI::App& subcommand) {
  static const std::vector<std::string> own{"--clips",   "--output",    "--device",    "--threads",
                                            "--at-once", "--overwrite", "--resume",    "--dry-run",
                                            "--quiet",   "--verbose",   "--log-format"};
  std::vector<std::string> options;
  for (const CLI::Option* option : subcommand.get_options()) {
    const std::string name = option->get_name();
    if (option->count() == 0 || !name.starts_with("--") ||
        std::find(own.begin(), own.end(), name) != own.end())
      continue;
    for (const std::string& value : option->results()) options.push_back(name + "=" + value);
  }
  return options;
}

ExitCode bake_scene(BakeArguments arguments, Log& log) {
  if (arguments.scene.name.empty()) {
    arguments.scene.name = scene::default_scene;
    if (arguments.output.formats.empty()) arguments.output.formats = {"pc2", "vtu"};
    log.info(std::string("scene: ") + scene::default_scene + ", the default (fascicle scenes lists more)");
  }
  const std::vector<DeviceRequest> devices = parse_device_order(arguments.device);
  (void)bake::formats_to_write(arguments.output);
  scene::Scene scene = load(arguments.scene);
  if (const auto* character = std::get_if<rig::Character>(&scene.geometry);
      character != nullptr && scene.clip.empty() && character->clips.size() > 1)
    log.info("clip: " + scene::clip_name(scene) + ", the first of " +
             std::to_string(character->clips.size()) + " (fascicle inspect lists them, --clip chooses)");
  if (arguments.folder.empty()) arguments.folder = (fs::path("out") / scene.name).string();
  if (!arguments.dry_run) refuse_unwritable("-o", (fs::path(arguments.folder) / "").string(), true);
  Progress progress(log, "baking", scene::frame_count(scene));
  BakeRequest request;
  request.output = arguments.output;
  request.output.folder = arguments.folder;
  request.writes_nothing = arguments.dry_run;
  request.devices = devices;
  request.threads = arguments.threads;
  request.build = build_options(arguments.scene.no_cache);
  request.interrupted = &interrupts();
  request.on_frame = [&progress](std::uint64_t frame, std::uint64_t) { progress.update(frame); };
  const Say say = say_on(log);
  const std::unique_ptr<PreparedBake> made = prepare_bake(std::move(scene), request, say);
  PreparedBake& prepared = *made;
  if (prepared.is_undecided) {
    log.warning("interrupted before the first frame; the same command starts again");
    return ExitCode::interrupted;
  }
  if (arguments.dry_run) {
    print_estimate(arguments, prepared);
    return ExitCode::done;
  }

  if (const std::string size = glb_size_text(arguments, prepared.scene, prepared.built.model); !size.empty())
    log.info("surface.glb: " + size);
  keep_freed_arrays();
  const bake::BakeResult result = run_bake(prepared, request, say);
  log.clear_bar();
  say_result(result, say);
  if (result.interrupted) {
    log.warning("interrupted after frame " + std::to_string(result.frames_done) + " of " +
                std::to_string(scene::frame_count(prepared.scene)) +
                "; the same command with --resume (and without --overwrite) continues");
    return ExitCode::interrupted;
  }
  print_result(arguments, prepared.scene, prepared.built.model, prepared.simulation.device.description(),
               result);
  return ExitCode::done;
}

}  // namespace

void add_bake(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand("bake", "Simulate a scene and write it to a folder");
  const auto arguments = std::make_shared<BakeArguments>();
  add_scene_options(
      *subcommand, arguments->scene,
      std::string("Scene file, mesh, character or built-in name; default: ") + scene::default_scene, false);
  subcommand
      ->add_option("--clips", arguments->clips,
                   "Bake several clips of the character, or all, in parallel; each goes into a folder of DIR "
                   "that is named after it")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->take_all()
      ->excludes("--clip")
      ->option_text("all|LIST");
  subcommand->add_option("-o,--output", arguments->folder, "Folder to write; default: out/NAME")
      ->option_text("DIR");
  std::string formats;
  for (const std::string& name : bake::format_names()) formats += (formats.empty() ? "" : ",") + name;
  subcommand
      ->add_option("--format", arguments->output.formats,
                   "Formats to write beside the frame cache, manifest and metrics: any of " + formats +
                       ", or none; default: none, but pc2,vtu for the default scene")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->take_all()
      ->check(CLI::IsMember(bake::accepted_formats()).description(""))
      ->option_text("LIST");
  subcommand
      ->add_option("--keep-frames", arguments->output.keep_frames,
                   "false: delete frames.fascicle once all formats are written; the bake can then not be "
                   "exported or drawn later")
      ->option_text("true|false");
  subcommand
      ->add_option("--device", arguments->device,
                   "auto, all, cpu, cpu:LEVEL, vulkan or vulkan:N; auto is a real GPU if there is one, else "
                   "the CPU. In a list, separated by commas, the next device takes over when one fails; with "
                   "--clips they share the bakes")
      ->option_text("LIST");
  subcommand->add_option("--threads", arguments->threads, "Threads of the CPU solver; 0: one per core")
      ->check(CLI::Range(0U, 1024U).description(""))
      ->option_text("N");
  auto* overwrite =
      subcommand->add_flag("--overwrite", arguments->output.overwrite, "Replace the bake in the folder");
  auto* resume =
      subcommand->add_flag("--resume", arguments->output.resume, "Continue the bake in the folder");
  overwrite->excludes(resume);
  subcommand->add_flag(
      "--dry-run", arguments->dry_run,
      "Print sizes, memory and estimated time, or with --clips the command of each bake; write nothing");
  subcommand
      ->add_option("--first-frame", arguments->output.first_number,
                   "Number of the first frame in files for other programs, such as 1001; default: the first "
                   "frame written is 0. Handles before it are numbered downwards")
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1000000}).description(""))
      ->option_text("N");
  add_glb_options(*subcommand, arguments->output.glb);
  add_usd_options(*subcommand, arguments->output.usd_skel);
  add_many_bakes_options(*subcommand, arguments->at_once)->needs("--clips");
  add_log_options(*subcommand, command.log);
  subcommand->callback([arguments, subcommand, &command] {
    arguments->options = shared_options(*subcommand);
    command.watches_interrupts = true;
    command.run = [arguments](Log& log) {
      return arguments->clips.empty() ? bake_scene(*arguments, log)
                                      : bake_many(bakes_of_clips(*arguments), log);
    };
  });
}

}  // namespace fascicle::cli
