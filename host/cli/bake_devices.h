// The devices that the bakes of a batch run on, and how many bakes each takes at once.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/cli/many_bakes.h"

namespace fascicle::cli {

// The device of one bake.
struct BakeDevice {
  std::string label;
  unsigned threads = 0;      // per bake; 0: the bake's default
  std::uint64_t memory = 0;  // bytes of a GPU's own memory; 0: it uses the machine's
};

// Throws NoSuchDevice if a device of the list is missing: it would fail job after job, faster than the other
// devices bake them.
void require_devices(const std::string& list);

// One entry for each bake that can run at the same time. Interleaved, so that even a few jobs use all
// devices.
std::vector<BakeDevice> devices_at_once(const ManyBakes& asked);

}  // namespace fascicle::cli
