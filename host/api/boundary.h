// What every function of the C API does on entry and exit: checks arguments and stops exceptions.
#pragma once

#include <algorithm>
#include <cfenv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/pipeline/messages.h"
#include "include/fascicle/fascicle.h"

namespace fascicle::api {

// FASCICLE_BAD_ARGUMENT. what() says which argument and what it must be.
struct BadArgument : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};
// FASCICLE_CANCELLED.
struct Cancelled : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Keeps the message for fascicle_last_message and returns the status. Substitutes a shorter message if memory
// runs out.
fascicle_status failed(fascicle_status status, const char* message) noexcept;
// The same for the exception being handled.
fascicle_status failed_by_exception() noexcept;

// The default floating-point environment, on which the bits depend: rounding to nearest, no traps. Threads
// that are started meanwhile have it too. Restores the caller's.
class DefaultFloats {
 public:
  DefaultFloats() noexcept {
    std::fegetenv(&before_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~DefaultFloats() { std::fesetenv(&before_); }
  DefaultFloats(const DefaultFloats&) = delete;
  DefaultFloats& operator=(const DefaultFloats&) = delete;

 private:
  std::fenv_t before_;
};

template <class Work>
fascicle_status guarded(Work&& work) noexcept {
  const DefaultFloats floats;
  try {
    work();
    return FASCICLE_OK;
  } catch (...) {
    return failed_by_exception();
  }
}

// The same for a function that creates a handle: `*out` is null unless it succeeds.
template <class Handle, class Work>
fascicle_status guarded_make(Handle** out, Work&& work) noexcept {
  if (out == nullptr) return failed(FASCICLE_BAD_ARGUMENT, "the pointer that is to get the handle is null");
  *out = nullptr;
  return guarded([&] { *out = work().release(); });
}

// The work's value, or null if it throws: for names, for which nobody needs a status.
template <class Work>
const char* text_or_null(Work&& work) noexcept {
  try {
    return work();
  } catch (...) {
    return nullptr;
  }
}

template <class Pointer>
const Pointer& must_have(const Pointer& pointer, const char* name) {
  if (pointer == nullptr) throw BadArgument(std::string(name) + " is null");
  return pointer;
}

// Options as this library knows them: fields that the caller's headers lack keep their defaults. `init` is
// the struct's fascicle_..._init.
template <class Options>
Options taken(const Options* given, void (*init)(Options*, std::size_t), const char* name) {
  Options options;
  init(&options, sizeof options);
  if (given == nullptr) return options;
  // No struct ends within a pointer, whatever the headers.
  const std::size_t size = given->struct_size;
  if (size < sizeof(std::size_t) || size > sizeof options || size % alignof(Options) != 0)
    throw BadArgument(std::string(name) + ".struct_size is " + std::to_string(size) +
                      ", and this library knows multiples of " + std::to_string(alignof(Options)) +
                      " up to " + std::to_string(sizeof options) +
                      "; initialise it with its _default(), from headers no newer than the library");
  std::memcpy(&options, given, size);
  options.struct_size = sizeof options;
  return options;
}

// Implements an _init: copies as much of `defaults` as the caller's headers have.
template <class Options>
void fill(Options* options, std::size_t struct_size, Options defaults) {
  if (options == nullptr) return;
  std::memset(static_cast<void*>(options), 0, struct_size);
  defaults.struct_size = struct_size;
  std::memcpy(options, &defaults, std::min(struct_size, sizeof defaults));
}

// For the CPU solver; the command line has the same limit. Throws BadArgument.
inline void check_threads(std::uint32_t threads) {
  if (threads > 1024)
    throw BadArgument("options.threads is " + std::to_string(threads) + "; it must be from 0 to 1024");
}

// Null gives "".
inline std::string text_of(const char* text) {
  return text == nullptr ? std::string() : std::string(text);
}
// `count` strings. Throws BadArgument if one is null.
std::vector<std::string> texts_of(const char* const* texts, std::size_t count, const char* name);
// NULL: the program's default; "": none.
std::filesystem::path cache_of(const char* cache);
pipeline::Say say_to(fascicle_log_function* log, void* user);

}  // namespace fascicle::api
