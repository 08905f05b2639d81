// Time stepping and motion: [solver], [motion].
#include "host/scene/scene_keys.h"
#include "host/scene/scene_rows.h"

namespace fascicle::scene {
namespace {

const auto& solver_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&SolverSettings::integrator,
          {.name = "integrator",
           .doc =
               "Time integration. explicit: equations (4) and (5), with stiffness as alpha; implicit: with "
               "stiffness as youngs_modulus, frequency or material, independent of fps and resolution. "
               "Default: the one whose stiffness the layers state, explicit if they state none."},
          {.depends = true, .by_hand = true}),
      key(&SolverSettings::rotation,
          {.name = "rotation", .doc = "Algorithm for the rotation of equation (9)."}),
      key(&SolverSettings::weights, {.name = "weights",
                                     .doc = "Form of equation (12): symmetric in the fibre's sign and "
                                            "momentum-conserving, or as in the paper."}),
      key(&SolverSettings::substeps,
          {.name = "substeps",
           .doc = "Substeps per frame; the stiffness that alpha stands for grows with their square. auto: as "
                  "many as keep it the same at every frame rate and vertex spacing, 4 to 256; with the "
                  "implicit integrator, as many as quality and the layers' lowest modes need.",
           .range = between(1, 1000),
           .allowed = {"auto"}},
          {.by_hand = true}),
      member("auto_substeps", &SolverSettings::auto_substeps),
      key(&SolverSettings::iterations,
          {.name = "iterations",
           .doc = "Iterations per implicit substep. auto, or absent: as many as the layers' stiffness needs.",
           .range = between(1, 1000),
           .allowed = {"auto"}},
          {.by_hand = true}),
      key(&SolverSettings::quality,
          {.name = "quality",
           .doc = "Accuracy of the implicit integrator with substeps = \"auto\". draft: at least 240 "
                  "substeps per second; normal: 480; final: 1440, with a seventh to two thirds of "
                  "normal's error, depending on the motion, but less viscosity: its substeps allow 0.7 ms."}),
      key(&SolverSettings::viscosity,
          {.name = "viscosity",
           .doc = "Viscosity of flesh over its stiffness, s, with the implicit integrator: motion at f Hz "
                  "decays by (2 pi f)^2 / 2 times this per second, so thin flesh does not buzz after an "
                  "impact and slow swings remain. At most the length of a substep acts. Default: 0.002 for "
                  "a character, else 0.",
           .range = between(0.0, 1.0)},
          {.depends = true}),
      member("has_stated_viscosity", &SolverSettings::has_stated_viscosity)};
  static_assert(base::has_row_for_each_member<SolverSettings, decltype(all)>,
                "a member of SolverSettings has no row here");
  return all;
}

const auto& motion_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&Motion::rest,
          {.name = "rest",
           .doc = "sculpted: the rest shape already sags under gravity, and only gravity's change in the "
                  "bones' frames acts; weightless: all of gravity acts. Default: sculpted for a character, "
                  "else weightless."},
          {.depends = true}),
      key(&Motion::interpolation,
          {.name = "interpolation",
           .doc = "smooth: linear keys closer than a tenth of a second are samples of a smooth motion, "
                  "interpolated by a cubic; as-authored: straight lines. Default: smooth for a character "
                  "from a file."},
          {.depends = true}),
      key(&Motion::preroll,
          {.name = "preroll",
           .doc = "Time before frame 0 in which the bind pose blends into the first pose, s. Default: 0.5 "
                  "for a character.",
           .range = between(0.0, 1e3)},
          {.depends = true}),
      key(&Motion::settle, {.name = "settle",
                            .doc = "Longest time between preroll and frame 0 for which the first pose is "
                                   "held until the flesh is slower than 1 mm/s (root mean square), s.",
                            .range = between(0.0, 1e3)}),
      key(&Motion::loop,
          {.name = "loop", .doc = "Number of times the clip is played.", .range = between(1, 100000)}),
      key(&Motion::seamless,
          {.name = "seamless",
           .doc = "Play the clip before frame 0 until a cycle ends as it began, then write one cycle."}),
      key(&Motion::seamless_tolerance, {.name = "seamless_tolerance",
                                        .doc = "Largest distance of a vertex between the end and the "
                                               "beginning of a cycle, as a share of the body's extent.",
                                        .range = positive(1.0)}),
      key(&Motion::seamless_cycles, {.name = "seamless_cycles",
                                     .doc = "Largest number of cycles before frame 0.",
                                     .range = between(1, 10000)}),
      key(&Motion::hold, {.name = "hold",
                          .doc = "Time for which the last pose is held after the clip's end, s.",
                          .range = between(0.0, 1e5)}),
      key(&Motion::handles, {.name = "handles",
                             .doc = "Frames simulated and written before scene.start and after the end; "
                                    "beyond the clip its first and last pose are held.",
                             .range = between(0, 100000)}),
      key(&Motion::acceleration_limit,
          {.name = "acceleration_limit",
           .doc = "Largest acceleration of a joint that its flesh feels, m/s^2; any excess carries the flesh "
                  "along. Default: 200/s^2 times the body's extent if keys are smooth, else none.",
           .range = positive(1e9)}),
      key(&Motion::cuts,
          {.name = "cuts",
           .doc = "Clip times at which the motion jumps, s; the flesh is carried along without reacting.",
           .range = between(-1e5, 1e5)}),
      key(&Motion::cut_distance,
          {.name = "cut_distance",
           .doc = "Movement of a root in one frame above which it counts as a jump, m. Default: the body's "
                  "largest extent; the movement must then also be more than four times the median of the "
                  "0.25 s before it, and of the 0.25 s after it.",
           .range = positive(farthest)})};
  static_assert(base::has_row_for_each_member<Motion, decltype(all)>, "a member of Motion has no row here");
  return all;
}

}  // namespace

const Table& solver_table() {
  static const Table table =
      with_keys({.name = "solver", .doc = "Time stepping and accuracy."}, solver_rows());
  return table;
}
void read_keys(const toml::table& table, SolverSettings& solver) {
  read_rows(table, solver_rows(), solver);
}
Json json_of(const SolverSettings& solver) {
  return json_of_rows(solver_rows(), solver);
}

const Table& motion_table() {
  static const Table table = with_keys(
      {.name = "motion", .doc = "Playback of the clip, and gravity in the rest shape."}, motion_rows());
  return table;
}
void read_keys(const toml::table& table, Motion& motion) {
  read_rows(table, motion_rows(), motion);
}
Json json_of(const Motion& motion) {
  return json_of_rows(motion_rows(), motion);
}

}  // namespace fascicle::scene
