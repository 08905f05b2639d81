#include "host/gltf/gltf_decode.h"

#include <cmath>
#include <cstring>

#define TINYGLTF_IMPLEMENTATION
#include "host/gltf/gltf_library.h"
#include "host/rig/character.h"

namespace fascicle::gltf {
namespace {

using Buffers = std::map<std::string, std::vector<unsigned char>>;

// A virtual file system for tinygltf: the buffers already read, under the names that the check gave them.
tinygltf::FsCallbacks callbacks(const Buffers& buffers) {
  tinygltf::FsCallbacks fs{};
  fs.FileExists = [](const std::string& name, void* data) {
    return static_cast<const Buffers*>(data)->count(name) == 1;
  };
  fs.ExpandFilePath = [](const std::string& name, void*) { return name; };
  fs.ReadWholeFile = [](std::vector<unsigned char>* out, std::string*, const std::string& name, void* data) {
    *out = static_cast<const Buffers*>(data)->at(name);
    return true;
  };
  fs.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  fs.user_data = const_cast<Buffers*>(&buffers);  // only read above; the C-style callback has no const
  return fs;
}

template <typename T>
T load(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

double component(const unsigned char* bytes, int type, bool is_normalized) {
  double value = 0.0, one = 1.0;
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      value = load<std::int8_t>(bytes), one = 127.0;
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      value = load<std::uint8_t>(bytes), one = 255.0;
      break;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      value = load<std::int16_t>(bytes), one = 32767.0;
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      value = load<std::uint16_t>(bytes), one = 65535.0;
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return load<std::uint32_t>(bytes);
    default:
      return static_cast<double>(load<float>(bytes));
  }
  return is_normalized ? std::max(value / one, -1.0) : value;
}

const unsigned char* view_bytes(const tinygltf::Model& model, int view, std::size_t offset) {
  const tinygltf::BufferView& v = model.bufferViews[static_cast<std::size_t>(view)];
  return model.buffers[static_cast<std::size_t>(v.buffer)].data.data() + v.byteOffset + offset;
}

}  // namespace

std::shared_ptr<const tinygltf::Model> decode_gltf(const CheckedGltf& checked) {
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks(callbacks(checked.buffers));
  loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int,
                           const unsigned char*, int, void*) { return true; },
                        nullptr);
  auto model = std::make_shared<tinygltf::Model>();
  std::string error, warning;
  // The parser refused text that is not UTF-8, so dump cannot fail on it.
  const std::string text = checked.document.dump();
  if (!loader.LoadASCIIFromString(model.get(), &error, &warning, text.data(),
                                  static_cast<unsigned>(text.size()), "")) {
    gltf_error(checked.path, "/", "cannot be decoded: " + error);
  }
  return model;
}

std::vector<double> accessor_numbers(const std::filesystem::path& path, const tinygltf::Model& model,
                                     int accessor) {
  const tinygltf::Accessor& a = model.accessors[static_cast<std::size_t>(accessor)];
  const std::string pointer = "/accessors/" + std::to_string(accessor);
  const auto components =
      static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type)));
  const auto bytes = static_cast<std::size_t>(
      tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(a.componentType)));
  std::vector<double> numbers(a.count * components, 0.0);
  const auto fill = [&](std::size_t element, const unsigned char* from) {
    for (std::size_t c = 0; c < components; ++c) {
      numbers[element * components + c] = component(from + c * bytes, a.componentType, a.normalized);
    }
  };
  if (a.bufferView >= 0) {
    const std::size_t stride = model.bufferViews[static_cast<std::size_t>(a.bufferView)].byteStride;
    const unsigned char* from = view_bytes(model, a.bufferView, a.byteOffset);
    for (std::size_t i = 0; i < a.count; ++i) fill(i, from + i * (stride == 0 ? components * bytes : stride));
  }
  if (a.sparse.isSparse) {
    const auto index_bytes = static_cast<std::size_t>(
        tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(a.sparse.indices.componentType)));
    const unsigned char* indices =
        view_bytes(model, a.sparse.indices.bufferView, static_cast<std::size_t>(a.sparse.indices.byteOffset));
    const unsigned char* values =
        view_bytes(model, a.sparse.values.bufferView, static_cast<std::size_t>(a.sparse.values.byteOffset));
    double last = -1.0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(a.sparse.count); ++k) {
      const double index = component(indices + k * index_bytes, a.sparse.indices.componentType, false);
      if (index <= last || index >= static_cast<double>(a.count)) {
        gltf_error(path, pointer + "/sparse/indices",
                   "index " + std::to_string(static_cast<std::uint64_t>(index)) +
                       " is out of order or not below " + std::to_string(a.count));
      }
      last = index;
      fill(static_cast<std::size_t>(index), values + k * components * bytes);
    }
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!std::isfinite(numbers[i])) {
      gltf_error(path, pointer, "element " + std::to_string(i / components) + " is not a finite number");
    }
  }
  return numbers;
}

}  // namespace fascicle::gltf
