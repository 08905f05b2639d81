#include "host/api/boundary.h"

#include <new>
#include <system_error>

#include "host/bake/bake.h"
#include "host/base/version.h"
#include "host/build/build.h"
#include "host/build/cache.h"
#include "host/pipeline/device_choice.h"
#include "host/pipeline/errors.h"
#include "host/scene/scene.h"

namespace fascicle::api {
namespace {

static_assert(std::string_view(FASCICLE_VERSION_STRING) == base::fascicle_version,
              "include/fascicle/version.h and the root CMakeLists.txt differ");
static_assert(FASCICLE_VERSION_MAJOR < 1000 && FASCICLE_VERSION_MINOR < 1000 &&
              FASCICLE_VERSION_PATCH < 1000);

// One per thread, like errno. `shown` is `text`, or a string literal if there was no memory.
struct KeptMessage {
  std::string text;
  const char* shown = "";
};

KeptMessage& kept_message() noexcept {
  thread_local KeptMessage message;
  return message;
}

}  // namespace

fascicle_status failed(fascicle_status status, const char* message) noexcept {
  KeptMessage& kept = kept_message();
  try {
    kept.text = message;
    kept.shown = kept.text.c_str();
  } catch (...) {
    kept.shown = "out of memory";
  }
  return status;
}

fascicle_status failed_by_exception() noexcept {
  try {
    throw;
  } catch (const Cancelled& error) {
    return failed(FASCICLE_CANCELLED, error.what());
  } catch (const build::Cancelled& error) {
    return failed(FASCICLE_CANCELLED, error.what());
  } catch (const std::invalid_argument& error) {
    return failed(FASCICLE_BAD_ARGUMENT, error.what());
  } catch (const pipeline::UsageError& error) {
    return failed(FASCICLE_BAD_ARGUMENT, error.what());
  } catch (const bake::FolderInUse& error) {
    return failed(FASCICLE_BAD_ARGUMENT, error.what());
  } catch (const bake::ContradictingOptions& error) {
    return failed(FASCICLE_BAD_ARGUMENT, error.what());
  } catch (const scene::SceneError& error) {
    return failed(FASCICLE_BAD_INPUT, error.what());
  } catch (const bake::BakeError& error) {
    return failed(FASCICLE_BAD_INPUT, error.what());
  } catch (const pipeline::NoSuchDevice& error) {
    return failed(FASCICLE_NO_SUCH_DEVICE, error.what());
  } catch (const pipeline::DeviceFailed& error) {
    return failed(FASCICLE_DEVICE_FAILED, error.what());
  } catch (const gpu::DeviceError& error) {
    return failed(FASCICLE_DEVICE_FAILED, error.what());
  } catch (const bake::NotFinite& error) {
    return failed(FASCICLE_NOT_FINITE, error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    return failed(FASCICLE_BAD_INPUT, error.what());
  } catch (const std::bad_alloc&) {
    return failed(FASCICLE_FAILED, "out of memory; try a coarser mesh");
  } catch (const std::length_error&) {
    return failed(FASCICLE_BAD_ARGUMENT, "a count is larger than any memory");
  } catch (const std::exception& error) {
    return failed(FASCICLE_FAILED, error.what());
  } catch (...) {
    return failed(FASCICLE_FAILED, "an error without a message");
  }
}

std::vector<std::string> texts_of(const char* const* texts, std::size_t count, const char* name) {
  std::vector<std::string> result;
  if (count > 0) must_have(texts, name);
  for (std::size_t k = 0; k < count; ++k) {
    if (texts[k] == nullptr) throw BadArgument(std::string(name) + "[" + std::to_string(k) + "] is null");
    result.emplace_back(texts[k]);
  }
  return result;
}

std::filesystem::path cache_of(const char* cache) {
  return cache == nullptr ? build::default_cache_folder() : std::filesystem::path(cache);
}

pipeline::Say say_to(fascicle_log_function* log, void* user) {
  if (log == nullptr) return {};
  return [log, user](pipeline::Severity severity, const std::string& message) {
    log(user, static_cast<fascicle_severity>(severity), message.c_str());
  };
}

}  // namespace fascicle::api

using namespace fascicle;

const char* fascicle_status_text(fascicle_status status) {
  switch (status) {
    case FASCICLE_OK:
      return "done";
    case FASCICLE_FAILED:
      return "failed";
    case FASCICLE_BAD_ARGUMENT:
      return "bad argument";
    case FASCICLE_BAD_INPUT:
      return "bad input";
    case FASCICLE_NO_SUCH_DEVICE:
      return "no such device";
    case FASCICLE_DEVICE_FAILED:
      return "a device failed";
    case FASCICLE_NOT_FINITE:
      return "positions are no longer finite";
    case FASCICLE_CANCELLED:
      return "cancelled";
  }
  return "unknown status";
}

const char* fascicle_last_message(void) {
  return api::kept_message().shown;
}

const char* fascicle_version(void) {
  return base::fascicle_version;
}

uint32_t fascicle_solver_version(void) {
  return base::solver_version;
}
