/* Models and solvers, for programs that step frames. Part of fascicle.h, which includes it. */
#ifndef FASCICLE_SOLVER_H
#define FASCICLE_SOLVER_H

#ifndef FASCICLE_FASCICLE_H
#error "include <fascicle/fascicle.h>"
#endif

/* ---- Models
 * ------------------------------------------------------------------------------------------------------ */

/* A body as flat arrays, shared by solvers. */
typedef struct fascicle_model fascicle_model;

typedef struct fascicle_build_options {
  size_t struct_size;
  const char*
      mesher; /* the program fascicle-mesher; NULL: found beside the library, in its prefix or on PATH */
  const char* cache; /* folder for filled bodies; "": none; NULL: the program's default */
  fascicle_log_function* log;
  void* log_user;
  fascicle_progress_function* progress; /* with FASCICLE_PHASE_BUILD; NULL: no progress reports */
  void* progress_user;
} fascicle_build_options;

FASCICLE_API void fascicle_build_options_init(fascicle_build_options* options, size_t struct_size);
static inline fascicle_build_options fascicle_build_options_default(void) {
  fascicle_build_options options;
  fascicle_build_options_init(&options, sizeof options);
  return options;
}

/* Level 2. Fills the body, cuts it into layers, grows fibres and chooses substeps. If it is cancelled, it
 * returns FASCICLE_CANCELLED and leaves no process or file behind. */
FASCICLE_API fascicle_status fascicle_model_build(const fascicle_scene* scene,
                                                  const fascicle_build_options* options,
                                                  fascicle_model** model);
FASCICLE_API void fascicle_model_destroy(fascicle_model* model);

/* 0 for a null model. The surface is the render mesh, in its own vertex order; 0 if the body has none. */
FASCICLE_API uint32_t fascicle_model_vertex_count(const fascicle_model* model);
FASCICLE_API uint32_t fascicle_model_tetrahedron_count(const fascicle_model* model);
FASCICLE_API uint32_t fascicle_model_surface_vertex_count(const fascicle_model* model);
FASCICLE_API uint32_t fascicle_model_joint_count(const fascicle_model* model);
/* Substeps per frame; 0 for a model from arrays, whose drives give it. */
FASCICLE_API uint32_t fascicle_model_substeps(const fascicle_model* model);

typedef enum fascicle_type {
  FASCICLE_FLOAT32 = 0,
  FASCICLE_FLOAT64 = 1,
  FASCICLE_UINT32 = 2,
  FASCICLE_UINT8 = 3,  /* booleans, 0 or 1 */
  FASCICLE_TEXT = 4,   /* count bytes: texts one after another, each terminated by 0 */
  FASCICLE_RECORDS = 5 /* structs of item_bytes each, defined in shaders/shared.h */
} fascicle_type;

typedef struct fascicle_array {
  const char* name; /* "rest", "ring_offset", "layer.damping", ...: the fields of host/model/model.h */
  fascicle_type type;
  size_t item_bytes;
  size_t count; /* of items */
  const void* data;
} fascicle_array;

/* The arrays of a model, in a fixed order: fascicle_model_array_at(model, 0), 1, ... until
 * FASCICLE_BAD_ARGUMENT; or one by name. The data belongs to the model. Probes are not included. */
FASCICLE_API fascicle_status fascicle_model_array_at(const fascicle_model* model, size_t index,
                                                     fascicle_array* array);
FASCICLE_API fascicle_status fascicle_model_array(const fascicle_model* model, const char* name,
                                                  fascicle_array* array);
/* Level 3. Makes a model from your own arrays, which are copied and checked: every size, index, range and
 * symmetry that host/model/model.h promises. Omitted arrays are empty. */
FASCICLE_API fascicle_status fascicle_model_create(const fascicle_array* arrays, size_t count,
                                                   fascicle_model** model);

/* ---- Solvers
 * ----------------------------------------------------------------------------------------------------- */

