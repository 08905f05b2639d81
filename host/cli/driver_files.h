// What graphics drivers would write beside a bake.
#pragma once

namespace fascicle::cli {

// Drivers keep shaders that they have compiled in the user's home. This program keeps them in its own cache
// (VkPipelineCache), so that Mesa and NVIDIA's driver are told to keep none. What the environment says
// already stays. Before any other thread starts.
void keep_drivers_from_writing();

}  // namespace fascicle::cli
