#include "cpu_reference/huge_pages.h"

#include <algorithm>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace fascicle::cpu_reference {

namespace {

constexpr std::size_t page = std::size_t{2} << 20;
constexpr std::size_t line = 64;
// What nobody touches of a block costs no memory, so blocks may be generous.
constexpr std::size_t least_block = 4 * page;

std::size_t rounded_up(std::size_t bytes, std::size_t unit) {
  return (bytes + unit - 1) / unit * unit;
}

}  // namespace

HugePages::~HugePages() {
  for (void* block : blocks_) ::operator delete (block, std::align_val_t{page});
}

void* HugePages::allocate(std::size_t bytes) {
  bytes = rounded_up(bytes, line);
  if (bytes > left_) {
    const std::size_t size = std::max(least_block, rounded_up(bytes, page));
    blocks_.reserve(blocks_.size() + 1);
    blocks_.push_back(::operator new (size, std::align_val_t{page}));
    free_ = static_cast<std::byte*>(blocks_.back());
    left_ = size;
#ifdef __linux__
    // A wish: where the system has no such pages, small ones do.
    (void)madvise(free_, size, MADV_HUGEPAGE);
#endif
  }
  std::byte* const given = free_;
  free_ += bytes;
  left_ -= bytes;
  return given;
}

}  // namespace fascicle::cpu_reference
