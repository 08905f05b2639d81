#include "gpu/self_test.h"

#include <bit>
#include <cstdint>
#include <cstdio>
#include <iterator>

#include "gpu/command.h"
#include "gpu/descriptor.h"
#include "shaders/buffers.h"
#include "shaders/kernel/self_test.inc"

namespace fascicle::gpu {
namespace {

using Input = kernel::SelfTestInput<float>;
using Quaternion = kernel::Quaternion<float>;

constexpr std::uint32_t row_count = 4096;

// A random number generator that needs no library (Marsaglia's xorshift, J. Stat. Software 8(14), 2003).
class Stream {
 public:
  std::uint32_t next() {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 17;
    state_ ^= state_ << 5;
    return state_;
  }
  // In [-1, 1), a multiple of 2^-23, so that rounding happens in the operations and not here.
  float signed_unit() { return static_cast<float>(static_cast<std::int32_t>(next()) >> 8) * 0x1p-23f; }
  // Random sign and mantissa, exponent from 2^-12 to 2^11: sums lose many bits, no product overflows.
  float number() {
    const std::uint32_t bits = next();
    return std::bit_cast<float>((bits & 0x807fffffu) | ((115u + (bits >> 23) % 24u) << 23));
  }

 private:
  std::uint32_t state_ = 2463534242u;
};

// The first rows combine special numbers: signed zeros, the smallest normal number, numbers around snap's
// threshold, neighbours of one. Only snap gets denormal numbers: devices may flush them anywhere else.
std::vector<Input> make_table() {
  const float special[] = {
      0.0f,           -0.0f,         1.0f, -1.0f, 0x1p-40f,  -0x1p-40f, 0x1.fffffep-41f, 0x1.000002p-40f,
      0x1.fffffep-1f, 0x1.000002p0f, 0.1f, 3.0f,  -0x1p-20f, 0x1p20f,   1.0f / 3.0f,     -1e-6f};
  constexpr std::size_t specials = std::size(special);
  Stream stream;
  std::vector<Input> table(row_count);
  for (std::size_t row = 0; row < row_count; ++row) {
    Input& t = table[row];
    t.x = stream.number();
    t.y = stream.number();
    t.z = stream.number();
    t.w = stream.number();
    if (row < specials * specials) {
      t.x = special[row % specials];
      t.y = special[row / specials];
      t.z = special[(row * 7 + 3) % specials];
    }
    float* entry = &t.a.xx;
    // Moments from round to flat: two rows scaled by 2^-8 to 1.
    for (int k = 0; k < 9; ++k)
      entry[k] = stream.signed_unit() *
                 (k / 3 == static_cast<int>(row % 3)
                      ? 1.0f
                      : std::bit_cast<float>((119u + static_cast<std::uint32_t>(row / 3 % 9)) << 23));
    t.q.w = 1.0f;
    t.q.x = stream.signed_unit();
    t.q.y = stream.signed_unit();
    t.q.z = stream.signed_unit();
    const Quaternion one{1.0f, 0.0f, 0.0f, 0.0f};
    t.q = kernel::multiply_normalized<float>(t.q, one);
  }
  return table;
}

// In the order of self_test.comp.
void append_results(const Input& t, std::vector<float>& results) {
  for (int operation = 0; operation < static_cast<int>(shader::self_test_scalars); ++operation)
    results.push_back(kernel::self_test_scalar<float>(operation, t.x, t.y, t.z, t.w));
  for (int operation = 0; operation < static_cast<int>(shader::self_test_positives); ++operation)
    results.push_back(kernel::self_test_positive<float>(operation, kernel::absolute<float>(t.x) + 0.25f));
  for (const bool mueller : {false, true}) {
    const Quaternion q = kernel::extract_rotation<float>(t.q, t.a, mueller);
    results.insert(results.end(), {q.w, q.x, q.y, q.z});
  }
}

std::string operation_name(std::uint32_t k) {
  const std::uint32_t scalars = shader::self_test_scalars, positives = shader::self_test_positives;
  if (k < scalars) return "scalar operation " + std::to_string(k);
  if (k < scalars + positives) return "operation of a positive number " + std::to_string(k - scalars);
  if (k < scalars + positives + 4)
    return "rotation qcp, component " + std::to_string(k - scalars - positives);
  return "rotation mueller2016, component " + std::to_string(k - scalars - positives - 4);
}

}  // namespace

std::vector<float> run_self_test(Device::Impl& device, spirv_exact::Module module,
                                 spirv_exact::FloatControls controls) {
  const std::vector<Input> table = make_table();
  std::vector<float> results(std::size_t{row_count} * shader::self_test_results);
  const Kernel kernel(device, module, {}, controls);
  const Buffer inputs(device, std::as_bytes(std::span(table)).size(), BufferUse::storage);
  const Buffer outputs(device, std::as_bytes(std::span(results)).size(), BufferUse::storage);
  write_buffer(device, inputs, std::as_bytes(std::span(table)));

  BufferTable buffers{};
  buffers[shader::buffer_self_test_input] = whole(inputs);
  buffers[shader::buffer_self_test_result] = whole(outputs);
  DescriptorPool sets(device, 1);
  const CommandPool pool(device);
  CommandBuffer commands(device, pool);
  shader::Push push{};
  push.substep.vertex_count = row_count;
  commands.barrier();
  commands.dispatch(kernel, sets.make_set(kernel, buffers), push, row_count / shader::slice_width);
  commands.submit_and_wait();
  read_buffer(device, outputs, std::as_writable_bytes(std::span(results)));
  return results;
}

std::vector<float> expected_self_test() {
  std::vector<float> results;
  results.reserve(std::size_t{row_count} * shader::self_test_results);
  for (const Input& t : make_table()) append_results(t, results);
  return results;
}

std::string first_self_test_difference(std::span<const float> device_results) {
  const std::vector<float> expected = expected_self_test();
  for (std::size_t k = 0; k < expected.size(); ++k) {
    const auto ours = std::bit_cast<std::uint32_t>(expected[k]),
               theirs = std::bit_cast<std::uint32_t>(device_results[k]);
    if (ours == theirs) continue;
    char numbers[64];
    std::snprintf(numbers, sizeof numbers, "%08x here, %08x on the device", ours, theirs);
    return "row " + std::to_string(k / shader::self_test_results) + ", " +
           operation_name(static_cast<std::uint32_t>(k % shader::self_test_results)) + ": " + numbers;
  }
  return {};
}

}  // namespace fascicle::gpu
