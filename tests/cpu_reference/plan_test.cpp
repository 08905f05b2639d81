// Compares what the CPU's kernels access with the schedule: a field that a kernel does not write stays
// unchanged, and one that it does not read may contain anything.
#include <bit>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cpu_reference/solver/collide_reach.h"
#include "cpu_reference/solver/collide_stages.h"
#include "cpu_reference/solver/contact_stages.h"
#include "cpu_reference/solver/stages.h"
#include "host/model/implicit.h"
#include "host/model/substep_plan.h"
#include "tests/support/bar_model.h"

namespace fascicle::tests {
namespace {

namespace cpu = cpu_reference;
using cpu::Range;
using model::Field;
using model::Kernel;
using model::Model;

// Where a field's numbers are: either `first` or `first_whole` is set.
struct Place {
  float* first = nullptr;
  std::size_t count = 0, stride = 1, width = 1;
  std::uint32_t* first_whole = nullptr;

  // The bits of number k.
  float get(std::size_t k) const {
    return first != nullptr ? first[k] : std::bit_cast<float>(first_whole[k]);
  }
  void set(std::size_t k, float x) const {
    if (first != nullptr)
      first[k] = x;
    else
      first_whole[k] = std::bit_cast<std::uint32_t>(x);
  }
};

Place place_of(cpu::Fields& fields, Field field, const Model& m) {
  const auto in = [&](cpu::Floats& of, std::size_t stride, std::size_t place, std::size_t width) {
    return of.empty() ? Place{} : Place{of.data() + place, m.vertex_count, stride, width};
  };
  const auto numbers = [](std::vector<float>& of, std::size_t width) {
    return Place{of.data(), of.size() / width, width, width};
  };
  const auto wholes = [](std::vector<std::uint32_t>& of, std::size_t width) {
    return Place{nullptr, of.size() / width, width, width, of.data()};
  };
  const auto vectors = [&](cpu::Floats& of) { return in(of, cpu::vector_stride, 0, 3); };
  switch (field) {
    case Field::position:
      return in(fields.vertices, cpu::vertex_stride, 0, 3);
    case Field::velocity:
      return vectors(fields.velocities);
    case Field::rotation:
      return in(fields.regions, cpu::region_stride, cpu::rotation_place, 4);
    case Field::transform:
      return in(fields.regions, cpu::region_stride, 0, 12);
    case Field::goal:
      return vectors(fields.goals);
    case Field::skinned:
      return vectors(fields.skinned);
    case Field::skinned_before:
      return vectors(fields.skinned_before);
    case Field::skinned_velocity:
      return vectors(fields.skinned_velocities);
    case Field::gravity:
      return vectors(fields.gravity);
    case Field::surface:
      return {fields.surface.data(), fields.surface.size()};
    case Field::position_before:
      return vectors(fields.positions_before);
    case Field::velocity_before:
      return vectors(fields.velocities_before);
    case Field::predicted:
      return vectors(fields.predicted);
    case Field::iterate_before:
      return vectors(fields.iterate_before);
    case Field::tied:
      return vectors(fields.tied);
    case Field::lack:
      return {fields.lack.data(), fields.lack.size()};
    case Field::limit_load:
      return {fields.load.data(), fields.load.size()};
    case Field::contact_box:
      return numbers(fields.contact_box, 6);
    case Field::contact_branch_box:
      return numbers(fields.contact_branch_box, 6);
    case Field::contact_found:
      return wholes(fields.contact_found, 1);
    case Field::contact_place:
      return numbers(fields.contact_place, 10);
    case Field::contact_first:
      return wholes(fields.contact_first, 1);
    case Field::contact_next:
      return wholes(fields.contact_next, 1);
    case Field::contact_crowd:
      return numbers(fields.contact_crowd, 1);
    case Field::contact_impulse:
      return numbers(fields.contact_impulse, 3);
  }
  return {};
}

std::vector<Field> all_fields() {
  std::vector<Field> fields;
  for (std::uint32_t f = 0; f < model::field_count; ++f) fields.push_back(static_cast<Field>(f));
  return fields;
}

void for_each_number(const Place& place, const std::function<void(float&)>& change) {
  for (std::size_t i = 0; i < place.count; ++i)
    for (std::size_t k = 0; k < place.width; ++k) {
      float x = place.get(i * place.stride + k);
      change(x);
      place.set(i * place.stride + k, x);
    }
}

std::vector<float> numbers_of(const Place& place) {
  std::vector<float> numbers;
  for_each_number(place, [&](float& x) { numbers.push_back(x); });
  return numbers;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), 4 * a.size()) == 0);
}

