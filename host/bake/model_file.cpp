#include "host/bake/model_file.h"

#include <array>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "host/bake/bake.h"
#include "host/bake/identity.h"
#include "host/bake/sealed_file.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/model/model_arrays.h"

namespace fascicle::bake {

namespace {

constexpr std::string_view model_magic = "FASCMODL";

// Lists and strings as in memory; a single value is a list of one.
template <class T>
struct Elements {
  static std::span<const char> bytes(const T& value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
  }
  static constexpr std::size_t size = sizeof(T);
};
template <class T>
struct Elements<std::vector<T>> {
  static_assert(std::is_trivially_copyable_v<T>);
  static std::span<const char> bytes(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
  }
  static constexpr std::size_t size = sizeof(T);
};
template <>
struct Elements<std::string> {
  static std::span<const char> bytes(const std::string& text) { return {text.data(), text.size()}; }
  static constexpr std::size_t size = 1;
};

class Writer {
 public:
  explicit Writer(std::string& out) : out_(out) {}
  template <class T>
  void operator()(std::string_view name, const T& field) {
    const std::span<const char> bytes = Elements<T>::bytes(field);
    head(name, Elements<T>::size, bytes.size() / Elements<T>::size);
    out_.append(bytes.data(), bytes.size());
  }
  template <class T>
  void optional(std::string_view name, const std::vector<T>& list) {
    if (!list.empty()) (*this)(name, list);
  }
  template <class T>
  void count(std::string_view name, const std::vector<T>& list) {
    head(name, 0, list.size());
  }

 private:
  void head(std::string_view name, std::size_t element, std::size_t count) {
    base::append_bytes(out_, static_cast<std::uint32_t>(name.size()));
    out_.append(name);
    base::append_bytes(out_, static_cast<std::uint32_t>(element));
    base::append_bytes(out_, std::uint64_t{count});
  }
  std::string& out_;
};

constexpr std::size_t head_bytes = 2 * sizeof(std::uint32_t) + sizeof(std::uint64_t);  // besides the name

class Sizer {
 public:
  template <class T>
  void operator()(std::string_view name, const T& field) {
    bytes_ += head_bytes + name.size() + Elements<T>::bytes(field).size();
  }
  template <class T>
  void optional(std::string_view name, const std::vector<T>& list) {
    if (!list.empty()) (*this)(name, list);
  }
  template <class T>
  void count(std::string_view name, const std::vector<T>&) {
    bytes_ += head_bytes + name.size();
  }
  std::uint64_t bytes() const { return bytes_; }

 private:
  std::uint64_t bytes_ = 0;
};

// The fewest bytes of an element in the file: empty texts and lists have heads too.
template <class Element, class Fields>
std::uint64_t least_bytes(const Fields& fields) {
  Sizer sizer;
  const Element empty{};
  base::for_each_row(fields, [&](const auto& field) { sizer(field.name, empty.*field.member); });
  return sizer.bytes();
}
std::uint64_t least_element_bytes(const std::vector<model::Layer>&) {
  return least_bytes<model::Layer>(model::layer_fields);
}
std::uint64_t least_element_bytes(const std::vector<model::ProbeSet>&) {
  return least_bytes<model::ProbeSet>(model::probe_fields);
}

// Says that a file is not one of ours, or not complete.
struct Mismatch : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}
  template <class T>
  void operator()(std::string_view name, T& field) {
    const std::string_view bytes = elements(name, Elements<T>::size);
    resize(field, bytes.size() / Elements<T>::size);
    if (!bytes.empty()) std::memcpy(data_of(field), bytes.data(), bytes.size());
  }
  template <class T>
  void optional(std::string_view name, std::vector<T>& list) {
    if (next_is(name)) (*this)(name, list);
  }
  template <class T>
  void count(std::string_view name, std::vector<T>& list) {
    const std::uint64_t count = head(name, 0);
    // An element takes about as many bytes in memory, so that a list takes no more than the file.
    if (count > rest_.size() / least_element_bytes(list)) throw Mismatch("it ends too soon");
    list.resize(count);
  }
  bool is_done() const { return rest_.empty(); }

