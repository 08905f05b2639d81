// How time runs and the motion is computed: [solver], [motion].
#include "host/scene/scene_keys.h"
#include "host/scene/scene_rows.h"

namespace fascicle::scene {
namespace {

const auto& solver_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&SolverSettings::integrator,
          {.name = "integrator",
           .doc = "Time stepping: explicit, equations (4) and (5), with stiffness as alpha; implicit, with "
                  "stiffness as youngs_modulus, frequency or material, the same at every fps and resolution. "
                  "Left "
                  "out, the one whose stiffness the layers state, explicit where they state none."},
          {.depends = true, .by_hand = true}),
      key(&SolverSettings::rotation,
          {.name = "rotation", .doc = "How the rotation of equation (9) is found."}),
      key(&SolverSettings::weights,
          {.name = "weights",
           .doc =
               "Equation (12) made symmetric in the fibre's sign and momentum-conserving, or as printed."}),
      key(&SolverSettings::substeps,
          {.name = "substeps",
           .doc =
               "Steps a frame; the stiffness that alpha means grows with their square. auto: as many as make "
               "it the same at every frame rate and spacing; with the implicit integrator, as many as "
               "quality "
               "and the layers' lowest modes need.",
           .range = between(1, 1000),
           .allowed = {"auto"}},
          {.by_hand = true}),
      member("auto_substeps", &SolverSettings::auto_substeps),
      key(&SolverSettings::iterations,
          {.name = "iterations",
           .doc =
               "Iterations an implicit substep. auto, or left out: as many as the layers' stiffness needs.",
           .range = between(1, 1000),
           .allowed = {"auto"}},
          {.by_hand = true}),
      key(&SolverSettings::quality,
          {.name = "quality",
           .doc =
               "Of the implicit integrator with substeps = \"auto\": how small the time step's errors shall "
               "be. draft: 240 substeps a second or more; normal: 480; final: 1440, with a sixth of "
               "the error or less."})};
  static_assert(base::has_row_for_each_member<SolverSettings, decltype(all)>,
                "a member of SolverSettings has no row here");
  return all;
}

const auto& motion_rows() {
  using namespace rows;
  static const std::tuple all{
      key(&Motion::rest,
          {.name = "rest",
           .doc =
               "sculpted: the rest shape hangs under gravity already, only its change in the bones' frames "
               "acts; weightless: all of it acts. Where absent, sculpted for a character, else weightless."},
          {.depends = true}),
      key(&Motion::interpolation,
          {.name = "interpolation",
           .doc =
               "smooth: linear keys closer than a tenth of a second are samples of a smooth motion, and a "
               "cubic runs through them; as-authored: straight lines. Where absent, smooth for a character "
               "from a file."},
          {.depends = true}),
      key(&Motion::preroll,
          {.name = "preroll",
           .doc =
               "Time before frame 0 in which the bind pose goes over into the first pose, s; where absent, "
               "0.5 for a character.",
           .range = between(0.0, 1e3)},
          {.depends = true}),
      key(&Motion::settle,
          {.name = "settle",
           .doc =
               "Time before frame 0, and after the preroll, in which the first pose is held until the flesh "
               "is slower than 1 mm/s (root mean square); at most this long, s.",
           .range = between(0.0, 1e3)}),
      key(&Motion::loop,
          {.name = "loop", .doc = "How often the clip is played.", .range = between(1, 100000)}),
      key(&Motion::seamless,
          {.name = "seamless",
           .doc = "Play the clip before frame 0 until a cycle ends as it began, then write one cycle."}),
      key(&Motion::seamless_tolerance,
          {.name = "seamless_tolerance",
           .doc = "Largest distance of a vertex between a cycle's end and its beginning, as a share of the "
                  "body's extent.",
           .range = positive(1.0)}),
      key(&Motion::seamless_cycles,
          {.name = "seamless_cycles", .doc = "Cycles before frame 0, at most.", .range = between(1, 10000)}),
      key(&Motion::hold, {.name = "hold",
                          .doc = "Time after the clip's end in which its last pose is held, s.",
                          .range = between(0.0, 1e5)}),
      key(&Motion::handles,
          {.name = "handles",
           .doc = "Frames that are simulated and written before scene.start and after the end; beyond the "
                  "clip its first and last pose are held.",
           .range = between(0, 100000)}),
      key(&Motion::acceleration_limit,
          {.name = "acceleration_limit",
           .doc = "Most of a joint's acceleration that its flesh feels, m/s^2; with the rest it is carried "
                  "along. Where absent, and keys are smooth, 200 times the body's extent.",
           .range = positive(1e9)}),
      key(&Motion::cuts,
          {.name = "cuts",
           .doc =
               "Times of the clip at which it jumps, s: the flesh is carried along and feels nothing of it.",
           .range = between(-1e5, 1e5)}),
      key(&Motion::cut_distance,
          {.name = "cut_distance",
           .doc = "A root that goes further than this in one frame has jumped, m; where absent, the body's "
                  "largest extent.",
           .range = positive(farthest)})};
  static_assert(base::has_row_for_each_member<Motion, decltype(all)>, "a member of Motion has no row here");
  return all;
}

}  // namespace

const Table& solver_table() {
  static const Table table =
      with_keys({.name = "solver", .doc = "How the motion is computed."}, solver_rows());
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
      {.name = "motion", .doc = "How time runs around the clip, and what gravity does to the rest shape."},
      motion_rows());
  return table;
}
void read_keys(const toml::table& table, Motion& motion) {
  read_rows(table, motion_rows(), motion);
}
Json json_of(const Motion& motion) {
  return json_of_rows(motion_rows(), motion);
}

}  // namespace fascicle::scene
