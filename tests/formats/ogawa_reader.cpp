#include "tests/formats/ogawa_reader.h"

#include <cstring>
#include <stdexcept>

namespace fascicle::tests {

namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error("Ogawa: " + what);
}

// Reads packed values one after another.
struct Cursor {
  std::string bytes;
  std::size_t at = 0;

  bool done() const { return at == bytes.size(); }
  std::string text(std::size_t count) {
    if (count > bytes.size() - at) fail("text of " + std::to_string(count) + " bytes passes the end");
    at += count;
    return bytes.substr(at - count, count);
  }
  template <class T>
  T value() {
    T result;
    std::memcpy(&result, text(sizeof result).data(), sizeof result);
    return result;
  }
  std::uint32_t sized(unsigned hint) {
    if (hint == 0) return value<std::uint8_t>();
    if (hint == 1) return value<std::uint16_t>();
    if (hint == 2) return value<std::uint32_t>();
    fail("a size of 2^" + std::to_string(hint) + " bytes");
  }
};

class Reader {
 public:
  explicit Reader(const std::string& file) : file_(file) {}

  OgawaArchive archive() {
    if (file_.size() < 16 || file_.compare(0, 5, "Ogawa") != 0) fail("no magic word");
    if (static_cast<unsigned char>(file_[5]) != 0xff) fail("the file was not finished");
    if (file_[6] != 0 || file_[7] != 1) fail("not version 1");
    const std::vector<std::uint64_t> root = group(number(8));
    if (root.size() != 6) fail("the root has " + std::to_string(root.size()) + " children");
    OgawaArchive result;
    result.form_version = Cursor{data(root[0])}.value<std::int32_t>();
    result.alembic_version = Cursor{data(root[1])}.value<std::int32_t>();
    result.metadata = data(root[3]);
    for (Cursor in{data(root[4])}; !in.done();) {
      OgawaSampling& sampling = result.samplings.emplace_back();
      sampling.most_samples = in.value<std::uint32_t>();
      sampling.period = in.value<double>();
      const auto times = in.value<std::uint32_t>();
      for (std::uint32_t k = 0; k < times; ++k) sampling.times.push_back(in.value<double>());
    }
    samplings_ = result.samplings.size();
    metadata_ = {""};
    for (Cursor in{data(root[5])}; !in.done();) metadata_.push_back(in.text(in.value<std::uint8_t>()));
    result.top = object(root[2]);
    result.top.name = "ABC";
    return result;
  }

 private:
  static constexpr std::uint64_t data_bit = std::uint64_t{1} << 63;

  std::uint64_t number(std::uint64_t at) const {
    if (at > file_.size() || file_.size() - at < 8) fail("offset " + std::to_string(at) + " passes the end");
    std::uint64_t value = 0;
    std::memcpy(&value, file_.data() + at, 8);
    return value;
  }
  std::vector<std::uint64_t> group(std::uint64_t child) const {
    if ((child & data_bit) != 0) fail("data where a group belongs");
    std::vector<std::uint64_t> children;
    if (child == 0) return children;
    const std::uint64_t count = number(child);
    if (count > file_.size() / 8) fail("a group of " + std::to_string(count));
    for (std::uint64_t k = 0; k < count; ++k) children.push_back(number(child + 8 + 8 * k));
    return children;
  }
  std::string data(std::uint64_t child) const {
    if ((child & data_bit) == 0) fail("a group where data belongs");
    const std::uint64_t at = child & ~data_bit;
    if (at == 0) return "";
    const std::uint64_t size = number(at);
    if (size > file_.size() - at - 8) fail("data of " + std::to_string(size) + " bytes passes the end");
    return file_.substr(at + 8, size);
  }
  OgawaSample sample(std::uint64_t child) const {
    Cursor in{data(child)};
    OgawaSample result;
    if (in.done()) return result;
    result.digest = {in.value<std::uint64_t>(), in.value<std::uint64_t>()};
    result.bytes = in.text(in.bytes.size() - in.at);
    return result;
  }
  const std::string& metadata(std::uint32_t number) const {
    if (number >= metadata_.size()) fail("metadata " + std::to_string(number) + " is not in the table");
    return metadata_[number];
  }

