// Feeds the readers seeds and earlier finds of the fuzzer, also damaged and grown by fixed rules: a short
// form of `./do fuzz` that any compiler builds.
#include <algorithm>
#include <array>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <new>
#include <numeric>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "tests/fuzz/counted_memory.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/strange_numbers.h"

namespace fascicle::tests {
namespace {

using fuzz::Reader;
using fuzz::Seed;

// Files that the fuzzer found, in one folder per reader; their names say what was wrong.
std::vector<Seed> kept() {
  std::vector<Seed> all;
  const std::filesystem::path folder = std::filesystem::path(FASCICLE_SOURCE_DIR) / "tests/fuzz/kept";
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    all.push_back({entry.path().parent_path().filename().string(), entry.path().filename().string(), bytes});
  }
  return all;
}

std::vector<Seed> corpus() {
  std::vector<Seed> all = fuzz::seeds();
  for (Seed& seed : kept()) all.push_back(std::move(seed));
  return all;
}

std::string damaged(std::string bytes, std::mt19937_64& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  for (std::size_t times = 1 + below(3); times > 0 && !bytes.empty(); --times) {
    const std::size_t at = below(bytes.size());
    const std::size_t length = std::min(1 + below(16), bytes.size() - at);
    switch (below(6)) {
      case 0:
        bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 2:
        bytes.erase(at, length);
        break;
      case 3:
        bytes.insert(below(bytes.size()), bytes.substr(at, length));
        break;
      case 4:
        bytes.replace(at, length, length, below(2) == 0 ? '\xff' : '9');
        break;
      default:
        bytes.resize(at);
    }
  }
  return bytes;
}

// The undocumented exception that leaves the reader; empty if there is none.
std::string flaw_of(bool (*read)(std::string_view), std::string_view bytes) {
  try {
    (void)read(bytes);
    return "";
  } catch (const std::exception& error) {
    return error.what();
  }
}

std::string first_flaw(bool (*read)(std::string_view), const std::string& from, int rounds,
                       std::mt19937_64& random) {
  for (int round = 0; round < rounds; ++round) {
    const std::string bytes = damaged(from, random);
    if (const std::string flaw = flaw_of(read, bytes); !flaw.empty()) return flaw;
  }
  return "";
}

void for_each(const std::vector<Seed>& files, const std::function<void(const Reader&, const Seed&)>& visit) {
  for (const Reader& reader : fuzz::readers())
    for (const Seed& seed : files)
      if (seed.reader == reader.name) visit(reader, seed);
}

TEST(Readers, TakeTheirSeeds) {
  std::map<std::string, int> count;
  for_each(fuzz::seeds(), [&](const Reader& reader, const Seed& seed) {
    ++count[reader.name];
    EXPECT_EQ(flaw_of(reader.read, seed.bytes), "") << seed.reader << '/' << seed.name;
    EXPECT_TRUE(reader.read(seed.bytes)) << seed.reader << '/' << seed.name;
  });
  EXPECT_EQ(count.size(), fuzz::readers().size()) << "a reader without a seed";
}

TEST(Readers, AreNotHarmedAgain) {
  // These are valid; all others are refused.
  const std::set<std::string> valid{"gltf/image-of-no-view.gltf", "gltf/texture-coordinates-of-a-text.gltf",
                                    "jobs/long-scene-name"};
  for_each(kept(), [&](const Reader& reader, const Seed& seed) {
    EXPECT_EQ(flaw_of(reader.read, seed.bytes), "") << seed.reader << '/' << seed.name;
    const std::string name = seed.reader + '/' + seed.name;
    EXPECT_EQ(reader.read(seed.bytes), valid.contains(name)) << name;
  });
  for (const Seed& seed : kept()) {
    const auto all = fuzz::readers();
    EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const Reader& r) { return r.name == seed.reader; }))
        << "unknown reader " << seed.reader;
  }
}

TEST(Readers, TakeOrRefuseDamagedFiles) {
  std::mt19937_64 random(20170522);
  for_each(corpus(), [&](const Reader& reader, const Seed& seed) {
    EXPECT_EQ(first_flaw(reader.read, seed.bytes, 100, random), "") << seed.reader << '/' << seed.name;
  });
}

// Replaces each number by each strange one, or only some of them by chance if there are more than `most`
// ways.
std::string first_flaw_by_a_number(bool (*read)(std::string_view), const std::string& from, std::size_t most,
                                   std::mt19937_64& random) {
  const std::vector<fuzz::NumberPlace> places = fuzz::numbers_in(from);
  const std::size_t ways = places.size() * fuzz::strange_numbers.size();
  for (const fuzz::NumberPlace& place : places)
    for (const std::string_view number : fuzz::strange_numbers) {
      if (random() % ways >= most) continue;
      if (const std::string flaw = flaw_of(read, fuzz::with_number(from, place, number)); !flaw.empty())
        return flaw + " by " + std::string(number) + " at byte " + std::to_string(place.begin);
    }
  return "";
}

// `./do fuzz` replaces them all.
TEST(Readers, TakeOrRefuseStrangeNumbers) {
  std::mt19937_64 random(20170524);
  for_each(corpus(), [&](const Reader& reader, const Seed& seed) {
    EXPECT_EQ(first_flaw_by_a_number(reader.read, seed.bytes, 300, random), "")
        << seed.reader << '/' << seed.name;
  });
}

