// Messages from a page: what is accepted, and that nothing else is.
#include "host/studio/commands.h"

#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/studio/wire.h"

namespace fascicle::tests {
namespace {

using studio::BadMessage;
using studio::Command;
using studio::HandAction;
using studio::parse_command;
using studio::Verb;

std::string refusal(const std::string& text) {
  try {
    (void)parse_command(text);
    return "";
  } catch (const BadMessage& error) {
    return error.what();
  }
}

TEST(Commands, AreRead) {
  EXPECT_EQ(parse_command(R"({"type":"play","id":7})").id, 7);
  EXPECT_EQ(parse_command(R"({"type":"play"})").verb, Verb::play);
  EXPECT_EQ(parse_command(R"({"type":"seek","frame":12})").frame, 12u);
  EXPECT_EQ(parse_command(R"({"type":"speed","factor":0.25})").factor, 0.25);
  EXPECT_TRUE(parse_command(R"({"type":"loop","on":true})").is_on);
  EXPECT_EQ(parse_command(R"({"type":"show","blocks":["surface","joints"]})").blocks, 1 + 16);
  EXPECT_EQ(parse_command(R"({"type":"show","blocks":["solids"],"beside":["ghost"]})").blocks, 64);
  EXPECT_EQ(parse_command(R"({"type":"show","blocks":["solids"],"beside":["ghost"]})").beside_blocks, 2);
  EXPECT_EQ(parse_command(R"({"type":"beside","name":"out/arm"})").name, "out/arm");
  EXPECT_EQ(parse_command(R"({"type":"beside","name":""})").verb, Verb::beside);
  const Command set = parse_command(
      R"({"type":"set","changes":{"layers.fat.beta":0.5,"layers.fat.alpha":null},"label":"x","gesture":3})");
  ASSERT_EQ(set.changes.size(), 2u);
  EXPECT_EQ(set.changes[0].path, "layers.fat.beta");
  EXPECT_EQ(set.changes[0].value, 0.5);
  EXPECT_FALSE(set.changes[1].value);
  EXPECT_EQ(set.label, "x");
  EXPECT_EQ(set.gesture, 3u);
  const Command hand =
      parse_command(R"({"type":"hand","action":"grab","vertex":5,"place":[1,2,3],"of":"vertices"})");
  EXPECT_EQ(hand.action, HandAction::grab);
  EXPECT_TRUE(hand.is_of_model);
  EXPECT_EQ(hand.vector[2], 3.0);
  const Command bake =
      parse_command(R"({"type":"bake","folder":"mine","formats":["glb","pc2"],"overwrite":true})");
  EXPECT_EQ(bake.name, "mine");
  EXPECT_EQ(bake.formats.size(), 2u);
  EXPECT_TRUE(bake.overwrite);
  const Command paint = parse_command(
      R"({"type":"paint","attribute":"_STIFFNESS","value":0.25,"radius":0.1,"strength":0.5,"falloff":"linear",)"
      R"("mirror":true,"places":[[1,2,3],[4,5,6]],"stroke":7,"last":false})");
  EXPECT_EQ(paint.piece.brush.kind->name, std::string("_STIFFNESS"));
  EXPECT_EQ(paint.piece.brush.value, 0.25f);
  EXPECT_EQ(paint.piece.brush.strength, 0.5);
  EXPECT_EQ(paint.piece.brush.falloff, studio::Falloff::linear);
  EXPECT_TRUE(paint.piece.brush.is_mirrored);
  ASSERT_EQ(paint.piece.places.size(), 2u);
  EXPECT_EQ(paint.piece.places[1][2], 6.0);
  EXPECT_EQ(paint.piece.stroke, 7u);
  EXPECT_FALSE(paint.piece.is_last);
  const Command erase = parse_command(
      R"({"type":"paint","attribute":"_LAYER","erase":true,"radius":0.1,"places":[[1,2,3]],"stroke":8})");
  EXPECT_TRUE(erase.piece.brush.erases);
  EXPECT_TRUE(erase.piece.is_last);
}

TEST(Commands, RefusalsSayWhatIsWrong) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "not valid JSON"},
      {"{", "not valid JSON"},
      {"7", "one JSON object"},
      {"[]", "one JSON object"},
      {"{}", "type is missing"},
      {R"({"type":7})", "takes text"},
      {R"({"type":"plya"})", "play"},
      {R"({"type":"play","more":1})", "more"},
      {R"({"type":"play","id":1.5})", "whole number"},
      {R"({"type":"seek"})", "frame is missing"},
      {R"({"type":"seek","frame":-1})", "must be from 0"},
      {R"({"type":"seek","frame":1e300})", "must be from 0"},
      {R"({"type":"speed","factor":0})", "must be from"},
      {R"({"type":"loop"})", "on is missing"},
      {R"({"type":"show","blocks":["surfaces"]})", "surface"},
      {R"({"type":"show","beside":["surfaces"]})", "surface"},
      {R"({"type":"beside"})", "name is missing"},
      {R"({"type":"set","changes":{}})", "1 to"},
      {R"({"type":"hand","action":"grab","vertex":0})", "place is missing"},
      {R"({"type":"hand","action":"grab","vertex":0,"place":[1,2]})", "three numbers"},
      {R"({"type":"hand","action":"move","place":[1,2,1e9]})", "must be from"},
      {R"({"type":"save","file":"../x.toml"})", "without folders"},
      {R"({"type":"save","file":"x.txt"})", ".toml"},
      {R"({"type":"save","file":"/etc/x.toml"})", "without folders"},
      {R"({"type":"bake","folder":".."})", "without folders"},
      {R"({"type":"bake","folder":"a/b"})", "without folders"},
      {R"({"type":"bake","formats":["exe"]})", "not a format"},
      {R"({"type":"paint"})", "attribute is missing"},
      {R"({"type":"paint","attribute":"_LAYR"})", "did you mean _LAYER"},
      {R"({"type":"paint","attribute":"_LAYER"})", "value is missing"},
      {R"({"type":"paint","attribute":"_LAYER","value":1.5})", "whole number"},
      {R"({"type":"paint","attribute":"_RIGID","value":2})", "must be from 0 to 1"},
      {R"({"type":"paint","attribute":"_FIBER"})", "radius is missing"},
      {R"({"type":"paint","attribute":"_FIBER","radius":-1})", "must be from"},
      {R"({"type":"paint","attribute":"_FIBER","radius":1,"falloff":"lineal"})", "did you mean linear"},
      {R"({"type":"paint","attribute":"_FIBER","radius":1,"places":[]})", "1 to 256"},
      {R"({"type":"paint","attribute":"_FIBER","radius":1,"places":[[1,2]]})", "three numbers"},
      {R"({"type":"paint","attribute":"_FIBER","radius":1,"places":[[1,2,3]]})", "stroke is missing"}};
  for (const auto& [text, word] : cases)
    EXPECT_NE(refusal(text).find(word), std::string::npos) << text << " was answered: " << refusal(text);
  EXPECT_NE(refusal(R"({"type":"set","changes":{"a":)" + std::string(40, '[') + std::string(40, ']') + "}}")
                .find("deeper"),
            std::string::npos);
  EXPECT_NE(refusal(std::string(100000, '[')), "");
  // The message is the first level of 16; the control is refused for what it says.
  const auto nested = [](std::size_t levels) {
    return R"({"type":"pause","x":)" + std::string(levels, '[') + std::string(levels, ']') + "}";
  };
  EXPECT_NE(refusal(nested(16)).find("deeper than 16 levels"), std::string::npos);
  EXPECT_EQ(refusal(nested(15)).find("deeper"), std::string::npos);
  // Many small objects are read without going over all of them for each.
  std::string objects = R"({"type":"pause","x":[{})";
  for (int k = 0; k < 80'000; ++k) objects += ",{}";
  EXPECT_NE(refusal(objects + "]}"), "");
  std::string many = R"({"type":"pause","a":0)";
  for (int k = 0; k < 1000; ++k) many += ",\"" + std::to_string(k) + "\":0";
  EXPECT_EQ(refusal(many + "}"), "not valid JSON, or too large an object");
}

