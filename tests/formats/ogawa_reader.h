// Reads Alembic's Ogawa files, written from the format's description without code of the writer. Strict:
// anything invalid throws std::runtime_error with what and where.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace fascicle::tests {

enum class OgawaKind { compound, scalar, array };

struct OgawaSample {
  std::array<std::uint64_t, 2> digest{};
  std::string bytes;
};

struct OgawaProperty {
  std::string name, metadata;
  OgawaKind kind = OgawaKind::compound;
  unsigned pod = 0;     // Alembic's type number: 6 int32, 10 float32, 11 float64
  unsigned extent = 0;  // values per point
  bool one_point = false, homogeneous = false;
  std::uint32_t samples = 0, first_changed = 0, last_changed = 0, sampling = 0;
  std::vector<OgawaSample> stored;        // of scalars and arrays
  std::vector<OgawaProperty> properties;  // of compounds

  // The stored sample used for sample k; equal samples are stored once.
  const OgawaSample& at(std::uint32_t k) const;
  const OgawaProperty& property(const std::string& of_name) const;
};

struct OgawaObject {
  std::string name, metadata;
  OgawaProperty properties;  // a compound without a name
  std::vector<OgawaObject> children;
};

struct OgawaSampling {
  std::uint32_t most_samples = 0;
  double period = 0.0;
  std::vector<double> times;
};

struct OgawaArchive {
  std::int32_t form_version = -1, alembic_version = -1;
  std::string metadata;
  std::vector<OgawaSampling> samplings;
  OgawaObject top;
};

OgawaArchive read_ogawa(const std::string& file);

}  // namespace fascicle::tests
