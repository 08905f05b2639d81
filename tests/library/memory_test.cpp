// No memory at all is still a status and a text: nothing crosses the C API, and nothing ends the program.
#include <cstdlib>
#include <new>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "include/fascicle/fascicle.h"

namespace {

thread_local bool memory_is_out = false;

}  // namespace

// The library's too: a program's operator new goes before every other. Not inline, or GCC warns that a free()
// belongs to no new.
[[gnu::noinline]] void* operator new(std::size_t size) {
  void* const memory = memory_is_out ? nullptr : std::malloc(size == 0 ? 1 : size);
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

// On a thread of its own, which has kept no message yet and so has no room for one.
TEST(Memory, WithoutItCallsFailWithAMessage) {
  fascicle_scene* const untouched = reinterpret_cast<fascicle_scene*>(1);
  fascicle_scene* scene = untouched;
  fascicle_status loaded = FASCICLE_OK, refused = FASCICLE_OK;
  const char *text = nullptr, *other = nullptr;
  // Read beforehand: toml++, which reads the built-in scenes once, ends the program where it has no memory.
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