/* A body in motion. */
typedef struct fascicle_solver fascicle_solver;

typedef struct fascicle_solver_options {
  size_t struct_size;
  const char* rotation; /* "qcp" or "mueller2016"; NULL: as the scene says; "qcp" for a model from arrays */
  uint32_t iterations;  /* per implicit substep, 1 to 1000; 0: as many as the scene's own
                           substeps need (longer ones need more); 20 for a model from arrays */
  double viscosity; /* s, of an implicit model, at least 0: solver.viscosity of scene files; NaN: as the scene
                       says; 0 for a model from arrays */
} fascicle_solver_options;

FASCICLE_API void fascicle_solver_options_init(fascicle_solver_options* options, size_t struct_size);
static inline fascicle_solver_options fascicle_solver_options_default(void) {
  fascicle_solver_options options;
  fascicle_solver_options_init(&options, sizeof options);
  return options;
}

/* The solver starts at rest, before frame 0. `device`: NULL opens "auto" for this solver. */
FASCICLE_API fascicle_status fascicle_solver_create(const fascicle_model* model,
                                                    const fascicle_device* device,
                                                    const fascicle_solver_options* options,
                                                    fascicle_solver** solver);
FASCICLE_API void fascicle_solver_destroy(fascicle_solver* solver);
/* The device that it runs on, in one line for people, with the reason if "auto" chose it; NULL for a null
 * solver. */
FASCICLE_API const char* fascicle_solver_device_text(const fascicle_solver* solver);

/* The state of a solver after a failure: FASCICLE_BAD_ARGUMENT and FASCICLE_BAD_INPUT leave it as it was. A
 * start that is cancelled or fails in another way leaves it at rest, at frame 0, following neither a clip nor
 * poses. After any other failure its results are meaningless until it is started or loaded. */

/* Follow the scene's clip: start at frame 0, after preroll and settling, as in a bake; then step frame by
 * frame. After the scene's last frame the clip continues beyond `end` and stops only where its keys end; with
 * motion.loop, motion.hold or motion.seamless the pose at `end` is held. `progress` (may be NULL) is called
 * with FASCICLE_PHASE_LEAD_IN. */
FASCICLE_API fascicle_status fascicle_solver_start_clip(fascicle_solver* solver,
                                                        fascicle_progress_function* progress, void* user);
FASCICLE_API fascicle_status fascicle_solver_step_clip(fascicle_solver* solver);

/* Follow your own poses. A joint is 16 numbers, row by row: the affine map from the joint's own space to the
 * world, in the metres of the character's file, as glTF composes it from node transforms. glTF and many
 * engines store matrices column by column: transpose those. The last row is 0 0 0 1. A pose has joint_count
 * of them, in the order of fascicle_scene_joint_name. */
typedef struct fascicle_pose {
  size_t struct_size;
  const double* joints; /* pose_count x joint_count x 16; NULL without a skeleton */
  size_t pose_count;    /* 1: at the frame's end; or one for each substep. Between frames the joints' maps are
                           interpolated linearly: give one per substep if joints turn by more than about ten
                           degrees a frame */
  double time;          /* s, at the frame's end: when forces and contractions are read; NaN: 1/fps later */
  int jumps;            /* 1: a teleport: the flesh moves along without feeling it */
} fascicle_pose;

FASCICLE_API void fascicle_pose_init(fascicle_pose* pose, size_t struct_size);
static inline fascicle_pose fascicle_pose_default(void) {
  fascicle_pose pose;
  fascicle_pose_init(&pose, sizeof pose);
  return pose;
}

/* Starts at rest in a pose of joint_count x 16 numbers (NULL and 0 without a skeleton): frame 0, at the
 * scene's start time. */
FASCICLE_API fascicle_status fascicle_solver_start_pose(fascicle_solver* solver, const double* joints,
                                                        size_t count);
