// Access control. Every program and every page in the machine's browser can reach loopback, so each request
// must prove that it comes from the page that this server served.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace fascicle::studio {

// 32 hex digits from the system's random number generator. Throws std::system_error if there is none.
std::string new_token();

// Constant-time comparison.
bool is_token(std::string_view given, std::string_view token);

// Whether a Host header names this server: 127.0.0.1 or localhost, with its port. Any other name means DNS
// rebinding: a page that bound its own name to loopback.
bool is_own_host(std::string_view host, std::uint16_t port);
// Whether an Origin header is this server's.
bool is_own_origin(std::string_view origin, std::uint16_t port);

// A request's target, "/name?token=abc", parsed.
struct Target {
  std::string_view path;                  // without the slash
  std::optional<std::string_view> token;  // from the query
};
// Nullopt unless it is a plain path: it must begin with one slash and contain no "..", no percent sign and no
// second slash. The page's file names need none of these.
std::optional<Target> parse_target(std::string_view target);

// The value of Content-Security-Policy: what the page may load and who may frame it.
std::string content_security_policy(std::uint16_t port);

}  // namespace fascicle::studio
