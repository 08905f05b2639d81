// A model as named arrays, and back.
#include <array>
#include <cstring>
#include <map>
#include <type_traits>

#include "host/api/boundary.h"
#include "host/api/handles.h"
#include "host/model/model_arrays.h"

namespace fascicle::api {
namespace {

template <class T>
constexpr fascicle_type type_of() {
  if constexpr (std::is_same_v<T, float>) return FASCICLE_FLOAT32;
  if constexpr (std::is_same_v<T, double>) return FASCICLE_FLOAT64;
  if constexpr (std::is_same_v<T, bool>) return FASCICLE_UINT8;
  if constexpr (std::is_same_v<T, std::uint32_t> || std::is_enum_v<T>) return FASCICLE_UINT32;
  return FASCICLE_RECORDS;
}
static_assert(sizeof(bool) == 1 && sizeof(model::WeightForm) == 4);

bool is_of_probes(std::string_view name) {
  return name.starts_with("probe");
}

// One array per field; for a list of structs, the values of each field are concatenated.
class Lister {
 public:
  explicit Lister(Body& body) : body_(body) {}

  template <class T>
  void operator()(const char* name, const T& value) {
    add(name, &value, 1);
  }
  template <class T, std::size_t n>
  void operator()(const char* name, const std::array<T, n>& values) {
    add(name, values.data(), n);
  }
  template <class T>
  void operator()(const char* name, const std::vector<T>& values) {
    if (!is_of_probes(name)) add(name, values.data(), values.size());
  }
  void operator()(const char* name, const std::string& text) {
    join(name, FASCICLE_TEXT, 1, text.c_str(), text.size() + 1);
  }
  template <class T>
  void optional(const char* name, const std::vector<T>& values) {
    (*this)(name, values);
  }
  template <class T>
  void count(const char*, const std::vector<T>&) {}

 private:
  template <class T>
  void add(const std::string& name, const T* data, std::size_t count) {
    if (is_of_probes(name)) return;
    if (name.find('.') != std::string::npos) return join(name, type_of<T>(), sizeof(T), data, count);
    body_.bytes.push_back(name);
    body_.arrays.push_back({body_.bytes.back().c_str(), type_of<T>(), sizeof(T), count, data});
  }

  // Appends another layer's value to the previous ones.
  void join(const std::string& name, fascicle_type type, std::size_t item, const void* data,
            std::size_t count) {
    if (is_of_probes(name)) return;
    auto found = joined_.find(name);
    if (found == joined_.end()) {
      body_.bytes.push_back(name);
      body_.arrays.push_back({body_.bytes.back().c_str(), type, item, 0, nullptr});
      body_.bytes.emplace_back();
      found = joined_.emplace(name, Joined{body_.arrays.size() - 1, &body_.bytes.back()}).first;
    }
    found->second.bytes->append(static_cast<const char*>(data), item * count);
    fascicle_array& array = body_.arrays[found->second.array];
    array.count += count;
    array.data = found->second.bytes->data();
  }

  struct Joined {
    std::size_t array;
    std::string* bytes;
  };
  Body& body_;
  std::map<std::string, Joined> joined_;
};

class Taker {
 public:
  Taker(const fascicle_array* arrays, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) {
      must_have(arrays[k].name, "the name of an array");
      if (arrays[k].count > 0 && arrays[k].data == nullptr)
        throw BadArgument("the data of array \"" + std::string(arrays[k].name) + "\" is null");
      if (!given_.emplace(arrays[k].name, Given{arrays[k], 0, false}).second)
        throw BadArgument("array \"" + std::string(arrays[k].name) + "\" is given twice");
    }
  }

