#include "host/page/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <set>

namespace fascicle::page {
namespace {

// Of the drawing, in SVG user units.
constexpr double width = 560.0, height = 230.0, left = 64.0, right = 12.0, top = 12.0, bottom = 44.0;
constexpr std::size_t colours = 6;
// More points than this add no visible detail to a line.
constexpr std::size_t most_columns = 600;

std::string number(double value, const char* format) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}
std::string place(double value) {
  return number(value, "%.2f");
}

constexpr double farthest = 1e100;

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void include(double value) {
    if (!std::isfinite(value)) return;
    // Their difference must be finite, too.
    value = std::clamp(value, -farthest, farthest);
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool is_empty() const { return !(low <= high); }
};

// Maps values to coordinates.
struct Axis {
  double low = 0.0, high = 1.0, begin = 0.0, end = 1.0;
  double at(double value) const { return begin + (value - low) / (high - low) * (end - begin); }
};

Axis axis_of(const Range& range, double begin, double end) {
  Axis axis{range.low, range.high, begin, end};
  if (!(axis.high > axis.low)) {
    const double around = std::max(std::abs(axis.low), 1.0) * 0.5;
    axis.low -= around;
    axis.high += around;
  }
  return axis;
}

// Keeps the minimum and maximum of each column, so that no peak is lost.
std::vector<std::pair<double, double>> thinned(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t count = std::min(x.size(), y.size());
  std::vector<std::pair<double, double>> points;
  if (count <= 2 * most_columns) {
    for (std::size_t k = 0; k < count; ++k) points.emplace_back(x[k], y[k]);
    return points;
  }
  for (std::size_t c = 0; c < most_columns; ++c) {
    const std::size_t begin = c * count / most_columns, end = (c + 1) * count / most_columns;
    std::optional<std::size_t> least, most, gap;
    for (std::size_t k = begin; k < end; ++k) {
      if (!std::isfinite(y[k])) {
        gap = k;
        continue;
      }
      if (!least || y[k] < y[*least]) least = k;
      if (!most || y[k] > y[*most]) most = k;
    }
    // Keep a gap as a gap, but also the extremes next to it.
    std::set<std::size_t> kept;
    for (const std::optional<std::size_t>& k : {least, most, gap})
      if (k) kept.insert(*k);
    for (const std::size_t k : kept) points.emplace_back(x[k], y[k]);
  }
  return points;
}

std::string path_of(const std::vector<std::pair<double, double>>& points, const Axis& across,
                    const Axis& up) {
  std::string path;
  bool is_drawing = false;
  for (const auto& [x, y] : points) {
    if (!std::isfinite(x) || !std::isfinite(y)) {
      is_drawing = false;
      continue;
    }
    path += (is_drawing ? "L" : "M") + place(across.at(x)) + " " + place(up.at(y));
    is_drawing = true;
  }
  return path;
}

void draw_axes(Writer& page, const Plot& plot, const Axis& across, const Axis& up) {
  for (const double tick : ticks(up.low, up.high, 5)) {
    const std::string y = place(up.at(tick));
    page.empty("line",
               {{"class", "grid"}, {"x1", place(left)}, {"x2", place(width - right)}, {"y1", y}, {"y2", y}});
    page.element("text", number(tick, "%.6g"),
                 {{"class", "end"}, {"x", place(left - 6.0)}, {"y", place(up.at(tick) + 4.0)}});
  }
  for (const double tick : ticks(across.low, across.high, 8)) {
    const std::string x = place(across.at(tick));
    page.empty("line",
               {{"class", "grid"}, {"x1", x}, {"x2", x}, {"y1", place(top)}, {"y2", place(height - bottom)}});
    page.element("text", number(tick, "%.6g"),
                 {{"class", "middle"}, {"x", x}, {"y", place(height - bottom + 16.0)}});
  }
  page.element("text", plot.x_name,
               {{"class", "middle"}, {"x", place((left + width - right) / 2)}, {"y", place(height - 8.0)}});
  const std::string turn = "translate(14 " + place((top + height - bottom) / 2) + ") rotate(-90)";
  page.element("text", plot.y_name, {{"class", "middle"}, {"transform", turn}});
}

std::string series_class(std::size_t k) {
  return "line s" + std::to_string(k % colours);
}

void draw_legend(Writer& page, const std::vector<std::string>& names) {
  page.start("ul", {{"class", "legend"}});
  for (std::size_t k = 0; k < names.size(); ++k) {
    page.start("li").start(
        "svg", {{"viewBox", "0 0 24 8"}, {"width", "24"}, {"height", "8"}, {"aria-hidden", "true"}});
    page.empty("path", {{"class", series_class(k)}, {"d", "M0 4L24 4"}}).close().text(names[k]).close();
  }
  page.close();
}

}  // namespace

