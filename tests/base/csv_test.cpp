#include "host/base/csv.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/base/errors.h"

namespace fascicle::tests {
namespace {

using base::csv_field;
using base::csv_fields;

TEST(Csv, AFieldIsReadBack) {
  std::string line;
  const std::vector<std::string> texts{"", "plain", "a,b", "say \"so\"", "\"", ",", "\xc3\xa4"};
  for (const std::string& text : texts) line += (line.empty() ? "x," : ",") + csv_field(text);
  std::vector<std::string> read = csv_fields(line);
  read.erase(read.begin());
  EXPECT_EQ(read, texts);
}

TEST(Csv, AFieldStaysInItsLine) {
  EXPECT_EQ(csv_field("a\nb\r\"c\x1b"), "\"a\\nb\\r\"\"c\\x1b\"");
  EXPECT_EQ(csv_field("\xff"), "\\xff");
}

// Spreadsheets would compute such a field.
TEST(Csv, AFieldIsNoFormula) {
  EXPECT_EQ(csv_field("=1+1"), "'=1+1");
  EXPECT_EQ(csv_field("+1"), "'+1");
  EXPECT_EQ(csv_field("-a"), "'-a");
  EXPECT_EQ(csv_field("@a"), "'@a");
  EXPECT_EQ(csv_field("a=1"), "a=1");
  for (const char* text : {"=1+1", "-a", "'", "'a", "a"}) EXPECT_EQ(base::csv_text(csv_field(text)), text);
}

TEST(Csv, ColumnsAreCountedBeforeTheyAreRead) {
  const auto refusal_of = [](const std::string& line) -> std::string {
    try {
      base::csv_columns(line, "a/metrics.csv");
    } catch (const base::BakeError& error) {
      return error.what();
    }
    return "read";
  };
  EXPECT_EQ(base::csv_columns("frame,\"a,\"\"b\",c\r", "x"),
            (std::vector<std::string>{"frame", "a,\"b", "c"}));
  EXPECT_EQ(refusal_of(std::string(4095, ',')), "read");
  EXPECT_EQ(refusal_of('"' + std::string(5000, ',') + '"'), "read");
  EXPECT_EQ(refusal_of(std::string(4096, ',')),
            "a/metrics.csv: has 4097 columns, the most is 4,096; bake again");
  // As fields they would take 3.2 GB.
  EXPECT_EQ(refusal_of(std::string(100'000'000, ',')),
            "a/metrics.csv: has 100000001 columns, the most is 4,096; bake again");
}

TEST(Csv, FieldsBeyondTheMostColumnsAreLeftOut) {
  EXPECT_EQ(csv_fields(std::string(4095, ',')).size(), 4096u);
  EXPECT_EQ(csv_fields(std::string(100'000'000, ',')).size(), 4096u);
}

}  // namespace
}  // namespace fascicle::tests
