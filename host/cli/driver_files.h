// Files that graphics drivers would write during a bake.
#pragma once

namespace fascicle::cli {

// Tells Mesa and NVIDIA's driver not to keep compiled shaders in the user's home; this program has its own
// cache (VkPipelineCache). Environment variables that are already set win. Call before starting any other
// thread.
void keep_drivers_from_writing();

}  // namespace fascicle::cli
