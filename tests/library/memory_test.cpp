// Out of memory gives a status and a message: no exception crosses the C API, and the process survives.
#include <cstdlib>
#include <new>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "include/fascicle/fascicle.h"

namespace {

thread_local bool memory_is_out = false;

}  // namespace

// Also replaces operator new of the library: the program's definition takes precedence. Not inline, or GCC
// warns that a free() does not match its new. All forms, as the address sanitizer's own do not match free().
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return memory_is_out ? nullptr : std::malloc(size == 0 ? 1 : size);
}
[[gnu::noinline]] void* operator new(std::size_t size) {
  void* const memory = operator new(size, std::nothrow);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace fascicle_tests {
namespace {

// On a new thread, which has no message yet and so no buffer for one.
TEST(Memory, WithoutItCallsFailWithAMessage) {
  fascicle_scene* const untouched = reinterpret_cast<fascicle_scene*>(1);
  fascicle_scene* scene = untouched;
  fascicle_status loaded = FASCICLE_OK, refused = FASCICLE_OK;
  const char *text = nullptr, *other = nullptr;
  // Read this first: toml++, which parses the built-in scenes once, terminates when it runs out of memory.
  ASSERT_NE(fascicle_builtin_scene_name(0), nullptr);
  std::thread([&] {
    memory_is_out = true;
    loaded = fascicle_scene_load("a name of a scene that no short string holds", nullptr, &scene);
    text = fascicle_last_message();
    refused = fascicle_scene_load("arm", nullptr, nullptr);
    other = fascicle_last_message();
    (void)fascicle_builtin_scene_name(0);
    (void)fascicle_format_name(0);
    memory_is_out = false;
  }).join();
  EXPECT_EQ(loaded, FASCICLE_FAILED);
  EXPECT_EQ(scene, nullptr);
  EXPECT_EQ(std::string(text), "out of memory");
  EXPECT_EQ(refused, FASCICLE_BAD_ARGUMENT);
  EXPECT_EQ(std::string(other), "out of memory");
  EXPECT_NE(fascicle_format_name(0), nullptr);
}

}  // namespace
}  // namespace fascicle_tests
