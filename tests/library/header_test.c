/* fascicle.h as C11, with every option at its default. */
#include "include/fascicle/fascicle.h"

size_t fascicle_test_sizes(void);

size_t fascicle_test_sizes(void) {
  const fascicle_scene_options scene = fascicle_scene_options_default();
  const fascicle_bake_options bake = fascicle_bake_options_default();
  const fascicle_device_options device = fascicle_device_options_default();
  const fascicle_build_options build = fascicle_build_options_default();
  const fascicle_solver_options solver = fascicle_solver_options_default();
  const fascicle_pose pose = fascicle_pose_default();
  const fascicle_drive drive = fascicle_drive_default();
  return scene.struct_size + bake.struct_size + device.struct_size + build.struct_size + solver.struct_size +
         pose.struct_size + drive.struct_size;
}