std::vector<double> ticks(double low, double high, unsigned count) {
  if (!(high > low)) return {low};
  const double wanted = (high - low) / count, power = std::pow(10.0, std::floor(std::log10(wanted)));
  double step = 10.0 * power;
  for (const double one : {1.0, 2.0, 2.5, 5.0})
    if (one * power >= wanted) {
      step = one * power;
      break;
    }
  std::vector<double> found;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step && found.size() < 100;
       k += 1.0)
    found.push_back(k == 0.0 ? 0.0 : k * step);
  return found;
}

void plot(Writer& page, const Plot& plot) {
  Range across, up;
  std::vector<std::string> names;
  for (const double x : plot.x) across.include(x);
  for (const Series& series : plot.series)
    for (const double y : series.values) up.include(y);
  if (across.is_empty() || up.is_empty()) return;
  if (plot.from_zero) up.include(0.0);
  if (plot.limit) up.include(*plot.limit);
  // Leave room above the highest point.
  const double room = 0.06 * (up.high - up.low);
  up.high += room;
  if (!plot.from_zero) up.low -= room;
  const Axis x_axis = axis_of(across, left, width - right), y_axis = axis_of(up, height - bottom, top);

  page.start("figure", {{"class", "plot"}}).element("figcaption", plot.title);
  page.start("svg", {{"viewBox", "0 0 " + place(width) + " " + place(height)},
                     {"role", "img"},
                     {"aria-label", plot.title}});
  draw_axes(page, plot, x_axis, y_axis);
  if (plot.limit) {
    const std::string y = place(y_axis.at(*plot.limit));
    page.empty("line",
               {{"class", "limit"}, {"x1", place(left)}, {"x2", place(width - right)}, {"y1", y}, {"y2", y}});
    page.element("text", "limit",
                 {{"class", "end limit-name"},
                  {"x", place(width - right - 4.0)},
                  {"y", place(y_axis.at(*plot.limit) - 5.0)}});
  }
  for (std::size_t k = 0; k < plot.series.size(); ++k) {
    names.push_back(plot.series[k].name);
    page.empty("path", {{"class", series_class(k)},
                        {"d", path_of(thinned(plot.x, plot.series[k].values), x_axis, y_axis)}});
  }
  page.close();
  if (names.size() > 1) draw_legend(page, names);
  page.close();
}

void bars(Writer& page, const std::string& title, const std::vector<Bar>& bars, std::optional<double> limit) {
  constexpr double row = 30.0, name_width = 150.0, value_width = 110.0;
  double longest = limit.value_or(0.0);
  for (const Bar& bar : bars)
    if (std::isfinite(bar.length)) longest = std::max(longest, bar.length);
  const double all = row * static_cast<double>(bars.size());
  const Axis across{0.0, longest > 0.0 ? longest : 1.0, name_width, width - value_width};
  page.start("figure", {{"class", "plot"}}).element("figcaption", title);
  page.start(
      "svg",
      {{"viewBox", "0 0 " + place(width) + " " + place(all + 4.0)}, {"role", "img"}, {"aria-label", title}});
  const auto length_of = [&](const Bar& bar) {
    return across.at(std::isfinite(bar.length) ? std::clamp(bar.length, 0.0, across.high) : across.high);
  };
  for (std::size_t k = 0; k < bars.size(); ++k) {
    const double y = row * static_cast<double>(k) + 4.0;
    page.element("text", bars[k].name,
                 {{"class", "end"}, {"x", place(name_width - 8.0)}, {"y", place(y + 16.0)}});
    page.empty("rect", {{"class", "bar"},
                        {"x", place(name_width)},
                        {"y", place(y)},
                        {"width", place(std::max(length_of(bars[k]) - name_width, 1.0))},
                        {"height", place(row - 8.0)}});
  }
  if (limit) {
    const std::string x = place(across.at(*limit));
    page.empty("line", {{"class", "limit"}, {"x1", x}, {"x2", x}, {"y1", "0"}, {"y2", place(all)}});
  }
  // Drawn last, because the limit line may cross the labels.
  for (std::size_t k = 0; k < bars.size(); ++k)
    page.element("text", bars[k].value,
                 {{"class", "value"},
                  {"x", place(length_of(bars[k]) + 8.0)},
                  {"y", place(row * static_cast<double>(k) + 20.0)}});
  page.close().close();
}

}  // namespace fascicle::page
