// Pages are well-formed, escape their input, and are legible: contrast by WCAG's own formula.
#include "host/page/page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <pugixml.hpp>

#include "host/page/plot.h"
#include "host/page/style.h"
#include "host/page/writer.h"

namespace fascicle::tests {
namespace {

using page::Writer;

pugi::xml_document parsed(const std::string& text) {
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_string(text.c_str());
  EXPECT_TRUE(result) << result.description() << " at "
                      << text.substr(static_cast<std::size_t>(result.offset), 80);
  return document;
}

const std::string hostile = "<script>a()</script> & \"q\" 'r' ]]> -->\x01\x1b[31m\xe2\x80\xae\xff {{x}}";

TEST(Writer, WhatGoesInComesOutAsTextAndNothingElse) {
  Writer writer;
  writer.start("p", {{"title", hostile}}).text(hostile).close();
  const std::string text = std::move(writer).finish();
  EXPECT_EQ(text.find("<script"), std::string::npos);
  const pugi::xml_document document = parsed(text);
  const pugi::xml_node paragraph = document.child("p");
  EXPECT_EQ(std::distance(paragraph.begin(), paragraph.end()), 1);
  // Unprintable characters are written as escapes; the rest is unchanged.
  const std::string shown = "<script>a()</script> & \"q\" 'r' ]]> -->\\x01\\x1b[31m\\u202e\\xff {{x}}";
  EXPECT_EQ(paragraph.child_value(), shown);
  EXPECT_EQ(std::string(paragraph.attribute("title").value()), shown);
}

std::string whole_page() {
  Writer page = page::begin(hostile, hostile, "complete", page::Tone::good);
  page::contents(page, {{"one", hostile}});
  page::facts(page, {{hostile, hostile, page::Tone::bad, hostile}});
  page::open_section(page, "one", hostile);
  page::rows(page, {{hostile, hostile}}, hostile);
  page::table(page, {{hostile, "b"}, {"c", hostile}, {"d", "e"}}, 1, hostile);
  page::swatches(page, {{hostile, "#102030"}});
  page::picture(page, "not a picture", hostile, 4, 3);
  page::plot(page, {.title = hostile,
                    .x_name = hostile,
                    .y_name = hostile,
                    .x = {0, 1},
                    .series = {{hostile, {1, 2}}, {"b", {3, 4}}},
                    .limit = 1.5,
                    .from_zero = true});
  page::bars(page, hostile, {{hostile, hostile, 1.0}, {"b", "2", 2.0}}, 1.5);
  page.close();
  return page::finish(std::move(page), hostile);
}

TEST(Page, IsWellFormedAndHasNothingThatRuns) {
  const std::string text = whole_page();
  EXPECT_TRUE(text.starts_with("<!DOCTYPE html>\n"));
  const pugi::xml_document document = parsed(text);
  EXPECT_TRUE(document.select_nodes("//script | //iframe | //object | //link | //form").empty());
  for (const pugi::xpath_node& node : document.select_nodes("//@*")) {
    const std::string name = node.attribute().name(), value = node.attribute().value();
    EXPECT_FALSE(name.starts_with("on")) << name;
    EXPECT_TRUE(name != "src" || value.starts_with("data:image/png;base64,")) << value;
    EXPECT_TRUE(name != "href" || value.starts_with("#")) << value;
  }
  const std::string policy = document.select_node("//meta[@http-equiv]").node().attribute("content").value();
  EXPECT_TRUE(policy.starts_with("default-src 'none';")) << policy;
  EXPECT_EQ(policy.find("script"), std::string::npos);
  // Output of coreutils' base64 for these 13 bytes.
  EXPECT_NE(text.find("bm90IGEgcGljdHVyZQ=="), std::string::npos);
}

TEST(Page, EveryIdIsOneAndEveryLinkLeadsToIt) {
  const pugi::xml_document document = parsed(whole_page());
  std::map<std::string, int> ids;
  for (const pugi::xpath_node& node : document.select_nodes("//@id")) ++ids[node.attribute().value()];
  for (const auto& [id, count] : ids) EXPECT_EQ(count, 1) << id;
  for (const pugi::xpath_node& node : document.select_nodes("//@href"))
    EXPECT_EQ(ids.count(std::string(node.attribute().value()).substr(1)), 1u);
  for (const pugi::xpath_node& node : document.select_nodes("//@aria-labelledby"))
    EXPECT_EQ(ids.count(node.attribute().value()), 1u);
  EXPECT_TRUE(document.select_nodes("//img[not(@alt)]").empty());
  EXPECT_TRUE(document.select_nodes("//svg[not(@aria-label) and not(@aria-hidden)]").empty());
}

// WCAG 2.1: relative luminance of sRGB, and contrast (L1 + 0.05) / (L2 + 0.05).
double luminance(const std::string& hex) {
  double sum = 0.0;
  const double shares[]{0.2126, 0.7152, 0.0722};
  for (std::size_t c = 0; c < 3; ++c) {
    const double v = std::stoi(hex.substr(1 + 2 * c, 2), nullptr, 16) / 255.0;
    sum += shares[c] * (v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
  }
  return sum;
}
double contrast(const std::string& a, const std::string& b) {
  const double x = luminance(a), y = luminance(b);
  return (std::max(x, y) + 0.05) / (std::min(x, y) + 0.05);
}

// The first set of colours is the light scheme, the second the dark one.
std::vector<std::map<std::string, std::string>> schemes() {
  static const std::regex colour("--([a-z0-9]+): (#[0-9a-f]{6})");
  const std::string style = page::page_style;
  std::vector<std::map<std::string, std::string>> found;
  for (std::sregex_iterator at(style.begin(), style.end(), colour), end; at != end; ++at) {
    if (at->str(1) == "paper") found.emplace_back();
    found.back()[at->str(1)] = at->str(2);
  }
  return found;
}

TEST(Style, ColoursCanBeReadInBothSchemes) {
  EXPECT_NEAR(contrast("#000000", "#ffffff"), 21.0, 1e-9);  // the formula's maximum
  EXPECT_LT(contrast("#888888", "#ffffff"), 4.5);           // the control: too faint
  const auto all = schemes();
  ASSERT_EQ(all.size(), 2u);
  for (const auto& colours : all) {
    ASSERT_EQ(colours.size(), 15u);
    for (const char* ground : {"paper", "panel"}) {
      for (const char* text : {"ink", "soft", "accent", "good", "warning", "bad"})
        EXPECT_GE(contrast(colours.at(text), colours.at(ground)), 4.5) << text << " on " << ground;
      for (const char* line : {"s0", "s1", "s2", "s3", "s4", "s5"})
        EXPECT_GE(contrast(colours.at(line), colours.at(ground)), 3.0) << line << " on " << ground;
    }
  }
}

TEST(Plot, TicksAreRoundAndCoverTheRange) {
  EXPECT_EQ(page::ticks(0.0, 10.0, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(page::ticks(3.0, 3.0, 5), std::vector<double>{3.0});
  for (const double size : {1e-9, 0.37, 1.0, 42.0, 7.7e8}) {
    const std::vector<double> found = page::ticks(-0.3 * size, size, 5);
    EXPECT_GE(found.size(), 3u) << size;
    EXPECT_LE(found.size(), 8u) << size;
    EXPECT_GE(found.front(), -0.3 * size * (1.0 + 1e-9));
    EXPECT_LE(found.back(), size * (1.0 + 1e-9));
  }
}

pugi::xml_document drawn(const page::Plot& plot) {
  Writer writer;
  writer.start("div");
  page::plot(writer, plot);
  writer.close();
  return parsed(std::move(writer).finish());
}

// The highest value is drawn highest, and a value twice as far from 0 twice as far from the axis.
TEST(Plot, PutsValuesWhereTheirAxisSays) {
  const pugi::xml_document document = drawn({.title = "t",
                                             .x_name = "x",
                                             .y_name = "y",
                                             .x = {0, 1, 2},
                                             .series = {{"a", {0, 2, 1}}},
                                             .limit = {},
                                             .from_zero = true});
  const std::string path =
      document.select_node("//path[contains(@class,'line')]").node().attribute("d").value();
  double x[3], y[3];
  ASSERT_EQ(std::sscanf(path.c_str(), "M%lf %lfL%lf %lfL%lf %lf", &x[0], &y[0], &x[1], &y[1], &x[2], &y[2]),
            6)
      << path;
  // Coordinates have two decimals.
  EXPECT_NEAR(x[1] - x[0], x[2] - x[1], 0.011);
  EXPECT_NEAR(y[0] - y[1], 2.0 * (y[0] - y[2]), 0.021);
  EXPECT_GT(y[0], y[1]);
}

TEST(Plot, GapsNothingAndLongSeries) {
  const double none = std::numeric_limits<double>::quiet_NaN(),
               infinite = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(drawn({.title = "t",
                     .x_name = "",
                     .y_name = "",
                     .x = {0, 1},
                     .series = {{"a", {none, infinite}}},
                     .limit = {},
                     .from_zero = true})
                  .select_nodes("//svg")
                  .empty());
  EXPECT_TRUE(
      drawn({.title = "t", .x_name = "", .y_name = "", .x = {}, .series = {}, .limit = {}, .from_zero = true})
          .select_nodes("//svg")
          .empty());
  const pugi::xml_document gap = drawn({.title = "t",
                                        .x_name = "",
                                        .y_name = "",
                                        .x = {0, 1, 2, 3, 4},
                                        .series = {{"a", {1, 2, none, 3, 4}}},
                                        .limit = {},
                                        .from_zero = true});
  const std::string broken = gap.select_node("//path[contains(@class,'line')]").node().attribute("d").value();
  EXPECT_EQ(std::count(broken.begin(), broken.end(), 'M'), 2) << broken;
  // An outlier among many values is still the highest drawn point.
  std::vector<double> x, spike;
  for (int k = 0; k < 100000; ++k) {
    x.push_back(k);
    spike.push_back(k == 77777 ? 5.0 : 1.0);
  }
  const pugi::xml_document many = drawn({.title = "t",
                                         .x_name = "",
                                         .y_name = "",
                                         .x = x,
                                         .series = {{"a", spike}},
                                         .limit = {},
                                         .from_zero = true});
  const std::string path = many.select_node("//path[contains(@class,'line')]").node().attribute("d").value();
  EXPECT_LT(path.size(), 40000u);
  EXPECT_EQ(path.find("nan"), std::string::npos);
  static const std::regex place("[ML][0-9.]+ ([0-9.]+)");
  double highest = 1e9, lowest = 0.0;
  for (std::sregex_iterator at(path.begin(), path.end(), place), end; at != end; ++at) {
    highest = std::min(highest, std::stod(at->str(1)));
    lowest = std::max(lowest, std::stod(at->str(1)));
  }
  EXPECT_GT(lowest - highest, 100.0);
}

}  // namespace
}  // namespace fascicle::tests
