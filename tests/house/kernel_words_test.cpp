// Words forbidden in kernels and shaders because devices differ in them (docs/architecture.md, exactness).
// The build's check of the SPIR-V is decisive; this test names the line, and also covers the C++ side.
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/house/source_tree.h"

namespace fascicle::tests {
namespace {

struct Rule {
  std::regex pattern;
  std::string why;
};

const std::vector<Rule>& rules() {
  static const std::vector<Rule> table{
      {std::regex(
           R"re(\b(sqrt|inversesqrt|fma|min|max|clamp|mix|dot|cross|length|distance|normalize|sin|cos|tan|asin|acos|atan|)re"
           R"re(sinh|cosh|tanh|exp|exp2|log|log2|pow|abs|sign|floor|ceil|trunc|round|roundEven|fract|mod|step|)re"
           R"re(smoothstep|reflect|refract|transpose|inverse|determinant|outerProduct|matrixCompMult|ldexp|frexp)\s*\()re"),
       "built-in functions differ between devices"},
      // Exchanging a number is allowed: the schedule lists the fields, and gpu/plan_test checks shaders
      // against it.
      {std::regex(R"re(\b(atomic(?!Exchange\b)\w+|subgroup\w+)\s*\()re"),
       "the order of such a sum is the device's"},
      {std::regex(R"re(\b(double|d?mat[234](x[234])?|dvec[234]|float16_t|f16vec[234]|half)\b)re"),
       "kernels are scalar and 32 bits wide"},
      // x + 0.0 and x * 0.0 lose the sign of zero, and compilers may fold them under relaxed rules.
      {std::regex(R"re([+*]\s*0\.0f?(?![0-9])|(^|[^0-9.])0\.0f?\s*[+*])re"),
       "arithmetic with a literal zero"},
  };
  return table;
}

bool is_kernel(const std::string& path) {
  return path.ends_with(".inc");
}
bool is_shader(const std::string& path) {
  return path.ends_with(".comp") || path.ends_with(".glsl");
}

// All violations in a kernel or shader, as "path:line: why: text".
std::vector<std::string> forbidden_words(const Source& source) {
  static const std::regex directive(R"re(^\s*#\s*include\b)re");
  // Integer division is allowed, by a constant that shows the operands are integers.
  static const std::regex whole_division(R"re(/\s*((slice_width|contact_(leaf|branch))\b|[0-9]+u\b))re");
  std::vector<std::string> found;
  const std::vector<std::string> lines = lines_of(without_comments(source.text));
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (std::regex_search(lines[k], directive)) continue;
    const auto report = [&](const std::string& why) {
      found.push_back(source.path + ":" + std::to_string(k + 1) + ": " + why + ": " + lines[k]);
    };
    for (const Rule& rule : rules())
      if (std::regex_search(lines[k], rule.pattern)) report(rule.why);
    const std::string rest =
        is_kernel(source.path) ? lines[k] : std::regex_replace(lines[k], whole_division, "");
    if (rest.find('/') != std::string::npos) report("division is not exact on every device");
  }
  return found;
}

TEST(KernelWords, KernelsAndShadersUseExactArithmeticOnly) {
  std::size_t seen = 0;  // shaders/ only: tests hold planted violations for the SPIR-V check
  for (const Source& source : read_sources(FASCICLE_SOURCE_DIR)) {
    if (!source.path.starts_with("shaders/") || (!is_kernel(source.path) && !is_shader(source.path)))
      continue;
    ++seen;
    for (const std::string& breach : forbidden_words(source)) ADD_FAILURE() << breach;
  }
  EXPECT_GE(seen, 12u) << "a kernel and a shader for each of the six stages";
}

// The controls: each forbidden word is found once planted, and its harmless look-alike is not.
TEST(KernelWords, PlantedBreachesAreSeen) {
  for (const char* line : {"Real r = sqrt(x);",
                           "r = fma (a, b, c);",
                           "r = min(a, b);",
                           "r = max(a, b);",
                           "r = clamp(a, b, c);",
                           "r = mix(a, b, c);",
                           "r = dot(a, b);",
                           "v = cross(a, b);",
                           "r = length(v);",
                           "v = normalize(v);",
                           "r = sin(a);",
                           "r = cos(a);",
                           "r = exp(a);",
                           "r = pow(a, b);",
                           "r = a / b;",
                           "r /= b;",
                           "r = a / 3.0f;",
                           "mat3 m;",
                           "double d;",
                           "r = x + 0.0f;",
                           "r = 0.0 * x;",
                           "atomicAdd(total, 1u);",
                           "atomicExchangeAdd(a, b);",
                           "r = subgroupAdd(x);"}) {
    EXPECT_FALSE(forbidden_words({"shaders/kernel/bad.inc", std::string(line) + "\n"}).empty()) << line;
    EXPECT_FALSE(forbidden_words({"shaders/bad.comp", std::string(line) + "\n"}).empty()) << line;
  }
  for (const char* line :
       {"// r = sqrt(x) / 2", "/* a / b */", "r = reciprocal_sqrt(x);",
        "for (int step = 0; step < 6; ++step)", "#include \"shaders/kernel/scalar.inc\"", "r = a + 0.05f;",
        "sum.x = 0.0f;", "r = 10.0f * x;", "next[p] = atomicExchange(first[t], p);"})
    EXPECT_TRUE(forbidden_words({"shaders/kernel/good.inc", std::string(line) + "\n"}).empty()) << line;
  EXPECT_TRUE(forbidden_words({"shaders/good.comp", "uint s = i / slice_width + j / 4u;\n"}).empty());
  EXPECT_FALSE(forbidden_words({"shaders/kernel/bad.inc", "uint s = i / 4u;\n"}).empty());
}

}  // namespace
}  // namespace fascicle::tests
