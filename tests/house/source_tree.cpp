#include "tests/house/source_tree.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <string_view>

namespace fascicle::tests {
namespace {

// Splits text into comments and code, each with the other replaced by spaces.
struct Split {
  std::string code, comments;
};

Split split(const std::string& text) {
  Split result{text, text};
  const auto blank = [&text](std::string& part, std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k)
      if (text[k] != '\n') part[k] = ' ';
  };
  const auto end_of = [&text](std::string_view mark, std::size_t from, std::size_t past) {
    const std::size_t found = text.find(mark, from);
    return found == std::string::npos ? text.size() : found + past;
  };
  std::size_t k = 0;
  while (k < text.size()) {
    std::size_t end = k + 1;
    bool comment = false;
    if (text.compare(k, 2, "//") == 0) {
      end = end_of("\n", k, 0);
      comment = true;
    } else if (text.compare(k, 2, "/*") == 0) {
      end = end_of("*/", k + 2, 2);
      comment = true;
    } else if (text.compare(k, 2, "R\"") == 0) {
      const std::size_t open = text.find('(', k);
      if (open != std::string::npos) {
        std::string close(")");
        close.append(text, k + 2, open - k - 2).append("\"");
        end = end_of(close, open, close.size());
      }
    } else if (text[k] == '"' ||
               (text[k] == '\'' && (k == 0 || !std::isalnum(static_cast<unsigned char>(text[k - 1]))))) {
      while (end < text.size() && text[end] != text[k] && text[end] != '\n') end += text[end] == '\\' ? 2 : 1;
      end = std::min(end + 1, text.size());
    }
    blank(comment ? result.code : result.comments, k, end);
    k = end;
  }
  return result;
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

}  // namespace

std::vector<Source> read_repository(const std::filesystem::path& root) {
  constexpr std::array<const char*, 11> folders{".ci",    "bench",   "cpu_reference", "docs",
                                                "gpu",    "host",    "include",       "python",
                                                "scenes", "shaders", "tests"};
  std::vector<Source> files;
  const auto add = [&](const std::filesystem::path& path) {
    std::string text = bytes_of(path);
    if (text.find('\0') != std::string::npos) text.clear();
    files.push_back({std::filesystem::relative(path, root).generic_string(), std::move(text)});
  };
  for (const auto& entry : std::filesystem::directory_iterator(root))
    if (entry.is_regular_file()) add(entry.path());
  for (const char* folder : folders)
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder))
      if (entry.is_regular_file() && entry.path().string().find("__pycache__") == std::string::npos)
        add(entry.path());
  std::sort(files.begin(), files.end(), [](const Source& a, const Source& b) { return a.path < b.path; });
  return files;
}

std::vector<Source> read_sources(const std::filesystem::path& root) {
  constexpr std::array<const char*, 8> rooms{"shaders", "gpu",   "host",    "cpu_reference",
                                             "tests",   "bench", "include", "python"};
  constexpr std::array<const char*, 7> extensions{".h", ".hpp", ".c", ".cpp", ".inc", ".comp", ".glsl"};
  std::vector<Source> sources;
  for (const char* room : rooms) {
    if (!std::filesystem::is_directory(root / room)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / room)) {
      const std::string extension = entry.path().extension().string();
      if (!entry.is_regular_file() ||
          std::find(extensions.begin(), extensions.end(), extension) == extensions.end())
        continue;
      sources.push_back(
          {std::filesystem::relative(entry.path(), root).generic_string(), bytes_of(entry.path())});
    }
  }
  std::sort(sources.begin(), sources.end(), [](const Source& a, const Source& b) { return a.path < b.path; });
  return sources;
}

std::string without_comments(const std::string& text) {
  return split(text).code;
}

std::string only_comments(const std::string& text) {
  return split(text).comments;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

}  // namespace fascicle::tests
