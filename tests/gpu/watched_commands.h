// Intercepts a solver's Vulkan calls: each barrier with the commands before and after it, and the hazards
// that appear if one barrier is not forwarded. It uses the tables of host/model/stages.h and checks what the
// validation layer (1.3.239) does not:
//   reads by the host need a barrier to the host in addition to the fence;
//   work waited for by a fence is complete, but not yet visible to later submissions;
//   a shader that may write a buffer may also read it, and two that write it may write the same place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <volk.h>

namespace fascicle::tests {

// One barrier within its command buffer: what was recorded since the previous one, and until the next one.
struct WatchedBarrier {
  std::string after, before;
  bool is_to_host = false;
  std::string label() const { return after + " | " + before; }
};

class WatchedCommands {
 public:
  // Watches devices that are opened during its lifetime; only one instance at a time. Vulkan must be loaded.
  WatchedCommands();
  ~WatchedCommands();
  WatchedCommands(const WatchedCommands&) = delete;
  WatchedCommands& operator=(const WatchedCommands&) = delete;

  // The next pipelines created are the solver's, in the order of the schedule's kernels.
  void expect_solver() { pipelines_made_ = 0; }

  // Starts counting barriers; the one with this number is not forwarded.
  void start(std::optional<std::size_t> left_out = std::nullopt);
  const std::vector<WatchedBarrier>& barriers() const { return barriers_; }
  // Since start(): accesses that do not wait for conflicting ones.
  const std::vector<std::string>& hazards() const { return hazards_; }
  // The names of the schedule's kernels that were dispatched.
  const std::set<std::string>& dispatched() const { return dispatched_; }

 private:
  struct Use {
    std::optional<std::string> written;  // by which kernel or copy, since the last barrier
    std::set<std::string> read;          // since the last barrier and since the host last waited
    std::optional<std::string> to_host;  // copied to the host since the last barrier to the host
  };
  struct Calls {
    PFN_vkGetDeviceProcAddr of_device = nullptr;
    PFN_vkBeginCommandBuffer begin = nullptr;
    PFN_vkEndCommandBuffer end = nullptr;
    PFN_vkCreateComputePipelines create_pipelines = nullptr;
    PFN_vkCreateBuffer create_buffer = nullptr;
    PFN_vkUpdateDescriptorSets update_sets = nullptr;
    PFN_vkCmdPipelineBarrier barrier = nullptr;
    PFN_vkCmdCopyBuffer copy = nullptr;
    PFN_vkCmdBindPipeline bind_pipeline = nullptr;
    PFN_vkCmdBindDescriptorSets bind_sets = nullptr;
    PFN_vkCmdDispatch dispatch = nullptr;
    PFN_vkQueueSubmit submit = nullptr;
    PFN_vkWaitForFences wait = nullptr;
  };
  // Vulkan's calls take no context of ours.
  static WatchedCommands*& watching();
  struct Entries;

  void did(const std::string& name);
  void reads(VkBuffer buffer, const std::string& by);
  void writes(VkBuffer buffer, const std::string& by);
  void on_dispatch();

  Calls calls_;
  std::optional<std::size_t> left_out_;
  std::vector<WatchedBarrier> barriers_;
  std::vector<std::string> hazards_;
  std::set<std::string> dispatched_;

  std::string since_barrier_;
  bool is_after_barrier_ = false, is_under_way_ = false;
  std::map<VkBuffer, Use> uses_;
  std::set<VkBuffer> of_host_;  // read by the host
  std::map<VkDescriptorSet, std::map<std::uint32_t, VkBuffer>> sets_;
  std::map<VkPipeline, std::uint32_t> kernels_;
  std::uint32_t pipelines_made_ = 0;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace fascicle::tests
