#include "tests/gpu/watched_commands.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "host/model/stages.h"

namespace fascicle::tests {

WatchedCommands*& WatchedCommands::watching() {
  static WatchedCommands* one = nullptr;
  return one;
}

// Replacements for Vulkan's functions.
struct WatchedCommands::Entries {
  static WatchedCommands& self() { return *watching(); }

  static VKAPI_ATTR VkResult VKAPI_CALL begin(VkCommandBuffer commands,
                                              const VkCommandBufferBeginInfo* info) {
    self().since_barrier_ = self().is_under_way_ ? "start beside others" : "start";
    self().is_after_barrier_ = false;
    return self().calls_.begin(commands, info);
  }
  static VKAPI_ATTR VkResult VKAPI_CALL end(VkCommandBuffer commands) {
    self().is_after_barrier_ = false;
    return self().calls_.end(commands);
  }
  static VKAPI_ATTR VkResult VKAPI_CALL create_pipelines(VkDevice device, VkPipelineCache cache,
                                                         std::uint32_t count,
                                                         const VkComputePipelineCreateInfo* infos,
                                                         const VkAllocationCallbacks* allocation,
                                                         VkPipeline* pipelines) {
    const VkResult made = self().calls_.create_pipelines(device, cache, count, infos, allocation, pipelines);
    for (std::uint32_t k = 0; k < count; ++k) self().kernels_[pipelines[k]] = self().pipelines_made_++;
    return made;
  }
  static VKAPI_ATTR VkResult VKAPI_CALL create_buffer(VkDevice device, const VkBufferCreateInfo* info,
                                                      const VkAllocationCallbacks* allocation,
                                                      VkBuffer* buffer) {
    const VkResult made = self().calls_.create_buffer(device, info, allocation, buffer);
    // A handle may be reused after its buffer was destroyed.
    self().uses_.erase(*buffer);
    self().of_host_.erase(*buffer);
    if (info->usage == VK_BUFFER_USAGE_TRANSFER_DST_BIT) self().of_host_.insert(*buffer);
    return made;
  }
  static VKAPI_ATTR void VKAPI_CALL update_sets(VkDevice device, std::uint32_t count,
                                                const VkWriteDescriptorSet* writes, std::uint32_t copies,
                                                const VkCopyDescriptorSet* copied) {
    for (std::uint32_t k = 0; k < count; ++k)
      self().sets_[writes[k].dstSet][writes[k].dstBinding] = writes[k].pBufferInfo->buffer;
    self().calls_.update_sets(device, count, writes, copies, copied);
  }
  static VKAPI_ATTR void VKAPI_CALL barrier(VkCommandBuffer commands, VkPipelineStageFlags from,
                                            VkPipelineStageFlags to, VkDependencyFlags flags,
                                            std::uint32_t memories, const VkMemoryBarrier* memory,
                                            std::uint32_t buffers, const VkBufferMemoryBarrier* buffer,
                                            std::uint32_t images, const VkImageMemoryBarrier* image) {
    self().barriers_.push_back({self().since_barrier_, {}, to == VK_PIPELINE_STAGE_HOST_BIT});
    self().since_barrier_ = {};
    self().is_after_barrier_ = true;
    if (self().left_out_ == self().barriers_.size() - 1) return;
    for (auto& [handle, use] : self().uses_)
      if (to == VK_PIPELINE_STAGE_HOST_BIT)
        use.to_host.reset();
      else {
        use.written.reset();
        use.read.clear();
      }
    self().calls_.barrier(commands, from, to, flags, memories, memory, buffers, buffer, images, image);
  }
  static VKAPI_ATTR void VKAPI_CALL copy(VkCommandBuffer commands, VkBuffer from, VkBuffer to,
                                         std::uint32_t count, const VkBufferCopy* regions) {
    const bool is_for_host = self().of_host_.contains(to);
    const std::string name = is_for_host ? "copy to the host" : "copy";
    self().did(name);
    self().reads(from, name);
    if (is_for_host)
      self().uses_[to].to_host = name;  // each goes to a different place
    else
      self().writes(to, name);
    self().calls_.copy(commands, from, to, count, regions);
  }
  static VKAPI_ATTR void VKAPI_CALL bind_pipeline(VkCommandBuffer commands, VkPipelineBindPoint point,
                                                  VkPipeline pipeline) {
    self().pipeline_ = pipeline;
    self().calls_.bind_pipeline(commands, point, pipeline);
  }
  static VKAPI_ATTR void VKAPI_CALL bind_sets(VkCommandBuffer commands, VkPipelineBindPoint point,
                                              VkPipelineLayout layout, std::uint32_t first,
                                              std::uint32_t count, const VkDescriptorSet* sets,
                                              std::uint32_t offsets, const std::uint32_t* offset) {
    self().set_ = *sets;
    self().calls_.bind_sets(commands, point, layout, first, count, sets, offsets, offset);
  }
  static VKAPI_ATTR void VKAPI_CALL dispatch(VkCommandBuffer commands, std::uint32_t x, std::uint32_t y,
                                             std::uint32_t z) {
    self().on_dispatch();
    self().calls_.dispatch(commands, x, y, z);
  }
  static VKAPI_ATTR VkResult VKAPI_CALL submit(VkQueue queue, std::uint32_t count, const VkSubmitInfo* infos,
                                               VkFence fence) {
    self().is_under_way_ = true;
    if (fence != VK_NULL_HANDLE)
      for (auto& [handle, use] : self().uses_)
        if (use.to_host) self().hazards_.push_back("the host may read before it sees the " + *use.to_host);
    return self().calls_.submit(queue, count, infos, fence);
  }
  static VKAPI_ATTR VkResult VKAPI_CALL wait(VkDevice device, std::uint32_t count, const VkFence* fences,
                                             VkBool32 all, std::uint64_t timeout) {
    self().is_under_way_ = false;
    for (auto& [handle, use] : self().uses_) use.read.clear();
    return self().calls_.wait(device, count, fences, all, timeout);
  }

