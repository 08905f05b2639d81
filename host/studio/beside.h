// Bakes that stand beside what is played: which there are, and the one that is shown.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/studio/baked_motion.h"
#include "host/studio/body_messages.h"

namespace fascicle::studio {

struct BesideChoice {
  std::string name;  // as pages call it: the folder as it was given, or as it is reached from there
  std::filesystem::path folder;
};

// All that may be asked for: the folders that the studio was started with, then the bakes in the session's
// own folder (empty: none). A link there may lead anywhere, and is left out.
std::vector<BesideChoice> beside_choices(const std::vector<std::filesystem::path>& given,
                                         const std::filesystem::path& session);

class BesideBake {
 public:
  // Throws base::BakeError with what is wrong with the bake.
  explicit BesideBake(BesideChoice choice);

  const BesideChoice& choice() const { return choice_; }
  // Its shape, under names that begin with "beside."
  const std::vector<ArrayMessage>& arrays() const { return arrays_; }
  // "bake" of the message `beside`.
  Json description() const;

  // The frame nearest to this time of the clip, s; before the first and after the last that one.
  ShownFrame at(double time);
  Motion& motion() { return *motion_; }

 private:
  BesideChoice choice_;
  std::unique_ptr<BakedMotion> motion_;
  const model::Model* model_ = nullptr;  // the bake's, which the motion holds
  std::vector<ArrayMessage> arrays_;
};

}  // namespace fascicle::studio
