#include "tests/bake/fake_bakes.h"

#include <atomic>

namespace fascicle::tests {

bake::BakeResult fake_bake_into(const bake::BakeOptions& options, const scene::Scene& scene,
                                FakeOptions fake) {
  const model::Model model = two_tetrahedra();
  FakeSolver solver(model, fake);
  return bake::bake(scene, model, solver, options);
}

bake::BakeResult bake_until(bake::BakeOptions options, const scene::Scene& scene, std::uint64_t last) {
  std::atomic<bool> interrupted = last == 0;
  options.interrupted = &interrupted;
  FakeOptions fake;
  fake.on_submit = [&](std::uint64_t frame) { interrupted = frame >= last; };
  return fake_bake_into(options, scene, fake);
}

nlohmann::json manifest_in(const std::filesystem::path& folder) {
  return nlohmann::json::parse(read_text(folder / "manifest.json"));
}

testing::AssertionResult contains(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "\"" << part << "\" is missing in: " << text;
}

}  // namespace fascicle::tests
