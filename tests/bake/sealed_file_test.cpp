// Files with a checksum at their end are read only if it is right, and take no memory before.
#include "host/bake/sealed_file.h"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "host/bake/bake.h"
#include "host/bake/checkpoint.h"
#include "host/bake/model_file.h"
#include "tests/bake/fake_bakes.h"
#include "tests/bake/fake_solver.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

std::string sealed_bytes_of(const fs::path& path, std::string_view magic) {
  return bake::read_sealed(base::File(path, base::FileMode::read), magic);
}

TEST(SealedFile, IsReadWholeOrNotAtAll) {
  const TemporaryFolder folder;
  const fs::path path = folder / "model.fascicle";
  // Longer than one of the pieces that the checksum is computed from.
  model::Model model = two_tetrahedra();
  model.layers[0].name = std::string(3'000'000, 'x');
  const std::string good = bake::encode_model(model);
  write_text(path, good);
  EXPECT_EQ(sealed_bytes_of(path, "FASCMODL"), good);
  EXPECT_EQ(sealed_bytes_of(path, "FASCCKPT"), "FASCMODL");
  for (const std::size_t at : {std::size_t{8}, good.size() / 2, good.size() - 9, good.size() - 1}) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 1);
    write_text(path, bad);
    EXPECT_EQ(sealed_bytes_of(path, "FASCMODL"), "FASCMODL") << at;
  }
  for (const std::size_t length : {std::size_t{0}, std::size_t{7}, std::size_t{8}, good.size() - 1}) {
    write_text(path, good.substr(0, length));
    EXPECT_EQ(sealed_bytes_of(path, "FASCMODL"), length < 8 ? "" : "FASCMODL") << length;
  }
}

// Sparse files take no space, whatever their length; the longer one would fit into no memory.
TEST(SealedFile, TakesNoMemoryIfItIsMuchTooLong) {
  const TemporaryFolder folder;
  const fs::path model = folder / "model.fascicle", checkpoint = folder / "checkpoint";
  write_text(model, bake::encode_model(two_tetrahedra()));
  write_text(checkpoint, bake::checkpoint_text({.identity = {{"scene", "a"}}, .state = {}}));
  EXPECT_NO_THROW(bake::read_model_file(model, {}));
  EXPECT_NO_THROW(bake::read_checkpoint(checkpoint));
  for (const int shift : {28, 42}) {
    fs::resize_file(model, std::uint64_t{1} << shift);
    fs::resize_file(checkpoint, std::uint64_t{1} << shift);
    EXPECT_TRUE(contains(message_of<bake::BakeError>([&] { bake::read_model_file(model, {}); }),
                         "model.fascicle: the model is damaged; bake again"));
    EXPECT_TRUE(contains(message_of<bake::BakeError>([&] { bake::read_checkpoint(checkpoint); }),
                         "checkpoint: the checkpoint is damaged; start again with --overwrite"));
  }
}

}  // namespace
}  // namespace fascicle::tests
