/* fascicle: bakes how muscle and fat of animated characters stretch, lag and jiggle, with the same bits on
 * any GPU and on the CPU.
 *
 * Ten lines that bake a character into the folder `out`:
 *
 *   fascicle_scene* scene = NULL;
 *   fascicle_bake_options options = fascicle_bake_options_default();
 *   const char* formats[] = {"glb", "pc2"};
 *   options.folder = "out";
 *   options.formats = formats;
 *   options.format_count = 2;
 *   if (fascicle_scene_load("man.glb", NULL, &scene) != FASCICLE_OK ||
 *       fascicle_bake_run(scene, &options, NULL) != FASCICLE_OK)
 *     fprintf(stderr, "%s\n", fascicle_last_message());
 *   fascicle_scene_destroy(scene);
 *
 * There are three levels: bake a scene (fascicle_bake_run); build a model and step its frames by a clip or by
 * your own poses (fascicle_model_build, fascicle_solver_*); or use only the solver, on your own flat arrays
 * (fascicle_model_create, fascicle_solver_step_drive). docs/library.md has a program for each.
 *
 * These conventions hold for every function below:
 *
 *   Units      Metres, kilograms, seconds, radians; right-handed, Y up. A solver's own arrays are
 *              in working units: fascicle_frame says how many metres one is.
 *
 *   Errors     Functions that can fail return a status. On failure outputs are untouched, handles are
 *              set to NULL, and fascicle_last_message() says what failed, where, and what to do.
 *              Nothing is ever thrown.
 *
 *   Ownership  The caller owns what a function creates and frees it with the matching _destroy, in any
 *              order: a solver keeps what it needs of its model. _destroy accepts NULL. Arguments are
 *              read during the call and not kept. A returned pointer belongs to the handle that
 *              returned it.
 *
 *   Threads    Handles may be used on any thread. Scenes, models and finished bakes do not change, and
 *              many threads may use them at once. A solver may be used by one thread at a time, and so
 *              may a device while solvers are created on it. Functions return when their work is done;
 *              callbacks run on the calling thread, during the call. Meshing and converting run child
 *              processes: leave SIGCHLD at its default, and do not wait for all children, as wait() and
 *              waitpid(-1) do.
 *
 *   Options    Create them with their _default(). It sets struct_size, so that a program keeps working
 *              with a library that has more options. NULL means the defaults.
 *
 *   Text       UTF-8, terminated by 0.
 */
#ifndef FASCICLE_FASCICLE_H
#define FASCICLE_FASCICLE_H

#include <stddef.h>
#include <stdint.h>

#include "export.h"
#include "version.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Errors
 * ------------------------------------------------------------------------------------------------------ */

/* The values are the program's exit statuses. */
typedef enum fascicle_status {
  FASCICLE_OK = 0,
  FASCICLE_FAILED = 1, /* disk full, out of memory */
  FASCICLE_BAD_ARGUMENT =
      2, /* a null handle, a wrong size, an unknown name, a folder that already holds a bake */
  FASCICLE_BAD_INPUT = 3,      /* a scene, mesh, character or state that cannot be used */
  FASCICLE_NO_SUCH_DEVICE = 4, /* or one that cannot run this model */
  FASCICLE_NOT_FINITE = 5,     /* the simulation produced infinities or NaN */
  FASCICLE_DEVICE_FAILED = 7,  /* or was lost during the work, and no other was named */
  FASCICLE_CANCELLED = 75      /* by a progress callback */
} fascicle_status;

/* "bad input"; "unknown status" for other numbers. Never NULL. */
FASCICLE_API const char* fascicle_status_text(fascicle_status status);

/* The message of the last call on this thread that did not return FASCICLE_OK; "" before there was one.
 * Never NULL; valid until the next such call on this thread. */
FASCICLE_API const char* fascicle_last_message(void);

/* "0.1.0": the version of the library; FASCICLE_VERSION_STRING is that of the headers. */
FASCICLE_API const char* fascicle_version(void);

/* Raised whenever the same scene gives different bits: compare results only within one version. */
FASCICLE_API uint32_t fascicle_solver_version(void);

/* ---- Callbacks
 * --------------------------------------------------------------------------------------------------- */

typedef enum fascicle_severity {
  FASCICLE_DETAIL = 0,
  FASCICLE_INFO = 1,
  FASCICLE_WARNING = 2
} fascicle_severity;

/* `message` is valid during the call. */
typedef void fascicle_log_function(void* user, fascicle_severity severity, const char* message);