TEST(StrangeNumbers, ReplaceEachNumberOfAText) {
  const std::string text = R"({"a1": -2.5e-3, "b": [7, 12]})";
  const std::vector<fuzz::NumberPlace> places = fuzz::numbers_in(text);
  ASSERT_EQ(places.size(), 3U);
  EXPECT_EQ(fuzz::with_number(text, places[0], "1e300"), R"({"a1": 1e300, "b": [7, 12]})");
  EXPECT_EQ(fuzz::with_number(text, places[1], "-1"), R"({"a1": -2.5e-3, "b": [-1, 12]})");
  EXPECT_EQ(fuzz::with_number(text, places[2], "null"), R"({"a1": -2.5e-3, "b": [7, null]})");
  EXPECT_TRUE(fuzz::numbers_in("-").empty());
  EXPECT_TRUE(fuzz::numbers_in("").empty());
}

// Repeats a slice of the file up to a mebibyte, to expose time or memory that is quadratic in the file size.
// The bounds are those of docs/fuzzing.md, here for memory from `new` only.
TEST(Readers, TakeOrRefuseGrownFilesInBounds) {
  constexpr std::size_t most_bytes = std::size_t{1} << 20, most_memory = std::size_t{512} << 20;
  std::mt19937_64 random(20170523);
  for_each(corpus(), [&](const Reader& reader, const Seed& seed) {
    for (int round = 0; round < 2; ++round) {
      std::string bytes = seed.bytes;
      if (bytes.empty() || bytes.size() >= most_bytes) continue;
      const std::size_t at = random() % bytes.size();
      const std::string slice = bytes.substr(at, 1 + random() % 40);
      std::string grown = bytes.substr(0, at);
      while (grown.size() + slice.size() + bytes.size() - at < most_bytes) grown += slice;
      grown += bytes.substr(at);
      fuzz::mark_held();
      const std::clock_t begin = std::clock();
      EXPECT_EQ(flaw_of(reader.read, grown), "") << seed.reader << '/' << seed.name;
      // CPU time, so that other programs do not count.
      EXPECT_LT((std::clock() - begin) / CLOCKS_PER_SEC, 10)
          << seed.reader << '/' << seed.name << " with " << slice << " again and again";
      EXPECT_LT(fuzz::most_held_since_mark(), most_memory) << seed.reader << '/' << seed.name;
    }
  });
}

// The control: a reader with an undocumented exception is detected.
TEST(Readers, APlantedFlawIsFound) {
  std::mt19937_64 random(1);
  EXPECT_EQ(first_flaw(fuzz::planted, "fas of the bone", 100'000, random), "planted");
  EXPECT_EQ(first_flaw_by_a_number(fuzz::planted_number, "length 5", 1000, random),
            "planted number by 1e300 at byte 7");
  // So is memory.
  fuzz::mark_held();
  const std::size_t before = fuzz::most_held_since_mark();
  { const std::vector<char> large(std::size_t{1} << 22); }
  EXPECT_GE(fuzz::most_held_since_mark(), before + (std::size_t{1} << 22));
}

// Stops the compiler from optimising an allocation away.
template <class T>
T* seen(T* memory) {
  T* volatile kept = memory;
  return kept;
}

// Every form of `new` must be counted, even if a sanitizer defines its own.
TEST(CountedMemory, IsThatOfAllFormsOfNew) {
  constexpr std::size_t size = std::size_t{1} << 22;
  struct alignas(64) Aligned {
    std::array<char, size> bytes;
  };
  const auto rise_of = [](const auto& use) {
    fuzz::mark_held();
    const std::size_t before = fuzz::most_held_since_mark();
    use();
    const std::size_t rise = fuzz::most_held_since_mark() - before;
    fuzz::mark_held();
    EXPECT_EQ(fuzz::most_held_since_mark(), before) << "memory was not freed";
    return rise;
  };
  using Bytes = std::array<char, size>;
  EXPECT_GE(rise_of([] { delete seen(new Bytes); }), size);
  EXPECT_GE(rise_of([] { delete[] seen(new char[size]); }), size);
  EXPECT_GE(rise_of([] { delete seen(new (std::nothrow) Bytes); }), size);
  EXPECT_GE(rise_of([] { delete[] seen(new (std::nothrow) char[size]); }), size);
  EXPECT_GE(rise_of([] { delete seen(new Aligned); }), size);
  EXPECT_GE(rise_of([] { delete[] seen(new Aligned[2]); }), 2 * size);
  EXPECT_GE(rise_of([] { delete seen(new (std::nothrow) Aligned); }), size);
  EXPECT_GE(rise_of([] { delete[] seen(new (std::nothrow) Aligned[2]); }), 2 * size);
  // It allocates its buffer with nothrow new and frees it with plain delete.
  std::vector<int> numbers(size / sizeof(int));
  std::iota(numbers.rbegin(), numbers.rend(), 0);
  EXPECT_GE(rise_of([&] { std::stable_sort(numbers.begin(), numbers.end()); }), size / 2);
}

}  // namespace
}  // namespace fascicle::tests
