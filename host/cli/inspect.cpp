// fascicle inspect: the contents of a scene or a mesh, before anything is simulated.
#include <iostream>
#include <memory>

#include <nlohmann/json.hpp>

#include "host/cli/command.h"
#include "host/cli/inspect_counts.h"
#include "host/cli/inspect_json.h"
#include "host/cli/model_vtu.h"
#include "host/cli/open_ends.h"
#include "host/cli/part_names.h"
#include "host/cli/rigid_rows.h"
#include "host/cli/text.h"
#include "host/pipeline/bake_scene.h"
#include "host/rig/pose.h"

namespace fascicle::cli {
namespace {

using Json = nlohmann::ordered_json;

struct InspectArguments {
  SceneArguments scene;
  std::string model_file;
  bool json = false;
};

// "8 substeps each, of 4 iterations, which leave 2.9 % of a substep's change in the stiffest layer undone"
std::string steps_text(const model::Model& model, const build::Steps& steps) {
  std::string text = counted_text(steps.substeps, "substep", "substeps") + " each";
  if (!model.is_implicit()) return text;
  text += ", of " + counted_text(steps.iterations, "iteration, which leaves ", "iterations, which leave ") +
          number_text(100.0 * steps.error.residual, 2) +
          " % of a substep's change in the stiffest layer undone";
  if (steps.error.slower > 0.0 && !model.has_skeleton())
    text += "; the fastest lowest mode of a layer swings " + number_text(100.0 * steps.error.slower, 2) +
            " % slower";
  return text;
}

std::string millimetres(double metres) {
  return number_text(metres * 1e3) + " mm";
}

void print_parts(const scene::Scene& scene) {
  const PartNames names = names_of_parts(scene);
  for (const auto* list : {&names.objects, &names.materials}) {
    if (!list->empty()) std::cout << (list == &names.objects ? "objects\n" : "materials\n");
    for (const std::string& name : *list) std::cout << "  " << shown_text(name) << "\n";
  }
}

void print_clips(const scene::Scene& scene) {
  std::vector<std::pair<std::string, std::string>> rows;
  const auto add = [&](const rig::Character& character, const std::string& asked, const std::string& owner) {
    const rig::Clip* played = rig::find_clip(character, asked);  // names may be equal
    for (const rig::Clip& clip : character.clips)
      rows.emplace_back(owner + clip.name,
                        number_text(clip.duration, 3) + " s" + (&clip == played ? ", the one to bake" : ""));
  };
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  if (scene.characters.empty() && character != nullptr) add(*character, scene.clip, "");
  for (const scene::PlacedCharacter& one : scene.characters)
    add(one.own, one.settings.clip, one.settings.name + "/");
  if (!rows.empty()) std::cout << "clips\n" << columns_text(rows);
}

std::string place_text(const scene::Vector3d& v) {
  return "(" + number_text(v[0], 3) + ", " + number_text(v[1], 3) + ", " + number_text(v[2], 3) + ")";
}

void print_characters(const scene::Scene& scene) {
  std::vector<std::pair<std::string, std::string>> rows;
  for (const scene::PlacedCharacter& one : scene.characters)
    rows.emplace_back(one.settings.name,
                      (one.file.empty() ? "made " + one.settings.made : one.settings.file) + " at " +
                          place_text(one.settings.at) + " m" +
                          (one.settings.joint.empty() ? "" : " from " + one.settings.joint) + ", turned by " +
                          place_text(one.settings.turn) + " degrees, " +
                          counted_text(one.own.surface.vertices.size(), "vertex", "vertices") + ", " +
                          counted_text(one.own.skeleton.size(), "joint", "joints") +
                          (one.settings.rigid ? "; all of its flesh follows the skeleton" : ""));
  if (!rows.empty()) std::cout << "characters\n" << columns_text(rows);
}

// Prints the bones, and other joints that move at least 0.1 % of the skin.
void print_joints(const build::Report& report) {
  constexpr double least_shown = 1e-3;
  std::vector<std::pair<std::string, std::string>> rows;
  std::size_t left_out = 0;
  for (const build::JointReport& joint : report.joints) {
    if (!joint.is_bone && joint.share < least_shown) {
      ++left_out;
      continue;
    }
    rows.emplace_back(joint.name, joint.reason);
  }
  if (rows.empty()) return;
  std::cout << "skeleton\n" << columns_text(rows);
  if (left_out > 0)
    std::cout << "  and " << counted_text(left_out, "joint that moves", "joints that move")
              << " less than 0.1 %\n";
  if (report.bone_islands == 0) return;
  std::cout << "  bone layer: " << counted_text(report.bone_islands, "connected part", "connected parts");
  if (report.bone_vertices_added > 0)
    std::cout << ", " << count_text(report.bone_islands_before) << " before "
              << counted_text(report.bone_vertices_added, "vertex was", "vertices were") << " added";
  std::cout << "\n";
}

void print_rigid_parts(const build::Report& report) {
  if (report.rigid_parts.empty()) return;
  constexpr std::size_t most_shown = 20;
  const RigidRows shown = rigid_rows(report.rigid_parts, most_shown);
  std::cout << "rigid parts\n" << columns_text(shown.rows);
  if (shown.left_out > 0)
    std::cout << "  and " << counted_text(shown.left_out, "more part", "more parts") << "\n";
}

void print_fibres(const build::FibreReport& fibres) {
  if (fibres.constraints == 0) return;
  const auto percent = [&](std::uint32_t edges) {
    return number_text(100.0 * share_of(edges, fibres.edges), 2) + " % of the edges";
  };
  std::cout << "fibres\n"
            << columns_text({{"given directions", count_text(fibres.constraints)},
                             {"solved in", counted_text(fibres.rounds, "round", "rounds") + " of " +
                                               counted_text(fibres.iterations, "iteration", "iterations") +
                                               " in all, " + number_text(fibres.seconds, 2) + " s"},
                             {"signs differ along", percent(fibres.flipped_edges)},
                             {"lines turn over 60 degrees along", percent(fibres.bent_edges)},
                             {"without a direction", counted_text(fibres.without, "vertex", "vertices")}});
}

std::string spread_text(const build::Spread& spread) {
  return millimetres(spread.low) + " to " + millimetres(spread.high) +
         " (1st to 99th percentile, a factor of " + number_text(spread.ratio(), 3) + ")";
}

void print_skin(const build::Report& report) {
  const build::CageReport& cage = report.fill.cage;
  if (!cage.has_skin) return;
  std::vector<std::pair<std::string, std::string>> rows{
      {"filled as", (cage.is_cage ? "a cage: " : "it is: ") + cage.reason}};
  const auto add = [&rows](const char* what, const build::Finding& finding, std::uint64_t usual = 0) {
    if (finding.count == usual) return;
    std::string text =
        count_text(finding.count) + (finding.vertices.size() == 1 ? ", at vertex" : ", at vertices");
    for (const std::uint32_t v : finding.vertices) text += " " + std::to_string(v);
    rows.emplace_back(what, text);
  };
  const build::SurfaceFindings& found = cage.findings;
  add("parts", found.parts, 1);
  add("vertices in no triangle", found.loose_vertices);
  add("triangles without area", found.flat_triangles);
  add("open edges", found.open_edges);
  add("edges of more than two triangles", found.non_manifold_edges);
  add("points where parts meet", found.non_manifold_vertices);
  add("edges whose triangles face opposite ways", found.turned_edges);
  add("parts that face inward", found.inverted_parts);
  add("pairs of triangles that cross", found.intersections);
  if (found.genus != 0) rows.emplace_back("handles", std::to_string(found.genus));
  rows.emplace_back("skin spacing", spread_text(cage.skin_spacing));
  rows.emplace_back("body spacing", spread_text(cage.spacing));
  if (cage.skin_volume > 0.0)
    rows.emplace_back("volume", number_text(100.0 * report.volume / cage.skin_volume) + " % of the skin's " +
                                    number_text(cage.skin_volume * 1e3) + " litres");
  for (auto& row : rows_of(open_ends_of(report))) rows.push_back(std::move(row));
  if (cage.is_cage) {
    rows.emplace_back("gaps closed", "below about " + millimetres(2.0 * cage.alpha));
    rows.emplace_back("cut apart", counted_text(cage.cut_tetrahedra, "tetrahedron", "tetrahedra") +
                                       " between limbs that touch");
  }
  std::cout << "skin (vertices are the file's)\n" << columns_text(rows);
}

void print_text(const scene::Scene& scene, const Built& built) {
  const build::Report& report = built.report;
  const model::Model& model = built.model;
  std::cout << shown_text(scene.name) << "\n"
            << columns_text(
                   {{"source", scene.source},
                    {"vertices",
                     count_text(report.vertices) + ", " + count_text(report.pinned_vertices) + " pinned"},
                    {"tetrahedra", count_text(report.tetrahedra)},
                    {"surface", counted_text(report.surface_vertices, "vertex", "vertices") + ", " +
                                    counted_text(report.surface_triangles, "triangle", "triangles")},
                    {"joints", count_text(model.joint_count)},
                    {"one-rings", count_text(model.ring.size()) + " entries, " +
                                      std::to_string(longest_ring(model)) + " at most in one"},
                    {"volume", number_text(report.volume * 1e3) + " litres"},
                    {"mass", number_text(report.mass) + " kg"},
                    {"edges", millimetres(report.mean_edge) + " on average, " +
                                  millimetres(report.shortest_edge) + " to " +
                                  millimetres(report.longest_edge)},
                    {"working unit", number_text(model.unit) + " m"},
                    {"time", counted_text(scene::frame_count(scene), "frame", "frames") + " at " +
                                 number_text(scene.fps) + " a second, " + steps_text(model, built.steps)},
                    {"weights", model::name_of(model.weight_form)},
                    {"solver memory", bytes_text(model::solver_bytes(model))}});
  print_skin(report);
  print_characters(scene);
  print_parts(scene);
  print_clips(scene);
  std::vector<std::pair<std::string, std::string>> rows;
  std::cout << "layers\n";
  for (const build::LayerShare& layer : report.layers)
    rows.emplace_back(layer.name, counted_text(layer.vertices, "vertex", "vertices") + ", " +
                                      number_text(100.0 * share_of(layer.volume, report.volume), 3) +
                                      " % of the volume, " + number_text(layer.mass) + " kg");
  std::cout << columns_text(rows);
  print_joints(report);
  print_rigid_parts(report);
  print_fibres(report.fibres);

  rows.clear();
  for (const MuscleCount& muscle : count_muscles(scene, model))
    rows.emplace_back(muscle.name, counted_text(muscle.regions, "region", "regions") + " on the bone of " +
                                       muscle.bone + ", " + millimetres(muscle.bone_length) + " long; " +
                                       count_text(muscle.bulging) + " of them " +
                                       (muscle.bulging == 1 ? "bulges" : "bulge"));
  if (!rows.empty()) std::cout << "muscles\n" << columns_text(rows);

  rows.clear();
  for (const model::ProbeSet& probe : model.probes)
    rows.emplace_back(probe.name, counted_text(probe.vertices.size(), "vertex", "vertices"));
  if (!rows.empty()) std::cout << "probes\n" << columns_text(rows);

  rows.clear();
  const auto count = [&rows](const char* what, std::uint32_t number) {
    if (number > 0) rows.emplace_back(what, count_text(number));
  };
  count("flipped tetrahedra", report.flipped_tetrahedra);
  count("regions whose weights sum to zero (masses used instead)", report.region_fallbacks);
  count("vertices whose weights sum to zero (masses used instead)", report.vertex_fallbacks);
  count("regions without weights (skipped)", report.skipped_regions);
  if (report.fill.riders_outside > 0)
    rows.emplace_back("render vertices outside the body's tetrahedra",
                      count_text(report.fill.riders_outside) + ", least barycentric coordinate " +
                          number_text(report.fill.least_barycentric, 3));
  if (!rows.empty()) std::cout << "repaired\n" << columns_text(rows);

  if (!report.warnings.empty()) std::cout << "warnings\n";
  for (const build::Warning& warning : report.warnings)
    std::cout << "  " << shown_text(warning_text(warning)) << "\n";
}

ExitCode inspect(const InspectArguments& arguments, Log& log) {
  const scene::Scene scene = load(arguments.scene);
  refuse_unwritable("--model", arguments.model_file);
  const Built built = build(scene, log, arguments.scene.no_cache);
  if (!arguments.model_file.empty()) write_model_vtu(arguments.model_file, built.model);
  if (arguments.json) {
    Json object = inspect_json(scene, built);
    if (!arguments.model_file.empty()) object["model_file"] = arguments.model_file;
    std::cout << object.dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
    return ExitCode::done;
  }
  print_text(scene, built);
  if (!arguments.model_file.empty())
    std::cout << "wrote " << arguments.model_file << "  (ParaView: layer, alpha, beta, fibre, mass)\n";
  return ExitCode::done;
}

}  // namespace

void add_inspect(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand("inspect", "Print the contents of a scene, mesh or character");
  const auto arguments = std::make_shared<InspectArguments>();
  add_scene_options(*subcommand, arguments->scene, "Scene file, mesh, character or built-in name", true);
  subcommand
      ->add_option("--model", arguments->model_file,
                   "Write the tetrahedra with layer, alpha, beta, fibre and mass for ParaView (.vtu)")
      ->check(CLI::Validator(
          [](const std::string& text) {
            return text.ends_with(".vtu") ? std::string() : "\"" + text + "\" does not end in .vtu";
          },
          ""))
      ->option_text("FILE.vtu");
  subcommand->add_flag("--json", arguments->json, "Print one JSON object");
  add_log_options(*subcommand, command.log);
  subcommand->callback(
      [arguments, &command] { command.run = [arguments](Log& log) { return inspect(*arguments, log); }; });
}

}  // namespace fascicle::cli
