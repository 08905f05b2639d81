// Velocities: the derivative of the written positions.
#pragma once

#include <span>
#include <vector>

namespace fascicle::formats {

// Central differences; one-sided at the first and the last frame. Units of the positions per second. A
// frame's velocities are known when the next frame is. Takes frames one by one and keeps two.
class SurfaceVelocities {
 public:
  explicit SurfaceVelocities(double fps) : fps_(fps) {}
  // Takes the next frame; returns the velocities of the previous one, or nothing for the first frame.
  std::vector<float> next(std::vector<float> positions);
  // The last frame's velocities; 0 if there is only one frame.
  std::vector<float> last() const;

 private:
  double fps_;
  std::vector<float> before_, now_;
};

}  // namespace fascicle::formats
