// The comparison bake: a second bake shown beside what is played. Lists the choices and opens the chosen one.
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
  std::string name;  // as pages call it: the folder as given, or its path in the session's folder
  std::filesystem::path folder;
};

// All choices: the folders that the studio was started with, then the bakes in the session's folder (empty:
// none). Links there are left out, because they may lead anywhere.
std::vector<BesideChoice> beside_choices(const std::vector<std::filesystem::path>& given,
                                         const std::filesystem::path& session);

class BesideBake {
 public:
  // Throws base::BakeError if the bake cannot be read.
  explicit BesideBake(BesideChoice choice);

  const BesideChoice& choice() const { return choice_; }
  // Its shape, with names that begin with "beside."
  const std::vector<ArrayMessage>& arrays() const { return arrays_; }
  // "bake" of the message `beside`.
  Json description() const;

  // The frame nearest to this clip time, s; clamped to the first and the last.
  ShownFrame at(double time);
  Motion& motion() { return *motion_; }

 private:
  BesideChoice choice_;
  std::unique_ptr<BakedMotion> motion_;
  const model::Model* model_ = nullptr;  // the bake's; owned by motion_
  std::vector<ArrayMessage> arrays_;
};

}  // namespace fascicle::studio
