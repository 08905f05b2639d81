// The structs of shared.h and buffers.h have a C++ layout and a std430 layout in GLSL, which must match. The
// compiled shaders give the true offsets, in the Offset decorations of members.
#include <cstddef>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shaders/buffers.h"
#include "shaders/modules.h"
#include "shaders/spirv_exact/module.h"

namespace fascicle::tests {
namespace {

using Members = std::map<std::string, std::uint32_t>;  // name to offset

std::string text_at(std::span<const std::uint32_t> words) {
  return std::string(reinterpret_cast<const char*>(words.data()),
                     strnlen(reinterpret_cast<const char*>(words.data()), 4 * words.size()));
}

struct Layout {
  Members members;
  std::uint32_t stride = 0;  // of a runtime array of it; 0 if there is none
};

// The struct `name` that has offsets; a struct used only in functions has none.
Layout layout_in(spirv_exact::Module module, const std::string& name) {
  std::map<std::uint32_t, std::string> names;
  std::map<std::uint32_t, std::map<std::uint32_t, std::string>> member_names;
  std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>> offsets;
  std::map<std::uint32_t, std::uint32_t> strides, element_of;
  for (const auto& i : spirv_exact::instructions_of(module)) {
    if (i.opcode == spv::OpName) names[i.words[1]] = text_at(i.words.subspan(2));
    if (i.opcode == spv::OpMemberName) member_names[i.words[1]][i.words[2]] = text_at(i.words.subspan(3));
    if (i.opcode == spv::OpTypeRuntimeArray) element_of[i.words[1]] = i.words[2];
    if (i.opcode == spv::OpDecorate && i.words[2] == spv::DecorationArrayStride)
      strides[i.words[1]] = i.words[3];
    if (i.opcode == spv::OpMemberDecorate && i.words[3] == spv::DecorationOffset)
      offsets[i.words[1]][i.words[2]] = i.words[4];
  }
  Layout layout;
  for (const auto& [id, of] : offsets) {
    if (names[id] != name) continue;
    for (const auto& [member, offset] : of) layout.members[member_names[id][member]] = offset;
    for (const auto& [array, element] : element_of)
      if (element == id) layout.stride = strides[array];
  }
  return layout;
}

#define MEMBER(Type, name) \
  { #name, static_cast < std::uint32_t>(offsetof(shader::Type, name)) }

TEST(SharedLayout, Bone) {
  const Layout layout = layout_in(shader::module_of("skin"), "Bone");
  EXPECT_EQ(layout.members,
            (Members{MEMBER(Bone, xx), MEMBER(Bone, xy), MEMBER(Bone, xz), MEMBER(Bone, xt), MEMBER(Bone, yx),
                     MEMBER(Bone, yy), MEMBER(Bone, yz), MEMBER(Bone, yt), MEMBER(Bone, zx), MEMBER(Bone, zy),
                     MEMBER(Bone, zz), MEMBER(Bone, zt), MEMBER(Bone, gravity_x), MEMBER(Bone, gravity_y),
                     MEMBER(Bone, gravity_z), MEMBER(Bone, unused)}));
  EXPECT_EQ(layout.stride, sizeof(shader::Bone));
}

TEST(SharedLayout, Muscle) {
  const Layout layout = layout_in(shader::module_of("region"), "Muscle");
  EXPECT_EQ(layout.members, (Members{MEMBER(Muscle, tau_x), MEMBER(Muscle, tau_y), MEMBER(Muscle, tau_z),
                                     MEMBER(Muscle, swell), MEMBER(Muscle, twist)}));
  EXPECT_EQ(layout.stride, sizeof(shader::Muscle));
}

TEST(SharedLayout, RegionMuscle) {
  const Layout layout = layout_in(shader::module_of("region"), "RegionMuscle");
  EXPECT_EQ(layout.members, (Members{MEMBER(RegionMuscle, muscle), MEMBER(RegionMuscle, bulge),
                                     MEMBER(RegionMuscle, shear)}));
  EXPECT_EQ(layout.stride, sizeof(shader::RegionMuscle));
}

TEST(SharedLayout, RegionFrame) {
  const Layout layout = layout_in(shader::module_of("region"), "RegionFrame");
  EXPECT_EQ(
      layout.members,
      (Members{MEMBER(RegionFrame, normal_x), MEMBER(RegionFrame, normal_y), MEMBER(RegionFrame, normal_z),
               MEMBER(RegionFrame, axis_x), MEMBER(RegionFrame, axis_y), MEMBER(RegionFrame, axis_z),
               MEMBER(RegionFrame, around_x), MEMBER(RegionFrame, around_y), MEMBER(RegionFrame, around_z)}));
  EXPECT_EQ(layout.stride, sizeof(shader::RegionFrame));
}

TEST(SharedLayout, Force) {
  const Layout layout = layout_in(shader::module_of("predict"), "Force");
  EXPECT_EQ(layout.members,
            (Members{MEMBER(Force, x), MEMBER(Force, y), MEMBER(Force, z), MEMBER(Force, unused)}));
  EXPECT_EQ(layout.stride, sizeof(shader::Force));
}

TEST(SharedLayout, Tie) {
  const Layout layout = layout_in(shader::module_of("tie"), "Tie");
  EXPECT_EQ(layout.members, (Members{MEMBER(Tie, sliding), MEMBER(Tie, corner_a), MEMBER(Tie, corner_b),
                                     MEMBER(Tie, corner_c), MEMBER(Tie, mobility_a), MEMBER(Tie, mobility_b),
                                     MEMBER(Tie, mobility_c), MEMBER(Tie, rest_height)}));
  EXPECT_EQ(layout.stride, sizeof(shader::Tie));
}

TEST(SharedLayout, Limit) {
  const Layout layout = layout_in(shader::module_of("limit"), "Limit");
  EXPECT_EQ(layout.members,
            (Members{MEMBER(Limit, corner_a), MEMBER(Limit, corner_b), MEMBER(Limit, corner_c),
                     MEMBER(Limit, corner_d), MEMBER(Limit, inverse_size), MEMBER(Limit, size),
                     MEMBER(Limit, least), MEMBER(Limit, least_square)}));
  EXPECT_EQ(layout.stride, sizeof(shader::Limit));
}

TEST(SharedLayout, ContactPoint) {
  const Layout layout = layout_in(shader::module_of("contact_find"), "ContactPoint");
  EXPECT_EQ(layout.members, (Members{MEMBER(ContactPoint, vertex), MEMBER(ContactPoint, margin),
                                     MEMBER(ContactPoint, allowance), MEMBER(ContactPoint, friction),
                                     MEMBER(ContactPoint, first_near), MEMBER(ContactPoint, near_count)}));
  EXPECT_EQ(layout.stride, sizeof(shader::ContactPoint));
}

TEST(SharedLayout, VertexRun) {
  const Layout layout = layout_in(shader::module_of("contact_find"), "VertexRun");
  EXPECT_EQ(layout.members, (Members{MEMBER(VertexRun, first), MEMBER(VertexRun, end)}));
  EXPECT_EQ(layout.stride, sizeof(shader::VertexRun));
}

TEST(SharedLayout, Collider) {
  const Layout layout = layout_in(shader::module_of("collide"), "Collider");
  EXPECT_EQ(layout.members,
            (Members{MEMBER(Collider, xx),        MEMBER(Collider, xy),        MEMBER(Collider, xz),
                     MEMBER(Collider, xt),        MEMBER(Collider, yx),        MEMBER(Collider, yy),
                     MEMBER(Collider, yz),        MEMBER(Collider, yt),        MEMBER(Collider, zx),
                     MEMBER(Collider, zy),        MEMBER(Collider, zz),        MEMBER(Collider, zt),
                     MEMBER(Collider, before_xx), MEMBER(Collider, before_xy), MEMBER(Collider, before_xz),
                     MEMBER(Collider, before_xt), MEMBER(Collider, before_yx), MEMBER(Collider, before_yy),
                     MEMBER(Collider, before_yz), MEMBER(Collider, before_yt), MEMBER(Collider, before_zx),
                     MEMBER(Collider, before_zy), MEMBER(Collider, before_zz), MEMBER(Collider, before_zt),
                     MEMBER(Collider, half_x),    MEMBER(Collider, half_y),    MEMBER(Collider, half_z),
                     MEMBER(Collider, radius),    MEMBER(Collider, friction),  MEMBER(Collider, lifted),
                     MEMBER(Collider, is_plane),  MEMBER(Collider, unused)}));
  EXPECT_EQ(layout.stride, sizeof(shader::Collider));
}

TEST(SharedLayout, SubstepAndPush) {
  const Layout substep = layout_in(shader::module_of("update"), "Substep");
  EXPECT_EQ(substep.members,
            (Members{MEMBER(Substep, h), MEMBER(Substep, inverse_h), MEMBER(Substep, gravity_x),
                     MEMBER(Substep, gravity_y), MEMBER(Substep, gravity_z), MEMBER(Substep, shift_x),
                     MEMBER(Substep, shift_y), MEMBER(Substep, shift_z), MEMBER(Substep, vertex_count),
                     MEMBER(Substep, surface_count), MEMBER(Substep, joint_count),
                     MEMBER(Substep, first_bone), MEMBER(Substep, first_muscle), MEMBER(Substep, first_force),
                     MEMBER(Substep, contact_count), MEMBER(Substep, contact_tetrahedron_count),
                     MEMBER(Substep, first_collider), MEMBER(Substep, collider_count)}));
  const Layout push = layout_in(shader::module_of("update"), "Push");
  EXPECT_EQ(push.members,
            (Members{MEMBER(Push, substep), MEMBER(Push, first_slice), MEMBER(Push, implicit)}));
}

}  // namespace
}  // namespace fascicle::tests
