// Level 2: builds a model and steps its frames, first by the scene's clip, then by poses made here.
//   step_frames SCENE [KEY=VALUE...]
#include <algorithm>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include <fascicle/fascicle.hpp>

namespace {

// Every joint of the pose lifted by `height` metres: the body jumps as a whole.
std::vector<double> lifted(std::vector<double> joints, double height) {
  for (std::size_t j = 0; 16 * j < joints.size(); ++j) joints[16 * j + 7] += height;
  return joints;
}

float highest(const std::vector<float>& points) {
  float top = -1e30F;
  for (std::size_t k = 1; k < points.size(); k += 3) top = std::max(top, points[k]);
  return top;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) throw std::invalid_argument("usage: step_frames SCENE [KEY=VALUE...]");
  const fascicle::scene scene(argv[1], {.set = std::vector<std::string>(argv + 2, argv + argc)});
  const fascicle::model model(scene);
  fascicle::solver solver(model);

  // As a bake does, with the same bits.
  solver.start_clip();
  for (std::uint64_t frame = 1; frame <= scene.frame_count(); ++frame) solver.step_clip();
  std::cout << solver.position_hash() << '\n';

  // By poses: the clip's first, then lifted by two millimetres a frame.
  const std::vector<double> pose = solver.clip_pose(0);
  solver.start_pose(pose);
  const float before = highest(solver.positions());
  for (int frame = 1; frame <= 5; ++frame) solver.step_pose(lifted(pose, 0.002 * frame));
  std::cout << "highest point: " << before << " m, then " << highest(solver.positions()) << " m\n";

  // What was saved goes on with the same bits.
  const std::vector<std::byte> state = solver.save();
  solver.step_pose(pose);
  const std::string hash = solver.position_hash();
  solver.load(state);
  solver.step_pose(pose);
  return hash == solver.position_hash() ? 0 : 1;
} catch (const fascicle::error& error) {
  std::cerr << "error: " << error.what() << '\n';
  return error.status();
} catch (const std::exception& error) {
  std::cerr << "error: " << error.what() << '\n';
  return FASCICLE_BAD_ARGUMENT;
}