struct PlanCase {
  explicit PlanCase(bool implicit)
      : model(make_bar({.x = 4,
                        .y = 3,
                        .z = 3,
                        .skeleton = true,
                        .carried = true,
                        .muscle = true,
                        .forces = true,
                        .volume = true,
                        .ties = true,
                        .implicit = implicit,
                        .limits = implicit,
                        .contact = true,
                        .colliders = true})),
        options{.integrator = implicit ? model::Integrator::implicit_step : model::Integrator::explicit_step},
        motion(model, 1),
        drive(motion.drive(3)) {
    in.step = model::first_substep(model, drive);
    in.step.shift_x = 0.25f;
    in.bones = drive.bones;
    in.muscles = drive.muscles;
    in.forces = drive.forces;
    in.colliders = drive.colliders;
    reaches = cpu_reference::reaches_of(in.colliders);
    in.reaches = reaches;
    in.decay = drive.decay;
    if (!implicit) return;
    tables = model::implicit_tables(model, options, drive.h);
    in.implicit = model::implicit_step(model, tables, true);
    // Every tetrahedron lacks volume, now and at the beginning of the substep, and regains part of it.
    for (shader::Limit& limit : model.limit) limit.least *= 2.0f;
    in.implicit.step = 1e-3f;
    in.implicit.gain = 0.75f;
    in.implicit.omega = 1.5f;
    in.responses = std::span<const shader::Response>(tables.responses)
                       .subspan(in.implicit.first_response, model.vertex_count);
  }

  static bool is_whole(Field f) {
    return f == Field::contact_found || f == Field::contact_first || f == Field::contact_next;
  }
  // Number k of a field of integers: some points have found nothing, some chains are empty, and every chain
  // ends.
  std::uint32_t whole(Field f, std::uint32_t k) const {
    const std::uint32_t tetrahedra = model.contact_tetrahedron_count();
    if (f == Field::contact_found) return k % (tetrahedra + 2);
    if (f == Field::contact_first) return k % (points().last + 2);
    return k % 3 == 0 ? shader::no_contact : k + 1;
  }

  // Fields of a body in motion: random numbers, with positions near rest.
  cpu::Fields fields() const {
    cpu::Fields made;
    size_fields(model, made);
    size_plain_contact_fields(model, made);
    for (cpu::Floats* field : {&made.predicted, &made.goals}) field->resize(made.velocities.size());
    std::mt19937 random(7);
    std::uniform_real_distribution<float> small(-0.004f, 0.004f);
    for (const Field f : all_fields()) {
      std::size_t k = 0;
      const bool is_place = f == Field::position || f == Field::goal || f == Field::skinned ||
                            f == Field::skinned_before || f == Field::position_before ||
                            f == Field::predicted || f == Field::iterate_before;
      for_each_number(place_of(made, f, model), [&](float& x) {
        x = small(random) + (is_place ? model.rest[k] : 0.0f);
        if (f == Field::rotation || f == Field::transform) x += k % 4 == 0 ? 1.0f : 0.0f;
        // Every third tetrahedron lacks volume.
        if (f == Field::lack) x = k % 3 == 0 ? 0.01f : 0.0f;
        if (f == Field::limit_load) x = 1.0f;
        if (f == Field::contact_box) x = k % 6 < 3 ? -1.0f : 1.0f;
        if (f == Field::contact_branch_box) x = k % 6 < 3 ? -2.0f : 2.0f;
        // More than the minimum that counts.
        if (f == Field::contact_crowd) x = 3.0f;
        if (is_whole(f)) x = std::bit_cast<float>(whole(f, static_cast<std::uint32_t>(k)));
        ++k;
      });
    }
    return made;
  }