typedef enum fascicle_phase {
  FASCICLE_PHASE_BUILD = 0,   /* before the build and repeatedly during it; done and total are 0 */
  FASCICLE_PHASE_LEAD_IN = 1, /* before each frame of the lead-in to frame 0; total is 0 */
  FASCICLE_PHASE_FRAMES = 2   /* after each frame: done of total */
} fascicle_phase;

/* Returns 0 to continue. Anything else cancels: the call returns FASCICLE_CANCELLED when the current build
 * step or the frames in flight are done. A running mesher is terminated at once. */
typedef int fascicle_progress_function(void* user, fascicle_phase phase, uint64_t done, uint64_t total);

/* ---- Scenes
 * ------------------------------------------------------------------------------------------------------ */

/* An artist's scene, read and checked, with its meshes loaded. */
typedef struct fascicle_scene fascicle_scene;

typedef struct fascicle_scene_options {
  size_t struct_size;
  const char* const* set; /* set_count changes of scene keys, such as "layers.fat.alpha=0.2" */
  size_t set_count;
  const char* clip;  /* the character's clip, by name, by the last part of its name or by number; NULL: as the
                        scene says, or the first */
  double fps;        /* frames per second; NaN, here and below: as the scene says */
  double start, end; /* of the clip, s */
  double softness;   /* softness of all flesh, as a factor */
  double exaggerate; /* lag of flesh, as a factor */
  const char* converter; /* the program fascicle-convert, also when the scene is baked; NULL: found beside the
                            library, in its prefix or on PATH */
} fascicle_scene_options;

FASCICLE_API void fascicle_scene_options_init(fascicle_scene_options* options, size_t struct_size);
static inline fascicle_scene_options fascicle_scene_options_default(void) {
  fascicle_scene_options options;
  fascicle_scene_options_init(&options, sizeof options);
  return options;
}

/* `name`: a scene file (.toml), a mesh (.mesh .node .ele .msh .vtu .off .obj .ply .stl), a character (.glb
 * .gltf .vrm, and .fbx .dae where fascicle-convert is installed or given) or a built-in scene. */
FASCICLE_API fascicle_status fascicle_scene_load(const char* name, const fascicle_scene_options* options,
                                                 fascicle_scene** scene);
/* The same from a scene file's text. `folder`: the folder that its file names are relative to; NULL: the
 * working directory. */
FASCICLE_API fascicle_status fascicle_scene_parse(const char* text, const char* folder,
                                                  const fascicle_scene_options* options,
                                                  fascicle_scene** scene);
FASCICLE_API void fascicle_scene_destroy(fascicle_scene* scene);

/* For a null scene these return NULL and 0. */
FASCICLE_API const char* fascicle_scene_name(const fascicle_scene* scene);
FASCICLE_API double fascicle_scene_fps(const fascicle_scene* scene);
/* Frames after frame 0. */
FASCICLE_API uint64_t fascicle_scene_frame_count(const fascicle_scene* scene);
/* Joints of a character; parents come before their children, and a root's parent is -1. Past the end: NULL
 * and -1. */
FASCICLE_API size_t fascicle_scene_joint_count(const fascicle_scene* scene);
FASCICLE_API const char* fascicle_scene_joint_name(const fascicle_scene* scene, size_t joint);
FASCICLE_API int32_t fascicle_scene_joint_parent(const fascicle_scene* scene, size_t joint);
FASCICLE_API size_t fascicle_scene_clip_count(const fascicle_scene* scene);
FASCICLE_API const char* fascicle_scene_clip_name(const fascicle_scene* scene, size_t clip);

/* The built-in scenes; past the end: NULL. Valid as long as the library is loaded. */
FASCICLE_API const char* fascicle_builtin_scene_name(size_t index);

/* ---- Level 1: bake
 * ----------------------------------------------------------------------------------------------- */

/* The result of a bake. */
typedef struct fascicle_bake fascicle_bake;

