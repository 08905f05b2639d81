// Reference for tests/python/solver_test.py: the C++ wrapper steps the same poses and prints one hash per
// frame, then writes the last frame's surface in metres.
//   step_poses SCENE END FRAMES FILE
#include <cstddef>
#include <cstdint>
#include <exception>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include <fascicle/fascicle.hpp>

int main(int argc, char** argv) try {
  if (argc != 5) return 2;
  const fascicle::scene scene(argv[1], {.end = std::stod(argv[2])});
  const fascicle::model model(scene);
  fascicle::solver solver(model, fascicle::device("cpu"));
  const std::vector<double> rest = solver.clip_pose(0);
  solver.start_pose(rest);
  for (int frame = 1; frame <= std::stoi(argv[3]); ++frame) {
    std::vector<double> pose = rest;
    for (std::size_t j = 0; 16 * j < pose.size(); ++j) pose[16 * j + 7] += 0.002 * frame;
    solver.step_pose(pose);
    std::cout << solver.position_hash() << '\n';
  }
  const std::vector<float> surface = solver.surface();
  std::ofstream(argv[4], std::ios::binary)
      .write(reinterpret_cast<const char*>(surface.data()),
             static_cast<std::streamsize>(surface.size() * sizeof(float)));
  return 0;
} catch (const std::exception& error) {
  std::cerr << "error: " << error.what() << '\n';
  return 1;
}
