// Velocities of what a file shows: the derivative of the positions that are written.
#pragma once

#include <span>
#include <vector>

namespace fascicle::formats {

// Half the difference of the frames before and after, over a frame's time; at the first and the last frame
// the difference to their only neighbour. A frame's velocities are known when the next frame is: units of the
// positions a second. Frame by frame; holds two of them.
class SurfaceVelocities {
 public:
  explicit SurfaceVelocities(double fps) : fps_(fps) {}
  // Takes the next frame; the velocities of the one before it. Nothing at the first.
  std::vector<float> next(std::vector<float> positions);
  // Those of the last frame; of a single one 0.
  std::vector<float> last() const;

 private:
  double fps_;
  std::vector<float> before_, now_;
};

}  // namespace fascicle::formats
