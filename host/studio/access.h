// Who may speak to the studio. Every program and every page in the machine's browser reaches loopback, so a
// request must show that it comes from the page that this server gave out.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace fascicle::studio {

// 32 hex digits from the system's random numbers. Throws std::system_error where there are none.
std::string new_token();

// In a time that does not tell how much of it is right.
bool is_token(std::string_view given, std::string_view token);

// Whether a Host header names this server: 127.0.0.1 or localhost, with its port. Another name that leads
// here is a page that bound its own name to loopback.
bool is_own_host(std::string_view host, std::uint16_t port);
// Whether an Origin header is this server's.
bool is_own_origin(std::string_view origin, std::uint16_t port);

// A request's target, "/name?token=abc", taken apart.
struct Target {
  std::string_view path;                  // without the slash
  std::optional<std::string_view> token;  // of the query
};
// Nothing where it is no plain path: it must begin with one slash and hold no "..", no percent sign and no
// second slash. Names of the page's files need none of them.
std::optional<Target> parse_target(std::string_view target);

// What the page may load and who may frame it: the value of Content-Security-Policy.
std::string content_security_policy(std::uint16_t port);

}  // namespace fascicle::studio
