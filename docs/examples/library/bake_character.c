/* Level 1: bakes a scene, a mesh or a character into a folder.
 *   bake_character SCENE FOLDER [KEY=VALUE...] */
#include <fascicle/fascicle.h>
#include <stdio.h>

static void on_log(void* user, fascicle_severity severity, const char* message) {
  (void)user;
  if (severity == FASCICLE_WARNING) fprintf(stderr, "warning: %s\n", message);
}

static int on_progress(void* user, fascicle_phase phase, uint64_t done, uint64_t total) {
  (void)user;
  if (phase == FASCICLE_PHASE_FRAMES) fprintf(stderr, "frame %u of %u\n", (unsigned)done, (unsigned)total);
  return 0; /* anything else cancels */
}

int main(int argc, char** argv) {
  if (argc < 3) return fprintf(stderr, "usage: bake_character SCENE FOLDER [KEY=VALUE...]\n"), 2;
  fascicle_scene* scene = NULL;
  fascicle_bake* bake = NULL;
  fascicle_scene_options scene_options = fascicle_scene_options_default();
  scene_options.set = (const char* const*)(argv + 3);
  scene_options.set_count = (size_t)(argc - 3);
  fascicle_bake_options options = fascicle_bake_options_default();
  const char* formats[] = {"pc2"};
  options.folder = argv[2];
  options.formats = formats;
  options.format_count = 1;
  options.log = on_log;
  options.progress = on_progress;
  fascicle_status status = fascicle_scene_load(argv[1], &scene_options, &scene);
  if (status == FASCICLE_OK) status = fascicle_bake_run(scene, &options, &bake);
  if (status == FASCICLE_OK)
    printf("%s\n", fascicle_bake_position_hash(bake));
  else
    fprintf(stderr, "error: %s\n", fascicle_last_message());
  fascicle_bake_destroy(bake);
  fascicle_scene_destroy(scene);
  return (int)status;
}
