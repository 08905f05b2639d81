// What a scene's text says.
#pragma once

#include <string>

#include "host/scene/scene.h"

namespace fascicle::scene {

// In its keys but scene.end: comments, order and spelling are gone. Two scenes with one such text are the
// same but for where they end.
std::string keys_text_without_end(const Scene& scene);

}  // namespace fascicle::scene
