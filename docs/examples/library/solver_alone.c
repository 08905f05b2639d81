/* Level 3: the solver on flat arrays. Here they are taken from a model that was built, as a program of your
 * own would take them from its own data, and a bar that is held at a wall sags for a tenth of a second.
 *   solver_alone */
#include <fascicle/fascicle.h>
#include <stdio.h>
#include <stdlib.h>

static const char* text =
    "[bar]\nsize = [0.4, 0.1, 0.1]\nvertices = [5, 3, 3]\n"
    "[layers.flesh]\nalpha = 0.5\n"
    "[pin.wall]\nwhere = { below = { axis = \"x\", fraction = 0.0 } }\n";

static void must(fascicle_status status) {
  if (status == FASCICLE_OK) return;
  fprintf(stderr, "error: %s\n", fascicle_last_message());
  exit((int)status);
}

int main(void) {
  fascicle_scene* scene = NULL;
  fascicle_model *built = NULL, *model = NULL;
  fascicle_device* device = NULL;
  fascicle_solver* solver = NULL;
  must(fascicle_scene_parse(text, NULL, NULL, &scene));
  must(fascicle_model_build(scene, NULL, &built));

  fascicle_array arrays[64];
  size_t count = 0;
  while (count < 64 && fascicle_model_array_at(built, count, &arrays[count]) == FASCICLE_OK) ++count;
  must(fascicle_model_create(arrays, count, &model));
  fascicle_model_destroy(built);
  fascicle_scene_destroy(scene);

  must(fascicle_device_open("cpu", NULL, &device));
  must(fascicle_solver_create(model, device, NULL, &solver));
  fascicle_frame frame;
  must(fascicle_solver_frame(solver, &frame));
  const float decay[] = {1.0F};
  fascicle_drive drive = fascicle_drive_default();
  drive.h = 1.0 / 60.0;
  drive.decay = decay;
  drive.decay_count = 1;
  for (int a = 0; a < 3; ++a) drive.origin[a] = frame.origin[a];
  drive.gravity[1] = (float)(-9.81 / frame.unit);
  for (int k = 0; k < 6; ++k) must(fascicle_solver_step_drive(solver, &drive));

  must(fascicle_solver_frame(solver, &frame));
  float least = 0.0F;
  for (size_t i = 0; i < frame.vertex_count; ++i)
    if (frame.positions[3 * i + 1] < least) least = frame.positions[3 * i + 1];
  printf("lowest point after %u frames: %.4f m\n", (unsigned)frame.index,
         frame.origin[1] + frame.unit * (double)least);
  fascicle_solver_destroy(solver);
  fascicle_device_destroy(device);
  fascicle_model_destroy(model);
  return 0;
}
