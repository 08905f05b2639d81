// Whether a reader accepts its bytes or refuses them as documented.
#pragma once

#include <stdexcept>
#include <string>

namespace fascicle::fuzz {

// A refusal has a message of one line.
inline void check_message(const std::string& what) {
  if (what.empty()) throw std::logic_error("refused without a word");
  if (what.find('\n') != std::string::npos) throw std::logic_error("refused in more than one line: " + what);
}

// False if `read` throws one of Errors; other exceptions propagate.
template <class Error, class... More, class Read>
bool is_taken(const Read& read) {
  try {
    if constexpr (sizeof...(More) > 0) {
      return is_taken<More...>(read);
    } else {
      read();
      return true;
    }
  } catch (const Error& error) {
    check_message(error.what());
    return false;
  }
}

}  // namespace fascicle::fuzz
