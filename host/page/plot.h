// Plots as SVG inside a page, in its colours.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/page/writer.h"

namespace fascicle::page {

struct Series {
  std::string name;
  std::vector<double> values;  // one an x; what is no finite number is a gap
};

struct Plot {
  std::string title;            // for those who cannot see it, and above it
  std::string x_name, y_name;   // with their units
  std::vector<double> x;        // ascending
  std::vector<Series> series;   // at most as many as there are colours are told apart by them
  std::optional<double> limit;  // a line across
  bool from_zero = true;        // whether the axis holds 0
};

// A figure with title, plot and legend. Nothing where no series has a finite value.
void plot(Writer& page, const Plot& plot);

struct Bar {
  std::string name, value;  // as shown
  double length = 0.0;      // at least 0
};
// Lengths beside each other; `limit` is a line at that length.
void bars(Writer& page, const std::string& title, const std::vector<Bar>& bars,
          std::optional<double> limit = std::nullopt);

// Round numbers that cover [low, high] in about `count` steps. Both finite, low <= high.
std::vector<double> ticks(double low, double high, unsigned count);

}  // namespace fascicle::page
