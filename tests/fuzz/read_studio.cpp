#include "host/studio/commands.h"
#include "host/studio/session_file.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {

bool message(std::string_view bytes) {
  return is_taken<studio::BadMessage>([&] { studio::parse_command(bytes); });
}

bool session(std::string_view bytes) {
  return studio::parse_session(std::string(bytes)).has_value();
}

}  // namespace fascicle::fuzz
