// Memory for a solver's large arrays, in pages of 2 MiB if the system has them: one-rings are gathered from
// all over these arrays, and with 4 KiB pages TLB misses took a quarter of a substep's time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fascicle::cpu_reference {

// Hands out memory piece by piece, aligned to cache lines, and frees it all at once when destroyed.
class HugePages {
 public:
  HugePages() = default;
  ~HugePages();
  HugePages(const HugePages&) = delete;
  HugePages& operator=(const HugePages&) = delete;

  // Throws std::bad_alloc.
  void* allocate(std::size_t bytes);

 private:
  struct Block {
    void* begin;
    std::size_t size;
  };
  // Points free_ at a new block of at least this size.
  void add_block(std::size_t bytes);

  std::vector<Block> blocks_;
  std::byte* free_ = nullptr;  // in the last block
  std::size_t left_ = 0;
};

}  // namespace fascicle::cpu_reference
