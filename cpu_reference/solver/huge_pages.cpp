#include "cpu_reference/solver/huge_pages.h"

#include <algorithm>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace fascicle::cpu_reference {

namespace {

constexpr std::size_t page = std::size_t{2} << 20;
constexpr std::size_t line = 64;
// Only touched pages of a mapping cost memory, so blocks may be generous.
constexpr std::size_t least_block = 4 * page;

std::size_t rounded_up(std::size_t bytes, std::size_t unit) {
  return (bytes + unit - 1) / unit * unit;
}

}  // namespace

// Under a sanitizer every array has its own block; else it would miss overruns from one array into the next.
#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)

HugePages::~HugePages() {
  for (const Block& block : blocks_) munmap(block.begin, block.size);
}

void HugePages::add_block(std::size_t bytes) {
  // One extra page, so that the first one can start at a huge page boundary. A separate mapping, because in a
  // heap block the madvise would outlive the block.
  const std::size_t size = std::max(least_block, rounded_up(bytes, page)) + page;
  blocks_.reserve(blocks_.size() + 1);
  void* const begin = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (begin == MAP_FAILED) throw std::bad_alloc();
  blocks_.push_back({begin, size});
  const std::size_t skipped =
      rounded_up(reinterpret_cast<std::uintptr_t>(begin), page) - reinterpret_cast<std::uintptr_t>(begin);
  free_ = static_cast<std::byte*>(begin) + skipped;
  left_ = size - skipped;
  // A hint: without huge pages, the system uses small ones.
  (void)madvise(free_, left_ / page * page, MADV_HUGEPAGE);
}

#else

HugePages::~HugePages() {
  for (const Block& block : blocks_) ::operator delete (block.begin, std::align_val_t{line});
}

void HugePages::add_block(std::size_t bytes) {
  blocks_.reserve(blocks_.size() + 1);
  blocks_.push_back({::operator new (bytes, std::align_val_t{line}), bytes});
  free_ = static_cast<std::byte*>(blocks_.back().begin);
  left_ = bytes;
}

#endif

void* HugePages::allocate(std::size_t bytes) {
  // Empty arrays get a line too, so that every address is unique.
  bytes = std::max(line, rounded_up(bytes, line));
  if (bytes > left_) add_block(bytes);
  std::byte* const given = free_;
  free_ += bytes;
  left_ -= bytes;
  return given;
}

}  // namespace fascicle::cpu_reference
