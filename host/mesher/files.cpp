#include "host/mesher/files.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <string_view>

#include "host/mesher/exit_codes.h"

namespace fascicle::mesher {
namespace {

class Words {
 public:
  explicit Words(const std::string& path) : path_(path) {
    std::ifstream stream(path, std::ios::binary);
    if (!stream) fail("cannot be opened");
    text_.assign(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }

  std::string_view next() {
    constexpr const char* space = " \t\r\n";
    const std::size_t start = text_.find_first_not_of(space, at_);
    if (start == std::string::npos) fail("ends early");
    const std::size_t end = text_.find_first_of(space, start);
    at_ = end == std::string::npos ? text_.size() : end;
    return std::string_view(text_).substr(start, at_ - start);
  }

  template <typename Number>
  Number number() {
    const std::string_view word = next();
    Number value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size()) {
      fail("has \"" + std::string(word.substr(0, 32)) + "\" where a number should be");
    }
    return value;
  }

  // A count of entries of `words_each` words; TetGen counts their numbers with int.
  int count(int words_each) {
    const int value = number<int>();
    const auto rest = static_cast<long long>(text_.size() - at_);
    if (value < 0 || 2LL * words_each * value > rest + 1) fail("has a count that its size cannot contain");
    if (value > std::numeric_limits<int>::max() / 8) fail("is too large for TetGen");
    return value;
  }

  Point point() {
    Point p;
    for (double& coordinate : p) {
      coordinate = number<double>();
      if (!std::isfinite(coordinate)) fail("has a coordinate that is not finite");
    }
    return p;
  }

  [[noreturn]] void fail(const std::string& what) const { throw Failure(unreadable, path_ + " " + what); }

 private:
  std::string path_;
  std::string text_;
  std::size_t at_ = 0;
};

void append_point(std::string& text, const Point& point) {
  for (const double coordinate : point) text.append(text_of(coordinate)).append(" ");
}

}  // namespace

Surface read_surface(const std::string& path) {
  Words words(path);
  if (words.next() != "OFF") words.fail("does not begin with OFF");
  Surface surface;
  surface.vertices.resize(static_cast<std::size_t>(words.count(3)));
  surface.triangles.resize(static_cast<std::size_t>(words.count(4)));
  words.number<int>();  // edges
  for (Point& vertex : surface.vertices) vertex = words.point();
  for (auto& triangle : surface.triangles) {
    if (words.number<int>() != 3) words.fail("has a face that is not a triangle");
    for (int& vertex : triangle) {
      vertex = words.number<int>();
      if (vertex < 0 || static_cast<std::size_t>(vertex) >= surface.vertices.size()) {
        words.fail("has vertex number " + std::to_string(vertex) + " out of range");
      }
    }
  }
  if (surface.triangles.empty()) words.fail("has no triangles");
  return surface;
}

std::vector<Point> read_points(const std::string& path) {
  Words words(path);
  std::vector<Point> points(static_cast<std::size_t>(words.count(3)));
  for (Point& point : points) point = words.point();
  return points;
}

std::string text_of(double number) {
  std::array<char, 32> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
  return {digits.data(), end};
}

std::string text_of(const Volume& volume) {
  std::string text =
      "MeshVersionFormatted 2\nDimension 3\nVertices\n" + std::to_string(volume.vertices.size()) + "\n";
  for (const Point& vertex : volume.vertices) {
    append_point(text, vertex);
    text += "0\n";
  }
  text += "Tetrahedra\n" + std::to_string(volume.tetrahedra.size()) + "\n";
  for (const auto& tetrahedron : volume.tetrahedra) {
    for (const int vertex : tetrahedron) text += std::to_string(vertex + 1) + " ";
    text += "0\n";
  }
  text += "End\n";
  return text;
}

std::string text_of(const Surface& surface) {
  std::string text = "OFF\n" + std::to_string(surface.vertices.size()) + " " +
                     std::to_string(surface.triangles.size()) + " 0\n";
  for (const Point& vertex : surface.vertices) {
    append_point(text, vertex);
    text.back() = '\n';
  }
  for (const auto& t : surface.triangles)
    text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
  return text;
}

}  // namespace fascicle::mesher
