// The repository's sources as text, for tests of rules.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace fascicle::tests {

struct Source {
  std::string path;  // relative to the repository, with '/'
  std::string text;
};

// Every .h .hpp .c .cpp .inc .comp .glsl file of the rooms, sorted by path.
std::vector<Source> read_sources(const std::filesystem::path& root);

// Every file of the repository, sorted by path; binary files have an empty text.
std::vector<Source> read_repository(const std::filesystem::path& root);

// The text with comments, or everything but comments, replaced by spaces; line numbers stay. Handles string
// and character literals and raw strings.
std::string without_comments(const std::string& text);
std::string only_comments(const std::string& text);

std::vector<std::string> lines_of(const std::string& text);

}  // namespace fascicle::tests
