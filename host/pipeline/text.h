// Numbers formatted for users.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace fascicle::pipeline {

// printf's %.*g
std::string number_text(double value, int digits = 4);
// 1234567 -> "1,234,567"
std::string count_text(std::uint64_t value);
// counted_text(1, "vertex", "vertices") -> "1 vertex", of 1234 -> "1,234 vertices"
std::string counted_text(std::uint64_t value, const std::string& one, const std::string& many);
// Powers of 1024: "512 bytes", "3.4 MiB"
std::string bytes_text(std::uint64_t bytes);
// "0.35 s", "12 s", "3 min 20 s", "2 h 05 min"
std::string duration_text(double seconds);
// The float's bits, "0x3f800000"
std::string bits_text(float value);
// All digits that distinguish a float from its neighbours
std::string float_text(float value);

// Two aligned columns, each line indented by two spaces. Names from files are shown as base::shown_text does.
std::string columns_text(std::vector<std::pair<std::string, std::string>> rows);

}  // namespace fascicle::pipeline
