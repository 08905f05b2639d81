// What a solver asks of Vulkan, seen on its way: each barrier between what it parts, and the hazards that are
// left if one of them is not passed on. It goes by the tables of host/model/stages.h, and knows what the
// validation layer (1.3.239) does not look at:
//   the host reads, which takes a barrier to the host beside the fence;
//   what a fence has been waited for is done, but not yet seen by later submissions;
//   a shader that may write a buffer may read it too, and two that write it may write the same place.
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

// Of one barrier, within its command buffer: what was recorded since the one before, and until the next.
struct WatchedBarrier {
  std::string after, before;
  bool is_to_host = false;
  std::string label() const { return after + " | " + before; }
};

class WatchedCommands {
 public:
  // Devices that are opened while this lives are watched; there is one at a time. Vulkan must be loaded.
  WatchedCommands();
  ~WatchedCommands();
  WatchedCommands(const WatchedCommands&) = delete;
  WatchedCommands& operator=(const WatchedCommands&) = delete;

  // The solver's pipelines are the next ones made, in the order of the schedule's kernels.
  void expect_solver() { pipelines_made_ = 0; }

  // Barriers are counted from here on; the one of this number is not passed on.
  void start(std::optional<std::size_t> left_out = std::nullopt);
  const std::vector<WatchedBarrier>& barriers() const { return barriers_; }
  // Since start(): accesses that do not wait for those that they conflict with.
  const std::vector<std::string>& hazards() const { return hazards_; }
  // The schedule's kernels that were dispatched, by name.
  const std::set<std::string>& dispatched() const { return dispatched_; }

 private:
  struct Use {
    std::optional<std::string> written;  // since the last barrier, by what
    std::set<std::string> read;          // the same, and since the host last waited
    std::optional<std::string> to_host;  // copied to the host since the last barrier to it
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
  std::set<VkBuffer> of_host_;  // which the host reads
  std::map<VkDescriptorSet, std::map<std::uint32_t, VkBuffer>> sets_;
  std::map<VkPipeline, std::uint32_t> kernels_;
  std::uint32_t pipelines_made_ = 0;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace fascicle::tests