  template <class Call>
  static PFN_vkVoidFunction instead(PFN_vkVoidFunction real, Call& kept, Call ours) {
    kept = reinterpret_cast<Call>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(ours);
  }
  static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_device(VkDevice device, const char* name) {
    Calls& calls = self().calls_;
    const PFN_vkVoidFunction real = calls.of_device(device, name);
    const auto is = [&](const char* other) { return std::strcmp(name, other) == 0; };
    if (is("vkBeginCommandBuffer")) return instead(real, calls.begin, &begin);
    if (is("vkEndCommandBuffer")) return instead(real, calls.end, &end);
    if (is("vkCreateComputePipelines")) return instead(real, calls.create_pipelines, &create_pipelines);
    if (is("vkCreateBuffer")) return instead(real, calls.create_buffer, &create_buffer);
    if (is("vkUpdateDescriptorSets")) return instead(real, calls.update_sets, &update_sets);
    if (is("vkCmdPipelineBarrier")) return instead(real, calls.barrier, &barrier);
    if (is("vkCmdCopyBuffer")) return instead(real, calls.copy, &copy);
    if (is("vkCmdBindPipeline")) return instead(real, calls.bind_pipeline, &bind_pipeline);
    if (is("vkCmdBindDescriptorSets")) return instead(real, calls.bind_sets, &bind_sets);
    if (is("vkCmdDispatch")) return instead(real, calls.dispatch, &dispatch);
    if (is("vkQueueSubmit")) return instead(real, calls.submit, &submit);
    if (is("vkWaitForFences")) return instead(real, calls.wait, &wait);
    return real;
  }
};

WatchedCommands::WatchedCommands() {
  if (watching() != nullptr) throw std::logic_error("one set of commands is watched at a time");
  watching() = this;
  calls_.of_device = vkGetDeviceProcAddr;
  vkGetDeviceProcAddr = &Entries::of_device;
}

WatchedCommands::~WatchedCommands() {
  vkGetDeviceProcAddr = calls_.of_device;
  watching() = nullptr;
}

void WatchedCommands::start(std::optional<std::size_t> left_out) {
  left_out_ = left_out;
  barriers_.clear();
  hazards_.clear();
}

void WatchedCommands::did(const std::string& name) {
  const auto add = [&](std::string& list) {
    // Successive copies, and successive dispatches of one kernel, count as one.
    if (list == name || list.ends_with(", " + name)) return;
    if (!list.empty()) list += ", ";
    list += name;
  };
  if (is_after_barrier_ && !barriers_.empty()) add(barriers_.back().before);
  add(since_barrier_);
}

void WatchedCommands::reads(VkBuffer buffer, const std::string& by) {
  Use& use = uses_[buffer];
  if (use.written) hazards_.push_back(by + " reads what " + *use.written + " writes");
  use.read.insert(by);
}

void WatchedCommands::writes(VkBuffer buffer, const std::string& by) {
  Use& use = uses_[buffer];
  if (use.written) hazards_.push_back(by + " writes what " + *use.written + " writes");
  for (const std::string& reader : use.read) hazards_.push_back(by + " writes what " + reader + " reads");
  use.written = by;
}

void WatchedCommands::on_dispatch() {
  const std::uint32_t number = kernels_.at(pipeline_);
  if (number >= model::kernel_count) throw std::logic_error("a pipeline that is no kernel of the schedule");
  const model::KernelAccess& access = access_of(static_cast<model::Kernel>(number));
  const std::string name(access.name);
  did(name);
  dispatched_.insert(name);
  // Invocations of one dispatch need not wait for each other, so all reads come before all writes.
  std::vector<VkBuffer> written;
  for (const auto& [binding, buffer] : sets_.at(set_)) {
    const auto field = std::find_if(std::begin(model::field_rows), std::end(model::field_rows),
                                    [&](const model::FieldTraits& row) { return row.buffer == binding; });
    if (field == std::end(model::field_rows) || access.reads().has(field->field)) {
      const std::optional<std::string>& before = uses_[buffer].written;
      if (before != name) reads(buffer, name);
    }
    if (field != std::end(model::field_rows) && access.writes.has(field->field)) written.push_back(buffer);
  }
  for (const VkBuffer buffer : written) {
    Use& use = uses_[buffer];
    use.read.erase(name);
    if (use.written == name) use.written.reset();
    writes(buffer, name);
  }
}

}  // namespace fascicle::tests
