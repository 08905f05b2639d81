// tiny_gltf.h with the macros that must be the same wherever it is included: no images, no file access.
#pragma once

#include <fstream>  // needed by tiny_gltf.h, which does not include it

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>