 private:
  std::string_view take(std::uint64_t bytes) {
    if (bytes > rest_.size()) throw Mismatch("it ends too soon");
    const std::string_view taken = rest_.substr(0, bytes);
    rest_.remove_prefix(bytes);
    return taken;
  }
  template <class T>
  T number() {
    T value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  bool next_is(std::string_view name) const {
    std::uint32_t length = 0;
    if (rest_.size() < sizeof length) return false;
    std::memcpy(&length, rest_.data(), sizeof length);
    return length == name.size() && rest_.substr(sizeof length, length) == name;
  }
  std::uint64_t head(std::string_view name, std::size_t element) {
    const std::string_view found = take(number<std::uint32_t>());
    if (found != name || number<std::uint32_t>() != element)
      throw Mismatch("another version of fascicle wrote it (at " + std::string(name) + ")");
    return number<std::uint64_t>();
  }
  std::string_view elements(std::string_view name, std::size_t element) {
    const std::uint64_t count = head(name, element);
    if (count > rest_.size() / element) throw Mismatch("it ends too soon");
    return take(count * element);
  }
  template <class T>
  static void resize(std::vector<T>& list, std::size_t count) {
    list.resize(count);
  }
  static void resize(std::string& text, std::size_t count) { text.resize(count); }
  template <class T>
  static void resize(T&, std::size_t count) {
    if (count != 1) throw Mismatch("a single value has " + std::to_string(count));
  }
  template <class T>
  static void* data_of(std::vector<T>& list) {
    return list.data();
  }
  static void* data_of(std::string& text) { return text.data(); }
  template <class T>
  static void* data_of(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    return &value;
  }

  std::string_view rest_;
};

}  // namespace

std::string encode_model(const model::Model& model) {
  std::string bytes(model_magic);
  Writer writer(bytes);
  model::visit_fields(model, writer);
  base::append_bytes(bytes, XXH3_64bits(bytes.data(), bytes.size()));
  return bytes;
}

std::uint64_t encoded_bytes(const model::Model& model) {
  Sizer sizer;
  model::visit_fields(model, sizer);
  return model_magic.size() + sizer.bytes() + sizeof(std::uint64_t);
}

model::Model decode_model(std::string_view bytes) {
  if (!bytes.starts_with(model_magic)) throw BakeError("not a model of fascicle");
  std::uint64_t checksum = 0;
  if (bytes.size() < model_magic.size() + sizeof checksum) throw BakeError("the model is damaged");
  const std::string_view body = bytes.substr(0, bytes.size() - sizeof checksum);
  std::memcpy(&checksum, bytes.data() + body.size(), sizeof checksum);
  if (XXH3_64bits(body.data(), body.size()) != checksum) throw BakeError("the model is damaged");
  model::Model model;
  try {
    Reader reader(body.substr(model_magic.size()));
    model::visit_fields(model, reader);
    if (!reader.is_done()) throw Mismatch("another version of fascicle wrote it (fields at its end)");
    model::check_model(model);
  } catch (const Mismatch& mismatch) {
    throw BakeError(std::string("the model cannot be read: ") + mismatch.what());
  } catch (const std::invalid_argument& error) {
    throw BakeError(std::string("the model is invalid: ") + error.what());
  }
  return model;
}

model::Model read_model_file(const std::filesystem::path& path, std::optional<std::uint64_t> wanted_hash) {
  const auto fail = [&path](const std::string& what) -> BakeError {
    return BakeError(path.string() + ": " + what + "; bake again");
  };
  const std::string file = read_sealed(base::File(path, base::FileMode::read), model_magic);
  model::Model model;
  try {
    model = decode_model(file);
  } catch (const BakeError& error) {
    throw fail(error.what());
  }
  if (wanted_hash && model_hash(model) != *wanted_hash)
    throw fail("the frames in this folder were baked with another model");
  return model;
}

model::Model read_model_of_frames(const std::filesystem::path& folder, const CacheHeader& header) {
  const std::filesystem::path path = folder / model_file_name;
  if (!std::filesystem::exists(path))
    throw BakeError(path.string() +
                    ": is missing, or an older fascicle made this bake; bake again with --overwrite");
  model::Model model = read_model_file(path, header.model_hash);
  if (model.vertex_count != header.vertex_count || model.unit != header.unit)
    throw BakeError(path.string() + ": has " + base::number_text(std::uint64_t{model.vertex_count}) +
                    " vertices in units of " + base::number_text(model.unit) + " m, and " + cache_name +
                    " has " + base::number_text(std::uint64_t{header.vertex_count}) + " in units of " +
                    base::number_text(header.unit) + " m; bake again with --overwrite");
  return model;
}

}  // namespace fascicle::bake
