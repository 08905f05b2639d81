// SVG plots embedded in a page, in its colours.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/page/writer.h"

namespace fascicle::page {

struct Series {
  std::string name;
  std::vector<double> values;  // one per x; non-finite values are gaps
};

struct Plot {
  std::string title;            // shown above the plot, and read by screen readers
  std::string x_name, y_name;   // with units
  std::vector<double> x;        // ascending
  std::vector<Series> series;   // colours repeat if there are more series than colours
  std::optional<double> limit;  // a horizontal line
  bool from_zero = true;        // whether the axis includes 0
};

// A figure with title, plot and legend. Writes nothing if no series has a finite value.
void plot(Writer& page, const Plot& plot);

struct Bar {
  std::string name, value;  // value: as shown
  double length = 0.0;      // not negative
};
// A bar chart; `limit` is a line at that length.
void bars(Writer& page, const std::string& title, const std::vector<Bar>& bars,
          std::optional<double> limit = std::nullopt);

// Round numbers that cover [low, high] in about `count` steps. Both must be finite, and low <= high.
std::vector<double> ticks(double low, double high, unsigned count);

}  // namespace fascicle::page
