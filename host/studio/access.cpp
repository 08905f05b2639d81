#include "host/studio/access.h"

#include <array>
#include <cerrno>
#include <system_error>

#include <sys/random.h>

namespace fascicle::studio {

std::string new_token() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw std::system_error(errno, std::generic_category(), "cannot get random numbers from the system");
  constexpr std::string_view digits = "0123456789abcdef";
  std::string token;
  for (const unsigned char byte : bytes) {
    token += digits[byte >> 4];
    token += digits[byte & 15];
  }
  return token;
}

bool is_token(std::string_view given, std::string_view token) {
  if (given.size() != token.size() || token.empty()) return false;
  unsigned difference = 0;
  for (std::size_t k = 0; k < token.size(); ++k)
    difference |=
        static_cast<unsigned>(static_cast<unsigned char>(given[k]) ^ static_cast<unsigned char>(token[k]));
  return difference == 0;
}

bool is_own_host(std::string_view host, std::uint16_t port) {
  const std::string suffix = ":" + std::to_string(port);
  return host == "127.0.0.1" + suffix || host == "localhost" + suffix;
}

bool is_own_origin(std::string_view origin, std::uint16_t port) {
  constexpr std::string_view scheme = "http://";
  return origin.starts_with(scheme) && is_own_host(origin.substr(scheme.size()), port);
}

std::optional<Target> parse_target(std::string_view target) {
  const std::size_t question = target.find('?');
  std::string_view path = target.substr(0, question);
  if (!path.starts_with('/')) return std::nullopt;
  path.remove_prefix(1);
  const bool is_plain =
      path.find("..") == std::string_view::npos && path.find_first_of("%\\/") == std::string_view::npos;
  if (!is_plain) return std::nullopt;
  Target parsed{path, std::nullopt};
  if (question == std::string_view::npos) return parsed;
  constexpr std::string_view key = "token=";
  const std::string_view query = target.substr(question + 1);
  if (query.starts_with(key)) parsed.token = query.substr(key.size());
  return parsed;
}

std::string content_security_policy(std::uint16_t port) {
  const std::string number = std::to_string(port);
  return "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
         "connect-src 'self' ws://127.0.0.1:" +
         number + " ws://localhost:" + number +
         "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
}

}  // namespace fascicle::studio
