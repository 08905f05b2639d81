#include "host/build/message.h"

#include <algorithm>

namespace fascicle::build {

namespace {
constexpr std::size_t shown_in_text = 5;
constexpr std::size_t kept_in_report = 16;
}  // namespace

std::string list_of(std::span<const std::uint32_t> ids) {
  std::string text;
  const std::size_t shown = std::min(ids.size(), shown_in_text);
  for (std::size_t k = 0; k < shown; ++k) text += (k ? ", " : "") + std::to_string(ids[k]);
  if (ids.size() > shown) text += " and " + std::to_string(ids.size() - shown) + " more";
  return text;
}

std::string counted(std::size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

void fail(const std::string& source, const std::string& what) {
  throw scene::SceneError(source.empty() ? what : source + ": " + what);
}

void warn(Report& report, const std::string& text, std::span<const std::uint32_t> vertices) {
  const std::size_t kept = std::min(vertices.size(), kept_in_report);
  report.warnings.push_back(
      {text, {vertices.begin(), vertices.begin() + static_cast<std::ptrdiff_t>(kept)}, false});
}

void warn_of_flesh(Report& report, const std::string& text, std::span<const std::uint32_t> vertices) {
  warn(report, text, vertices);
  report.warnings.back().is_of_flesh = true;
}

}  // namespace fascicle::build
