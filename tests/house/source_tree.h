// The repository's own sources as text, for tests that hold rules against them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace fascicle::tests {

struct Source {
  std::string path;  // from the repository's root, with '/'
  std::string text;
};

// Every .h .hpp .c .cpp .inc .comp .glsl file of the rooms, by path.
std::vector<Source> read_sources(const std::filesystem::path& root);

// Every file that belongs to the repository, by path; of pictures and other bytes the text is empty.
std::vector<Source> read_repository(const std::filesystem::path& root);

// The text with comments turned into spaces, or with everything but comments; lines stay where they are.
// Knows string and character literals and raw strings.
std::string without_comments(const std::string& text);
std::string only_comments(const std::string& text);

std::vector<std::string> lines_of(const std::string& text);

}  // namespace fascicle::tests