typedef struct fascicle_bake_options {
  size_t struct_size;
  const char* folder;         /* the output folder; required */
  const char* const* formats; /* format_count names from fascicle_format_name, written in addition to frame
                                 cache, manifest and metrics; "none" alone: none, on purpose */
  size_t format_count;
  /* See fascicle_device_open; NULL: "auto". Several may be given, separated by commas: if one fails, the next
   * continues with the same bits. "all": every real GPU, then the CPU. */
  const char* device;
  uint32_t threads; /* of the CPU solver, at most 1024; 0: one for each core */
  const char*
      mesher; /* the program fascicle-mesher; NULL: found beside the library, in its prefix or on PATH */
  const char* cache;   /* folder for filled bodies, starts and compiled shaders; "": none; NULL: the program's
                          default */
  int overwrite;       /* 1: replace the bake in the folder */
  int resume;          /* 1: continue the bake in the folder, to the same bytes */
  int usd_skel;        /* 1: usda also holds the character by skinning alone */
  int64_t first_frame; /* number of the first frame in the files for other programs; -1: they begin at 0 */
  uint64_t glb_stride; /* glb: one morph target per this many frames */
  double glb_error;    /* glb: as few targets as keep a viewer within this error, m; NaN: use the stride */
  double glb_tolerance; /* glb: vertices nearer than this to skinning are only skinned, m; NaN: almost none */
  double glb_compress;  /* glb: quantise with at most this error, m, and compress; NaN: do not */
  fascicle_log_function* log; /* NULL: no messages */
  void* log_user;
  fascicle_progress_function* progress; /* NULL: no progress reports */
  void* progress_user;
  int keep_frames; /* 0: delete the frame cache once the formats are complete; needs a format, or "none" */
} fascicle_bake_options;

FASCICLE_API void fascicle_bake_options_init(fascicle_bake_options* options, size_t struct_size);
static inline fascicle_bake_options fascicle_bake_options_default(void) {
  fascicle_bake_options options;
  fascicle_bake_options_init(&options, sizeof options);
  return options;
}

/* Builds, simulates and writes a scene, as `fascicle bake` does, with the same bytes. If it is cancelled, it
 * returns FASCICLE_CANCELLED and still creates `bake` (which may be NULL); options.resume continues it. If it
 * is cancelled before the model is built, `bake` is set to NULL and nothing is written. */
FASCICLE_API fascicle_status fascicle_bake_run(const fascicle_scene* scene,
                                               const fascicle_bake_options* options, fascicle_bake** bake);
FASCICLE_API void fascicle_bake_destroy(fascicle_bake* bake);

/* Frames done after frame 0. For a null bake, here and below: 0, NULL and NaN. */
FASCICLE_API uint64_t fascicle_bake_frames(const fascicle_bake* bake);
/* The hash of the last frame, 16 hex digits, as the program prints it. */
FASCICLE_API const char* fascicle_bake_position_hash(const fascicle_bake* bake);
/* The files that were written; past the end: NULL. */
FASCICLE_API size_t fascicle_bake_file_count(const fascicle_bake* bake);
FASCICLE_API const char* fascicle_bake_file(const fascicle_bake* bake, size_t index);
/* The worst look score; 1 is the limit. NaN if it was not measured. */
FASCICLE_API double fascicle_bake_look(const fascicle_bake* bake);

/* "glb", "pc2", ...; past the end: NULL. Valid as long as the library is loaded. */
FASCICLE_API const char* fascicle_format_name(size_t index);

/* ---- Devices
 * ----------------------------------------------------------------------------------------------------- */

/* A GPU or the CPU, ready to run solvers. */
typedef struct fascicle_device fascicle_device;

typedef struct fascicle_device_options {
  size_t struct_size;
  uint32_t threads;  /* of the CPU solver, at most 1024; 0: one for each core */
  const char* cache; /* folder for compiled shaders; "": none; NULL: the program's default */
  fascicle_log_function* log;
  void* log_user;
} fascicle_device_options;

FASCICLE_API void fascicle_device_options_init(fascicle_device_options* options, size_t struct_size);
static inline fascicle_device_options fascicle_device_options_default(void) {
  fascicle_device_options options;
  fascicle_device_options_init(&options, sizeof options);
  return options;
}

/* `name`: "auto" or NULL (the best real GPU that passes its self-test, else the CPU), "cpu", "cpu:LEVEL"
 * (scalar, baseline, sse4, avx2, avx512), "vulkan" or "vulkan:N". */
FASCICLE_API fascicle_status fascicle_device_open(const char* name, const fascicle_device_options* options,
                                                  fascicle_device** device);
FASCICLE_API void fascicle_device_destroy(fascicle_device* device);
/* One line for people; NULL for a null device. */
FASCICLE_API const char* fascicle_device_text(const fascicle_device* device);
/* 1 if it gives the same bits as every other exact device, else 0. */
FASCICLE_API int fascicle_device_is_exact(const fascicle_device* device);

#include "solver.h"

#ifdef __cplusplus
}
#endif

#endif /* FASCICLE_FASCICLE_H */
