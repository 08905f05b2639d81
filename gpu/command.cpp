#include "gpu/command.h"

#include <limits>

namespace fascicle::gpu {

CommandPool::CommandPool(const Device::Impl& device) : device_(&device) {
  VkCommandPoolCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
  info.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  info.queueFamilyIndex = device.physical.queue_family;
  VkCommandPool pool = VK_NULL_HANDLE;
  VULKAN_CHECK(device.call.vkCreateCommandPool(device.device, &info, nullptr, &pool));
  pool_ = {device.device, pool, device.call.vkDestroyCommandPool};
}

void CommandPool::reset() {
  // Command buffers are freed with their pool; a new pool is the simplest way to free them all.
  *this = CommandPool(*device_);
}

Fence::Fence(Device::Impl& device) : device_(&device) {
  VkFenceCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
  VkFence fence = VK_NULL_HANDLE;
  VULKAN_CHECK(device.call.vkCreateFence(device.device, &info, nullptr, &fence));
  fence_ = {device.device, fence, device.call.vkDestroyFence};
}

void Fence::wait() const {
  const VkFence fence = fence_.get();
  const VkResult result = device_->call.vkWaitForFences(device_->device, 1, &fence, VK_TRUE,
                                                        std::numeric_limits<std::uint64_t>::max());
  if (result == VK_SUCCESS) return;
  // Work in flight uses objects that the caller destroys when this throws. A lost device has none in flight.
  try {
    device_->wait_idle();
  } catch (const DeviceError&) {
  }
  check(result, "vkWaitForFences");
}

void Fence::reset() const {
  const VkFence fence = fence_.get();
  VULKAN_CHECK(device_->call.vkResetFences(device_->device, 1, &fence));
}

Timestamps::Timestamps(const Device::Impl& device, std::uint32_t pairs)
    : device_(&device), pairs_(device.physical.has_timestamps ? pairs : 0) {
  if (pairs_ == 0) return;
  VkQueryPoolCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = 2 * pairs_;
  VkQueryPool pool = VK_NULL_HANDLE;
  VULKAN_CHECK(device.call.vkCreateQueryPool(device.device, &info, nullptr, &pool));
  pool_ = {device.device, pool, device.call.vkDestroyQueryPool};
}

std::optional<double> Timestamps::elapsed(std::uint32_t pair) const {
  if (pair >= pairs_) return std::nullopt;
  std::uint64_t ticks[2] = {};
  const VkResult result =
      device_->call.vkGetQueryPoolResults(device_->device, pool_.get(), 2 * pair, 2, sizeof ticks, ticks,
                                          sizeof ticks[0], VK_QUERY_RESULT_64_BIT);
  check(result, "vkGetQueryPoolResults");
  if (result == VK_NOT_READY || ticks[1] < ticks[0]) return std::nullopt;
  return static_cast<double>(ticks[1] - ticks[0]) *
         static_cast<double>(device_->physical.limits.timestampPeriod);
}

CommandBuffer::CommandBuffer(Device::Impl& device, const CommandPool& pool) : device_(&device) {
  VkCommandBufferAllocateInfo allocation{};
  allocation.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
  allocation.commandPool = pool.get();
  allocation.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocation.commandBufferCount = 1;
  VULKAN_CHECK(device.call.vkAllocateCommandBuffers(device.device, &allocation, &commands_));
  VkCommandBufferBeginInfo begin{};
  begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VULKAN_CHECK(device.call.vkBeginCommandBuffer(commands_, &begin));
}

void CommandBuffer::begin_timing(const Timestamps& timestamps, std::uint32_t pair) {
  if (pair >= timestamps.pairs()) return;
  device_->call.vkCmdResetQueryPool(commands_, timestamps.get(), 2 * pair, 2);
  // When earlier work is done: at the top of the pipe, the time of earlier submissions would count too.
  device_->call.vkCmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, timestamps.get(),
                                    2 * pair);
}

void CommandBuffer::end_timing(const Timestamps& timestamps, std::uint32_t pair) {
  if (pair >= timestamps.pairs()) return;
  device_->call.vkCmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, timestamps.get(),
                                    2 * pair + 1);
}

void CommandBuffer::barrier() {
  constexpr VkPipelineStageFlags stages =
      VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
  VkMemoryBarrier memory{};
  memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  memory.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
  memory.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT |
                         VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
  device_->call.vkCmdPipelineBarrier(commands_, stages, stages, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

void CommandBuffer::barrier_to_host() {
  VkMemoryBarrier memory{};
  memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  memory.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  memory.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
  device_->call.vkCmdPipelineBarrier(commands_, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0,
                                     1, &memory, 0, nullptr, 0, nullptr);
}

void CommandBuffer::copy(const Buffer& from, VkDeviceSize from_offset, const Buffer& to,
                         VkDeviceSize to_offset, VkDeviceSize bytes) {
  const VkBufferCopy region{from_offset, to_offset, bytes};
  device_->call.vkCmdCopyBuffer(commands_, from.get(), to.get(), 1, &region);
}

void CommandBuffer::dispatch(const Kernel& kernel, VkDescriptorSet set, const shader::Push& push,
                             std::uint32_t groups) {
  device_->call.vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, kernel.pipeline());
  device_->call.vkCmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, kernel.layout(), 0, 1,
                                        &set, 0, nullptr);
  device_->call.vkCmdPushConstants(commands_, kernel.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof push,
                                   &push);
  device_->call.vkCmdDispatch(commands_, groups, 1, 1);
}

void CommandBuffer::submit(VkFence fence) {
  VULKAN_CHECK(device_->call.vkEndCommandBuffer(commands_));
  device_->submit(commands_, fence);
}

void CommandBuffer::submit_and_wait() {
  const Fence fence(*device_);
  submit(fence.get());
  fence.wait();
}

}  // namespace fascicle::gpu
