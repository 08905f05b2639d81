#include "host/pipeline/text.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>

#include "host/base/display_width.h"
#include "host/base/text.h"

namespace fascicle::pipeline {
namespace {

template <class... Arguments>
std::string print(const char* format, Arguments... arguments) {
  std::array<char, 128> buffer{};
  const int length = std::snprintf(buffer.data(), buffer.size(), format, arguments...);
  return std::string(buffer.data(), static_cast<std::size_t>(std::clamp(length, 0, 127)));
}

}  // namespace

std::string number_text(double value, int digits) {
  return print("%.*g", digits, value);
}

std::string count_text(std::uint64_t value) {
  std::string digits = std::to_string(value);
  for (std::size_t place = digits.size(); place > 3; place -= 3) digits.insert(place - 3, ",");
  return digits;
}

std::string counted_text(std::uint64_t value, const std::string& one, const std::string& many) {
  return count_text(value) + " " + (value == 1 ? one : many);
}

std::string bytes_text(std::uint64_t bytes) {
  if (bytes < 1024) return std::to_string(bytes) + " bytes";
  constexpr std::array<const char*, 5> names{"KiB", "MiB", "GiB", "TiB", "PiB"};
  double value = static_cast<double>(bytes) / 1024.0;
  std::size_t name = 0;
  for (; value >= 1024.0 && name + 1 < names.size(); ++name) value /= 1024.0;
  return print(value < 10.0 ? "%.1f %s" : "%.0f %s", value, names[name]);
}

std::string duration_text(double seconds) {
  constexpr double longest = 1e12;
  if (!(seconds >= 0.0 && seconds < longest)) return "unknown";
  if (seconds < 10.0) return print("%.2f s", seconds);
  if (seconds < 60.0) return print("%.0f s", seconds);
  const auto whole = static_cast<unsigned long long>(std::llround(seconds));
  if (whole < 3600) return print("%llu min %02llu s", whole / 60, whole % 60);
  return print("%llu h %02llu min", whole / 3600, whole % 3600 / 60);
}

std::string bits_text(float value) {
  return print("0x%08x", std::bit_cast<std::uint32_t>(value));
}

std::string float_text(float value) {
  return print("%.9g", static_cast<double>(value));
}

std::string columns_text(std::vector<std::pair<std::string, std::string>> rows) {
  std::size_t width = 0;
  for (auto& [name, value] : rows) name = base::shown_text(name), value = base::shown_text(value);
  for (const auto& [name, value] : rows) width = std::max(width, base::display_width(name));
  std::string text;
  for (const auto& [name, value] : rows)
    text += "  " + name + std::string(width - base::display_width(name) + 2, ' ') + value + "\n";
  return text;
}

}  // namespace fascicle::pipeline