  OgawaObject object(std::uint64_t child) const {
    const std::vector<std::uint64_t> parts = group(child);
    if (parts.size() < 2) fail("an object without properties and headers");
    OgawaObject result;
    result.properties.properties = properties(parts.front());
    std::string headers = data(parts.back());
    if (headers.size() < 32) fail("an object without its two digests");
    headers.resize(headers.size() - 32);
    std::size_t k = 1;
    for (Cursor in{headers}; !in.done(); ++k) {
      if (k + 1 >= parts.size()) fail("more headers than children");
      const std::string name = in.text(in.value<std::uint32_t>());
      const auto number = in.value<std::uint8_t>();
      const std::string text = number == 255 ? in.text(in.value<std::uint32_t>()) : metadata(number);
      result.children.push_back(object(parts[k]));
      result.children.back().name = name;
      result.children.back().metadata = text;
    }
    if (k + 1 != parts.size()) fail("more children than headers");
    return result;
  }

  std::vector<OgawaProperty> properties(std::uint64_t child) const {
    std::vector<OgawaProperty> result;
    const std::vector<std::uint64_t> parts = group(child);
    if (parts.empty()) return result;
    for (Cursor in{data(parts.back())}; !in.done();) {
      const auto info = in.value<std::uint32_t>();
      const unsigned hint = info >> 2 & 3u;
      OgawaProperty& property = result.emplace_back();
      if ((info & 3u) != 0) {
        property.kind = (info & 3u) == 1 ? OgawaKind::scalar : OgawaKind::array;
        property.one_point = (info & 1u) != 0;
        property.pod = info >> 4 & 15u;
        property.homogeneous = (info & 0x400u) != 0;
        property.extent = info >> 12 & 255u;
        property.samples = in.sized(hint);
        property.first_changed = 1;
        property.last_changed = property.samples - 1;
        if ((info & 0x200u) != 0) {
          property.first_changed = in.sized(hint);
          property.last_changed = in.sized(hint);
        } else if ((info & 0x800u) != 0) {
          property.first_changed = property.last_changed = 0;
        }
        if ((info & 0x100u) != 0) property.sampling = in.sized(hint);
        if (property.sampling >= samplings_) fail("time sampling " + std::to_string(property.sampling));
      }
      property.name = in.text(in.sized(hint));
      const std::uint32_t number = info >> 20 & 255u;
      property.metadata = number == 255 ? in.text(in.sized(hint)) : metadata(number);
      if (result.size() >= parts.size()) fail("more property headers than properties");
      fill(property, parts[result.size() - 1]);
    }
    if (result.size() + 1 != parts.size()) fail("more properties than headers");
    return result;
  }

  void fill(OgawaProperty& property, std::uint64_t child) const {
    if (property.kind == OgawaKind::compound) {
      property.properties = properties(child);
      return;
    }
    const std::vector<std::uint64_t> parts = group(child);
    const std::size_t step = property.kind == OgawaKind::array ? 2 : 1;
    const std::size_t wanted =
        property.first_changed == 0 ? 1 : property.last_changed - property.first_changed + 2;
    if (parts.size() != step * wanted)
      fail(property.name + " holds " + std::to_string(parts.size()) + " parts for " + std::to_string(wanted) +
           " samples");
    for (std::size_t k = 0; k < parts.size(); k += step) {
      property.stored.push_back(sample(parts[k]));
      // Empty dimensions follow from the size.
      if (step == 2 && !data(parts[k + 1]).empty()) fail(property.name + " has dimensions of its own");
    }
  }

  const std::string& file_;
  std::vector<std::string> metadata_;
  std::size_t samplings_ = 0;
};

}  // namespace

const OgawaSample& OgawaProperty::at(std::uint32_t k) const {
  if (k >= samples) fail(name + " has no sample " + std::to_string(k));
  if (first_changed == 0 || k < first_changed) return stored.at(0);
  return stored.at((k > last_changed ? last_changed : k) - first_changed + 1);
}

const OgawaProperty& OgawaProperty::property(const std::string& of_name) const {
  for (const OgawaProperty& each : properties)
    if (each.name == of_name) return each;
  fail(name + " has no property " + of_name);
}

OgawaArchive read_ogawa(const std::string& file) {
  return Reader(file).archive();
}

}  // namespace fascicle::tests