  template <class T>
  void operator()(const char* name, T& value) {
    if (Given* given = find<T>(name)) {
      // A bool must be 0 or 1, and no enumerator has a value above 1.
      if constexpr (std::is_same_v<T, bool> || std::is_enum_v<T>) {
        std::conditional_t<std::is_enum_v<T>, std::uint32_t, std::uint8_t> number = 0;
        next(*given, &number, sizeof number, 1);
        if (number > 1)
          throw BadArgument("array \"" + std::string(name) + "\" holds " + std::to_string(number) +
                            "; it must be 0 or 1");
        value = static_cast<T>(number);
      } else {
        next(*given, &value, sizeof value, 1);
      }
    }
  }
  template <class T, std::size_t n>
  void operator()(const char* name, std::array<T, n>& values) {
    if (Given* given = find<T>(name)) next(*given, values.data(), sizeof(T), n);
  }
  template <class T>
  void operator()(const char* name, std::vector<T>& values) {
    if (Given* given = find<T>(name)) {
      values.resize(given->array.count);
      next(*given, values.data(), sizeof(T), values.size());
    }
  }
  void operator()(const char* name, std::string& text) {
    Given* given = find_as(name, FASCICLE_TEXT, 1);
    if (given == nullptr) return;
    const char* data = static_cast<const char*>(given->array.data) + given->taken;
    const std::size_t left = given->array.count - given->taken;
    const std::size_t length = left == 0 ? 0 : ::strnlen(data, left);
    if (length == left)
      throw BadArgument("array \"" + std::string(name) + "\" ends before its last text does");
    text.assign(data, length);
    given->taken += length + 1;
  }
  template <class T>
  void optional(const char* name, std::vector<T>& values) {
    (*this)(name, values);
  }
  template <class T>
  void count(const char*, std::vector<T>& list) {
    if constexpr (std::is_same_v<T, model::Layer>)
      if (const auto found = given_.find("layer.damping"); found != given_.end()) {
        const std::size_t layers = found->second.array.count;
        // check_model has the same limit, but a layer in memory is many times as large as an item of the
        // array.
        constexpr std::size_t most_layers = shader::tag_layer_mask + 1;
        if (layers > most_layers)
          throw BadArgument("array \"layer.damping\" has " + std::to_string(layers) +
                            " items; a model has at most " + std::to_string(most_layers) + " layers");
        list.resize(layers);
      }
  }

  void check_all_taken() const {
    for (const auto& [name, given] : given_) {
      if (!given.used) throw BadArgument("there is no array \"" + name + "\" in a model");
      if (given.taken != given.array.count)
        throw BadArgument("array \"" + name + "\" has " + std::to_string(given.array.count) + " items, but " +
                          std::to_string(given.taken) + " were needed");
    }
  }

 private:
  struct Given {
    fascicle_array array;
    std::size_t taken;
    bool used;
  };

  template <class T>
  Given* find(const char* name) {
    return find_as(name, type_of<T>(), sizeof(T));
  }
  Given* find_as(const char* name, fascicle_type type, std::size_t item) {
    const auto found = given_.find(name);
    if (found == given_.end()) return nullptr;
    found->second.used = true;
    if (found->second.array.type != type || found->second.array.item_bytes != item)
      throw BadArgument("array \"" + std::string(name) +
                        "\" has another type or size of items than a model's");
    return &found->second;
  }
  static void next(Given& given, void* to, std::size_t item, std::size_t count) {
    if (given.array.count - given.taken < count)
      throw BadArgument("array \"" + std::string(given.array.name) + "\" has too few items");
    if (count > 0)
      std::memcpy(to, static_cast<const char*>(given.array.data) + given.taken * item, item * count);
    given.taken += count;
  }

  std::map<std::string, Given> given_;
};

}  // namespace

void list_arrays(Body& body) {
  Lister lister(body);
  const model::Model& model = body.model;
  model::visit_fields(model, lister);
}

model::Model model_of_arrays(const fascicle_array* arrays, std::size_t count) {
  if (count > 0) must_have(arrays, "arrays");
  Taker taker(arrays, count);
  model::Model model;
  model::visit_fields(model, taker);
  taker.check_all_taken();
  if (model.vertex_count == 0) throw BadArgument("array \"vertex_count\" is missing or 0");
  model::check_model(model);
  return model;
}

}  // namespace fascicle::api
