// Consistent names: a stage has the same name everywhere, and every equation of the paper can be found by its
// number.
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/model/solver.h"
#include "tests/house/source_tree.h"

namespace fascicle::tests {
namespace {

// The equations of the paper that the program implements: the step, shape matching, the weights, the muscles.
// (1) to (3), the fibre field, are not among them yet.
constexpr int first_equation = 4;
constexpr int last_equation = 17;

std::string marked(int equation) {
  return "(" + std::to_string(equation) + ")";
}

// Whether a comment of a source under one of the folders names the equation.
bool names_equation(const std::vector<Source>& sources, const std::vector<std::string>& folders,
                    int equation) {
  for (const Source& source : sources)
    for (const std::string& folder : folders)
      if (source.path.starts_with(folder) &&
          only_comments(source.text).find(marked(equation)) != std::string::npos)
        return true;
  return false;
}

TEST(Names, EveryStageHasItsShaderKernelAndCpuFunction) {
  const std::filesystem::path root(FASCICLE_SOURCE_DIR);
  std::string stages;
  for (const Source& source : read_sources(root))
    if (source.path == "cpu_reference/solver/stages.h" ||
        source.path == "cpu_reference/solver/collide_stages.h" ||
        source.path == "cpu_reference/solver/contact_stages.h")
      stages += without_comments(source.text);
  ASSERT_FALSE(stages.empty());
  for (const model::Stage stage : model::all_stages) {
    const std::string name = model::name_of(stage);
    EXPECT_TRUE(std::filesystem::is_regular_file(root / "shaders" / (name + ".comp"))) << name;
    EXPECT_TRUE(std::filesystem::is_regular_file(root / "shaders/kernel" / (name + ".inc"))) << name;
    EXPECT_NE(stages.find("void " + name + "("), std::string::npos) << name;
  }
}

TEST(Names, EveryEquationIsFoundByItsNumberInTheOracle) {
  const std::vector<Source> sources = read_sources(FASCICLE_SOURCE_DIR);
  for (int equation = first_equation; equation <= last_equation; ++equation)
    EXPECT_TRUE(names_equation(sources, {"cpu_reference/oracle/oracle"}, equation))
        << "no comment of the oracle names equation " << marked(equation);
}

// (7) and (8) are the same sums as (6) and (9), which a kernel cites as a range.
TEST(Names, EveryEquationIsFoundByItsNumberInTheProgram) {
  const std::vector<Source> sources = read_sources(FASCICLE_SOURCE_DIR);
  for (int equation = first_equation; equation <= last_equation; ++equation) {
    if (equation == 7) continue;
    EXPECT_TRUE(names_equation(sources, {"shaders/kernel/", "host/build/", "host/model/"}, equation))
        << "no comment of a kernel or of the builder names equation " << marked(equation);
  }
}

// The control: a number in code is not a citation.
TEST(Names, OnlyCommentsCite) {
  EXPECT_FALSE(names_equation({{"host/build/a.cpp", "int x = f(12);\nconst char* s = \"(12) // (12)\";\n"}},
                              {"host/"}, 12));
  EXPECT_TRUE(names_equation({{"host/build/a.cpp", "int x;  // the weight (12)\n"}}, {"host/"}, 12));
  EXPECT_TRUE(names_equation({{"host/build/a.cpp", "/* the weight\n (12) */\n"}}, {"host/"}, 12));
}

}  // namespace
}  // namespace fascicle::tests