  Range points() const { return {0, static_cast<std::uint32_t>(model.contact.size())}; }

  void run(Kernel kernel, cpu::Fields& fields) const {
    const Range vertices{0, model.vertex_count};
    switch (kernel) {
      case Kernel::rebase:
        return rebase(in, fields, vertices);
      case Kernel::skin:
        return skin(model, in, fields, vertices);
      case Kernel::tie:
        return tie(model, in, fields, vertices);
      case Kernel::contact_bound:
        return contact_bound(model, in, fields, {0, model.contact_leaf_count()});
      case Kernel::contact_enclose:
        return contact_enclose(model, in, fields, {0, model.contact_branch_count()});
      case Kernel::contact_find:
        return contact_find(model, in, fields, points());
      case Kernel::contact_chain:
        return contact_chain(model, in, fields, points());
      case Kernel::contact_crowd:
        return contact_crowd(model, in, fields, vertices);
      case Kernel::contact_hold:
        return contact_hold(model, in, fields, points());
      case Kernel::contact_yield:
        return contact_yield(model, in, fields, vertices);
      case Kernel::contact_settle:
        return contact_settle(model, in, fields, points());
      case Kernel::contact_rest:
        return contact_rest(model, in, fields, vertices);
      case Kernel::contact_press:
        return contact_press(model, in, fields, points());
      case Kernel::contact:
        return contact(model, in, fields, vertices);
      case Kernel::predict:
        return predict(model, in, fields, vertices);
      case Kernel::region:
        return region(model, in, fields, vertices);
      case Kernel::goal:
        return goal(model, in, fields, vertices);
      case Kernel::relax:
        return relax(model, in, fields, vertices);
      case Kernel::obstruct:
        return obstruct(model, in, fields, vertices);
      case Kernel::lack:
        return lack(model, in, fields, {0, static_cast<std::uint32_t>(model.limit.size())});
      case Kernel::crowd:
        return crowd(model, in, fields, vertices);
      case Kernel::limit: {
        // The CPU stores the moves of all tetrahedra here; on the GPU each corner computes them.
        const auto limits = static_cast<std::uint32_t>(model.limit.size());
        fields.terms.resize(12 * std::size_t{limits});
        for (std::uint32_t t = 0; t < limits; ++t) fields.term_place[t] = t;
        push(model, in, fields, {0, limits});
        return limit(model, in, fields, vertices);
      }
      case Kernel::collide:
        return collide(model, in, fields, vertices);
      case Kernel::integrate:
        return integrate(model, in, fields, vertices);
      case Kernel::update:
        return update(model, in, fields, vertices);
      case Kernel::iterate:
        return iterate(model, in, fields, vertices);
      case Kernel::embed:
        return embed(model, in, fields, {0, model.surface_count()});
    }
  }

  Model model;
  model::SolverOptions options;
  BarMotion motion;
  model::Drive drive;
  model::ImplicitTables tables;
  std::vector<cpu_reference::ColliderReach> reaches;
  cpu::SubstepInput in;
};

// The fields that a kernel changes, and those that its output depends on.
struct Touched {
  model::FieldSet reads, writes;
};

// Whether any field except `field` changes if all numbers of `field` are NaN.
bool is_read_for_others(Kernel kernel, Field field, const PlanCase& c, cpu::Fields& sound) {
  cpu::Fields fields = c.fields();
  for_each_number(place_of(fields, field, c.model),
                  [](float& x) { x = std::numeric_limits<float>::quiet_NaN(); });
  c.run(kernel, fields);
  for (const Field other : all_fields())
    if (other != field &&
        !same_bits(numbers_of(place_of(sound, other, c.model)), numbers_of(place_of(fields, other, c.model))))
      return true;
  return false;
}

