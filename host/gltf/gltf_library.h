// tiny_gltf.h with the switches that must be the same wherever it is included: no images, no file system of
// its own.
#pragma once

#include <fstream>  // which tiny_gltf.h needs and forgets

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>
