#include "host/render/decode_image.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {

bool picture(std::string_view bytes) {
  const render::DecodedImage image =
      render::decode_image({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
  if (!image.flaw.empty()) check_message(image.flaw);
  return image.flaw.empty();
}

}  // namespace fascicle::fuzz