// Whether any number of the field, changed beforehand, ends up as neither its usual result nor the changed
// value.
bool is_read_for_itself(Kernel kernel, Field field, const PlanCase& c, cpu::Fields& sound) {
  cpu::Fields fields = c.fields();
  for_each_number(place_of(fields, field, c.model), [](float& x) { x += 0.5f; });
  const std::vector<float> moved = numbers_of(place_of(fields, field, c.model));
  c.run(kernel, fields);
  const std::vector<float> before = numbers_of(place_of(sound, field, c.model)),
                           after = numbers_of(place_of(fields, field, c.model));
  for (std::size_t k = 0; k < after.size(); ++k)
    if (std::bit_cast<std::uint32_t>(after[k]) != std::bit_cast<std::uint32_t>(before[k]) &&
        std::bit_cast<std::uint32_t>(after[k]) != std::bit_cast<std::uint32_t>(moved[k]))
      return true;
  return false;
}

Touched touched_by(Kernel kernel, const PlanCase& c) {
  Touched touched;
  cpu::Fields before = c.fields(), after = c.fields();
  c.run(kernel, after);
  for (const Field f : all_fields()) {
    if (!same_bits(numbers_of(place_of(before, f, c.model)), numbers_of(place_of(after, f, c.model))))
      touched.writes = touched.writes | model::FieldSet{f};
    if (is_read_for_others(kernel, f, c, after) || is_read_for_itself(kernel, f, c, after))
      touched.reads = touched.reads | model::FieldSet{f};
  }
  return touched;
}

std::vector<Kernel> kernels_of_case(const PlanCase& c) {
  std::vector<Kernel> kernels = kernels_of(substep_plan(c.model, c.options, true));
  for (const Kernel k : kernels_of(substep_plan(c.model, c.options, false)))
    if (std::find(kernels.begin(), kernels.end(), k) == kernels.end()) kernels.push_back(k);
  kernels.push_back(Kernel::rebase);
  kernels.push_back(Kernel::embed);
  return kernels;
}

std::string names_of(model::FieldSet set) {
  std::string names;
  for (const Field f : all_fields())
    if (set.has(f)) names += (names.empty() ? "" : " ") + std::string(name_of(f));
  return names;
}

TEST(SubstepPlanOnTheCpu, KernelsTouchNothingElse) {
  model::FieldSet seen_reads[model::kernel_count], seen_writes[model::kernel_count];
  for (const bool implicit : {false, true}) {
    const PlanCase c(implicit);
    for (const Kernel kernel : kernels_of_case(c)) {
      SCOPED_TRACE(std::string(name_of(kernel)) + (implicit ? ", implicit" : ", explicit"));
      const model::KernelAccess& access = access_of(kernel);
      const Touched touched = touched_by(kernel, c);
      EXPECT_EQ(names_of(touched.writes.without(access.writes)), "") << "written, but not in the schedule";
      EXPECT_EQ(names_of(touched.reads.without(access.reads())), "") << "read, but not in the schedule";
      const auto k = static_cast<std::size_t>(kernel);
      seen_reads[k] = seen_reads[k] | touched.reads;
      seen_writes[k] = seen_writes[k] | touched.writes;
    }
  }
  // The schedule lists nothing that no kernel accesses: a superfluous access is a superfluous barrier.
  for (std::size_t k = 0; k < model::kernel_count; ++k) {
    const model::KernelAccess& access = access_of(static_cast<Kernel>(k));
    SCOPED_TRACE(std::string(access.name));
    EXPECT_EQ(names_of(access.writes.without(seen_writes[k])), "");
    EXPECT_EQ(names_of(access.reads().without(seen_reads[k])), "");
  }
}

// The vertices whose output changes if one vertex has NaN in a field.
std::vector<std::uint32_t> reached_from(Kernel kernel, Field field, std::uint32_t vertex, const PlanCase& c) {
  cpu::Fields sound = c.fields(), poisoned = c.fields();
  const Place place = place_of(poisoned, field, c.model);
  for (std::size_t k = 0; k < place.width; ++k)
    place.set(vertex * place.stride + k, std::numeric_limits<float>::quiet_NaN());
  c.run(kernel, sound);
  c.run(kernel, poisoned);
  std::vector<std::uint32_t> reached;
  for (std::uint32_t i = 0; i < c.model.vertex_count; ++i)
    for (const Field written : all_fields()) {
      const Place a = place_of(sound, written, c.model), b = place_of(poisoned, written, c.model);
      if (a.count != c.model.vertex_count || (written == field && i == vertex)) continue;
      bool same = true;
      for (std::size_t k = i * a.stride; k < i * a.stride + a.width; ++k)
        same = same && std::bit_cast<std::uint32_t>(a.get(k)) == std::bit_cast<std::uint32_t>(b.get(k));
      if (same) continue;
      reached.push_back(i);
      break;
    }
  return reached;
}