/* Steps a frame of 1/fps to the pose. */
FASCICLE_API fascicle_status fascicle_solver_step_pose(fascicle_solver* solver, const fascicle_pose* pose);
/* Gets the clip's own pose at the end of a frame, to modify and pass to step_pose: `count` is joint_count
 * x 16. */
FASCICLE_API fascicle_status fascicle_solver_clip_pose(fascicle_solver* solver, uint64_t frame,
                                                       double* joints, size_t count);

/* Level 3: the input of a solver for one frame. Working units; arrays hold substeps x the model's count. */
typedef struct fascicle_drive {
  size_t struct_size;
  uint32_t substeps;     /* 1 to 1000 */
  double h;              /* s, of a substep */
  double origin[3];      /* m: the origin of this frame's positions */
  float origin_shift[3]; /* origin less the last frame's, working units */
  float gravity[3];      /* working units / s^2 */
  const float* bones;    /* 16 per bone: a 3 x 4 map row by row, its change of gravity, 0 */
  size_t bone_count;
  const float* muscles; /* 5 per muscle: tau, swell, twist */
  size_t muscle_count;
  const float* forces; /* 4 per force: the vector, 0 */
  size_t force_count;
  const float* decay; /* exp(-damping h), one per layer */
  size_t decay_count;
  const float* colliders; /* 32 per solid: two 3 x 4 maps from the body's space to its own, at the
                          substep's end and at its beginning; half its size (3), radius, friction, share of
                          a depth that is lifted, 1 for a half space or 0, 0 */
  size_t collider_count;
} fascicle_drive;

FASCICLE_API void fascicle_drive_init(fascicle_drive* drive, size_t struct_size);
static inline fascicle_drive fascicle_drive_default(void) {
  fascicle_drive drive;
  fascicle_drive_init(&drive, sizeof drive);
  return drive;
}
FASCICLE_API fascicle_status fascicle_solver_step_drive(fascicle_solver* solver, const fascicle_drive* drive);

/* The solver's current frame. Arrays belong to the solver and are valid until it is next started, stepped or
 * loaded. A place in the world is origin + unit x position. */
typedef struct fascicle_frame {
  uint64_t index;
  double unit;      /* metres per working unit */
  double origin[3]; /* m */
  size_t vertex_count, surface_vertex_count;
  const float* positions;  /* 3 per vertex of the model, working units */
  const float* velocities; /* 3 per vertex, working units / s */
  /* 3 per vertex of the surface, in the file's order; NULL without one. Its triangles are the model's array
   * "surface_triangle", 3 indices each. */
  const float* surface;
} fascicle_frame;

FASCICLE_API fascicle_status fascicle_solver_frame(const fascicle_solver* solver, fascicle_frame* frame);
/* The same in metres in the world: `count` is three times the number of vertices. */
FASCICLE_API fascicle_status fascicle_solver_positions(const fascicle_solver* solver, float* metres,
                                                       size_t count);
FASCICLE_API fascicle_status fascicle_solver_surface(const fascicle_solver* solver, float* metres,
                                                     size_t count);
/* Two frames with the same hash have the same bits. `text`: 17 bytes, 16 hex digits and a 0, as the program
 * prints it. */
FASCICLE_API fascicle_status fascicle_solver_position_hash(const fascicle_solver* solver, char text[17]);

/* The solver's whole history as bytes. After load a solver of the same model continues with the same bits, on
 * any exact device. `capacity` is the space at `bytes`; `size` receives the number of bytes needed. With
 * `bytes` NULL, save only sets `size`. */
FASCICLE_API fascicle_status fascicle_solver_save(const fascicle_solver* solver, void* bytes, size_t capacity,
                                                  size_t* size);
FASCICLE_API fascicle_status fascicle_solver_load(fascicle_solver* solver, const void* bytes, size_t size);

#endif /* FASCICLE_SOLVER_H */
