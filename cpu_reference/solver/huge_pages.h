// Memory of a solver's large arrays, in pages of 2 MiB where the system has them: one-rings are gathered from
// all over these arrays, and with pages of 4 KiB the look-up of addresses took a quarter of a substep's time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fascicle::cpu_reference {

// Gives memory out piece by piece, each at a cache line, and takes it back all at once when destroyed.
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
  // Makes free_ begin in a new one that holds so many bytes.
  void add_block(std::size_t bytes);

  std::vector<Block> blocks_;
  std::byte* free_ = nullptr;  // of the last block
  std::size_t left_ = 0;
};

}  // namespace fascicle::cpu_reference