// Random messages are accepted or refused, and nothing else happens. FASCICLE_FUZZ_MESSAGES sets their
// number.
TEST(Commands, FuzzedMessagesAreTakenOrRefused) {
  const std::vector<std::string> seeds{
      R"({"type":"set","id":1,"changes":{"layers.fat.beta":0.5,"scene.gravity":[0,-9,0]},"label":"x","gesture":3})",
      R"({"type":"hand","action":"grab","vertex":5,"place":[1,2,3],"of":"vertices","radius":0.1})",
      R"({"type":"bake","folder":"mine","formats":["glb","pc2"],"overwrite":true})",
      R"({"type":"paint","attribute":"_FIBER","radius":0.1,"places":[[1,2,3],[4,5,6]],"stroke":7,"mirror":true})",
      R"({"type":"show","blocks":["surface","ghost"]})",
      R"({"type":"seek","frame":12})"};
  const char* wanted = std::getenv("FASCICLE_FUZZ_MESSAGES");
  const std::uint64_t count = wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : 100000;
  std::mt19937_64 random(1);
  std::uint64_t taken = 0;
  for (std::uint64_t k = 0; k < count; ++k) {
    std::string text = seeds[random() % seeds.size()];
    for (std::uint64_t edits = random() % 4; edits > 0 && !text.empty(); --edits) {
      const std::size_t at = random() % text.size();
      switch (random() % 4) {
        case 0:
          text[at] = static_cast<char>(random());
          break;
        case 1:
          text.erase(at, random() % 8);
          break;
        case 2:
          text.insert(at, text.substr(random() % text.size(), random() % 16));
          break;
        default:
          text.insert(at, 1, "{}[]\",:0-9e.\\"[random() % 13]);
          break;
      }
    }
    try {
      const Command command = parse_command(text);
      ++taken;
      const bool is_preset = command.verb == Verb::preset;
      EXPECT_TRUE(is_preset || command.name.find('/') == std::string::npos);
    } catch (const BadMessage& error) {
      EXPECT_LT(std::string(error.what()).size(), 400u);
    }
  }
  EXPECT_GT(taken, count / 20);
}

}  // namespace
}  // namespace fascicle::tests