// Fields that a row lists as read at the vertex itself, or within its one-ring, are read nowhere else.
// Sweeps, and running a kernel's items in any order, depend on this.
TEST(SubstepPlanOnTheCpu, ReadsReachNoFurtherThanTheScheduleSays) {
  std::size_t own_seen = 0, ring_seen = 0;
  for (const bool implicit : {false, true}) {
    const PlanCase c(implicit);
    for (const Kernel kernel : kernels_of_case(c)) {
      const model::KernelAccess& access = access_of(kernel);
      if (access.items != model::KernelItems::vertices) continue;
      for (const Field field : all_fields()) {
        cpu::Fields fields = c.fields();
        if (access.any.has(field) || place_of(fields, field, c.model).count != c.model.vertex_count) continue;
        SCOPED_TRACE(std::string(access.name) + " reads " + std::string(name_of(field)));
        for (std::uint32_t vertex = 0; vertex < c.model.vertex_count; vertex += 5) {
          const auto first = c.model.ring.begin() + c.model.ring_offset[vertex];
          const auto last = c.model.ring.begin() + c.model.ring_offset[vertex + 1];
          for (const std::uint32_t i : reached_from(kernel, field, vertex, c)) {
            if (i == vertex) {
              ++own_seen;
              continue;
            }
            EXPECT_TRUE(access.ring.has(field)) << "read at another vertex";
            EXPECT_NE(std::find(first, last, i), last) << "beyond the one-ring";
            ++ring_seen;
          }
        }
      }
    }
  }
  EXPECT_GT(own_seen, 100u);
  EXPECT_GT(ring_seen, 100u);
}

// The control: ties and contacts reach further, and the same check shows it.
TEST(SubstepPlanOnTheCpu, TheReachOfTiesAndContactsIsSeen) {
  struct Far {
    Kernel kernel;
    Field field;
    bool implicit;
  };
  for (const auto& [kernel, field, implicit] : {Far{Kernel::tie, Field::position, false},
                                                {Kernel::contact, Field::contact_impulse, false},
                                                {Kernel::contact_yield, Field::contact_impulse, true},
                                                {Kernel::contact_rest, Field::contact_impulse, true}}) {
    const PlanCase c(implicit);
    bool is_beyond = false;
    for (std::uint32_t vertex = 0; vertex < c.points().last; ++vertex)
      for (const std::uint32_t i : reached_from(kernel, field, vertex, c)) {
        const std::uint32_t from = field == Field::contact_impulse ? c.model.contact[vertex].vertex : vertex;
        const auto first = c.model.ring.begin() + c.model.ring_offset[from];
        const auto last = c.model.ring.begin() + c.model.ring_offset[from + 1];
        is_beyond = is_beyond || (i != from && std::find(first, last, i) == last);
      }
    EXPECT_TRUE(is_beyond) << name_of(kernel);
  }
}

// The error for a kernel that was added only to the schedule. `lack` has its own code instead of a row.
TEST(SubstepPlanOnTheCpu, AKernelWithoutCodeIsToldWhereItBelongs) {
  try {
    cpu::code_of(Kernel::lack, PlanCase(false).model, model::Rotation::qcp);
    ADD_FAILURE() << "not refused";
  } catch (const std::logic_error& error) {
    EXPECT_STREQ(error.what(), "kernel lack has no row in kernel_code (cpu_reference/solver/stages.cpp)");
  }
}

// The control: a kernel compared with another kernel's row must differ.
TEST(SubstepPlanOnTheCpu, TheCheckSeesWhatIsMissing) {
  const PlanCase c(true);
  const Touched touched = touched_by(Kernel::region, c);
  EXPECT_FALSE(touched.writes.without(access_of(Kernel::goal).writes).empty());
  EXPECT_FALSE(touched.reads.without(access_of(Kernel::goal).reads()).empty());
}

}  // namespace
}  // namespace fascicle::tests
