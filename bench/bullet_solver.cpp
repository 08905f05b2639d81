#include "bench/bullet_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <span>
#include <stdexcept>
#include <utility>

#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btDeformableNeoHookeanForce.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <btBulletDynamicsCommon.h>

#include "host/formats/surface.h"

namespace fascicle::bench {
namespace {

using Point = std::array<double, 3>;
using Forces = btDeformableLagrangianForce::TVStack;

btVector3 vector_of(const Point& p) {
  return {btScalar(p[0]), btScalar(p[1]), btScalar(p[2])};
}

double component(const btVector3& v, std::size_t axis) {
  return double{v.m_floats[axis]};
}

// Bullet uses one number for all bodies and has no setter for it.
struct DeformableSolver : btDeformableBodySolver {
  explicit DeformableSolver(int newton_steps) { m_maxNewtonIterations = newton_steps; }
};

// A box that represents a plane: one of its sides lies in the plane.
struct Plate {
  static constexpr btScalar width = 1, depth = btScalar(0.25);  // half sizes, m
  btBoxShape shape{btVector3(width, depth, width)};
  btRigidBody body{btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &shape)};
};

// The Lamé parameters of a modulus E.
struct Lame {
  double mu, lambda;
};
Lame lame_of(double E, double poisson) {
  return {E / (2.0 * (1.0 + poisson)), E * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))};
}

std::unique_ptr<btDeformableLagrangianForce> make_force(double E, const BulletSettings& settings) {
  Lame lame = lame_of(E, settings.poisson);
  if (settings.linear)
    return std::make_unique<btDeformableLinearElasticityForce>(btScalar(lame.mu), btScalar(lame.lambda),
                                                               btScalar(0), btScalar(settings.viscosity));
  // Smith, de Goes and Kim 2018, "Stable Neo-Hookean flesh simulation", section 3.4: at rest this law is as
  // stiff as linear elasticity with three quarters of its mu.
  if (settings.converts) lame = {lame.mu * 4.0 / 3.0, lame.lambda + lame.mu * 5.0 / 6.0};
  return std::make_unique<btDeformableNeoHookeanForce>(btScalar(lame.mu), btScalar(lame.lambda),
                                                       btScalar(settings.viscosity));
}

}  // namespace

struct BulletSolver::Impl {
  Impl(const model::Model& of, const BulletSettings& with);
  ~Impl();

  void number_nodes();
  void make_body();
  void place_plates(const model::Drive& drive, std::uint32_t substep, bool is_first);
  void skin(const model::Drive& drive, std::uint32_t substep);
  void step(const model::Drive& drive, std::uint32_t substep);
  btSoftBody::Node& node(std::size_t vertex) const { return body->m_nodes[node_of[vertex]]; }
  // Convert working units relative to a frame's origin to metres relative to `origin`, and back.
  Point metres(const float* p, const Point& frame_origin) const;
  float working(double metre, std::size_t axis, const Point& frame_origin) const {
    return static_cast<float>((metre + origin[axis] - frame_origin[axis]) / model.unit);
  }
  std::vector<float> positions(const Point& frame_origin) const;
  std::vector<float> velocities() const;
  std::vector<float> skinned_positions(const Point& frame_origin) const;

  const model::Model& model;
  const BulletSettings settings;
  std::vector<int> node_of;                                    // per vertex
  Point origin{0, 0, 0}, last_origin{};                        // m: of Bullet's world; of the last frame
  std::vector<Point> skinned, carried_velocity, acceleration;  // m, m/s, m/s^2, per vertex
  std::uint64_t frame = 0;
  bool has_plates = false;
  std::deque<model::Frame> done;

  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  DeformableSolver deformable_solver;
  btDeformableMultiBodyConstraintSolver constraint_solver;
  std::unique_ptr<btDeformableMultiBodyDynamicsWorld> world;
  std::unique_ptr<btDeformableLagrangianForce> force;
  std::vector<std::unique_ptr<Plate>> plates;
  std::unique_ptr<btSoftBody> body;
};

BulletSolver::Impl::Impl(const model::Model& of, const BulletSettings& with)
    : model(of), settings(with), deformable_solver(with.newton_steps) {
  if (!model.is_implicit() || model.force_count > 0 || model.muscle_count > 0)
    throw std::invalid_argument("BulletSolver: the model is explicit, or has forces or muscles");
  constraint_solver.setDeformableSolver(&deformable_solver);
  world = std::make_unique<btDeformableMultiBodyDynamicsWorld>(&dispatcher, &broadphase, &constraint_solver,
                                                               &configuration, &deformable_solver);
  world->setGravity(btVector3(0, 0, 0));
  world->getWorldInfo().m_gravity.setZero();
  world->setImplicit(settings.implicit);
  world->setLineSearch(settings.line_search);
  world->setUseProjection(settings.projects);
  btContactSolverInfo& info = world->getSolverInfo();
  info.m_splitImpulse = true;
  info.m_deformable_erp = btScalar(settings.error_reduction);
  info.m_numIterations = settings.contact_iterations;
  number_nodes();
  make_body();
  world->addSoftBody(body.get());
  world->addForce(body.get(), force.get());
  // Plates are added to the world once the first drive gives their positions.
  for (std::uint32_t k = 0; k < model.collider_count; ++k) plates.push_back(std::make_unique<Plate>());
}

BulletSolver::Impl::~Impl() {
  if (has_plates)
    for (const auto& plate : plates) world->removeRigidBody(&plate->body);
  world->removeSoftBody(body.get());
}

// Free vertices first: if massless nodes come before others, Bullet 3.24 applies forces to the wrong nodes
// when it predicts contact, because applyForce counts only nodes with mass.
void BulletSolver::Impl::number_nodes() {
  node_of.resize(model.vertex_count);
  int count = 0;
  for (const bool kinematic : {false, true})
    for (std::uint32_t i = 0; i < model.vertex_count; ++i)
      if (model.is_kinematic(i) == kinematic) node_of[i] = count++;
}

void BulletSolver::Impl::make_body() {
  std::vector<btVector3> rest(model.vertex_count);
  for (std::size_t i = 0; i < model.vertex_count; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      rest[static_cast<std::size_t>(node_of[i])][static_cast<int>(axis)] =
          btScalar(model.unit * double{model.rest[3 * i + axis]});
  body = std::make_unique<btSoftBody>(&world->getWorldInfo(), static_cast<int>(rest.size()), rest.data(),
                                      nullptr);
  // Tetrahedra with a free vertex first: of the others only the faces are needed.
  std::vector<std::size_t> entries;
  std::size_t free_count = 0;
  for (const bool is_held : {false, true}) {
    for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4) {
      const bool held = std::all_of(&model.tetrahedron[t], &model.tetrahedron[t] + 4,
                                    [&](std::uint32_t i) { return model.is_kinematic(i); });
      if (held == is_held) entries.push_back(t);
    }
    if (!is_held) free_count = entries.size();
  }
  const auto corner = [&](std::size_t entry) { return node_of[model.tetrahedron[entry]]; };
  for (const std::size_t t : entries)
    body->appendTetra(corner(t), corner(t + 1), corner(t + 2), corner(t + 3));
  // The links exert no force, but Bullet uses them to connect nodes when it builds its tree, and does not
  // terminate without them.
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    for (std::uint32_t e = model.ring_offset[i]; e < model.ring_offset[i + 1]; ++e)
      if (i < model.ring[e]) body->appendLink(node_of[i], node_of[model.ring[e]]);
  btSoftBodyHelpers::generateBoundaryFaces(body.get());
  entries.resize(free_count);
  body->m_tetras.resize(static_cast<int>(free_count));
  body->initializeDmInverse();
  body->m_tetraScratches.resize(body->m_tetras.size());
  body->m_tetraScratchesTn.resize(body->m_tetras.size());
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    body->setMass(node_of[i], model.is_kinematic(i) ? 0 : btScalar(model.mass[i]));
  // A Bullet world has one elastic law of each type for all tetrahedra, weighted by their volume. Nothing
  // else uses that volume, because nodes have their masses already, so it is scaled by the tetrahedron's
  // modulus.
  const double E = *std::ranges::max_element(model.youngs_modulus);
  for (std::size_t t = 0; t < entries.size(); ++t) {
    double own = 0.0;
    for (std::size_t k = 0; k < 4; ++k) own += model.youngs_modulus[model.tetrahedron[entries[t] + k]] / 4.0;
    body->m_tetras[static_cast<int>(t)].m_element_measure *= btScalar(own / E);
  }
  force = make_force(E, settings);
  using Collision = btSoftBody::fCollision;
  body->m_cfg.collisions = Collision::SDF_RD | Collision::SDF_RDN | (settings.self ? Collision::VF_DD : 0);
  body->setSelfCollision(settings.self);
  body->getCollisionShape()->setMargin(btScalar(settings.margin));
  body->m_cfg.kDF = btScalar(std::sqrt(settings.self_friction));  // Bullet multiplies the coefficients of
                                                                  // both sides
  body->m_cfg.kCHR = body->m_cfg.kKHR = 1;
  body->setSpringStiffness(btScalar(settings.repulsion));
  // Otherwise Bullet stops slow bodies.
  body->m_sleepingThreshold = 0;
  body->setActivationState(DISABLE_DEACTIVATION);
}

Point BulletSolver::Impl::metres(const float* p, const Point& frame_origin) const {
  Point result;
  for (std::size_t axis = 0; axis < 3; ++axis)
    result[axis] = model.unit * double{p[axis]} + frame_origin[axis] - origin[axis];
  return result;
}

// Contact keeps flesh one margin away from a side, so the side is placed one margin behind the plane.
void BulletSolver::Impl::place_plates(const model::Drive& drive, std::uint32_t substep, bool is_first) {
  for (std::uint32_t k = 0; k < model.collider_count; ++k) {
    const shader::Collider& c = drive.colliders[std::size_t{substep} * model.collider_count + k];
    if (!(c.is_plane > 0.0f)) throw std::invalid_argument("BulletSolver: a solid that is no plane");
    btRigidBody& plate = plates[k]->body;
    const auto place = [&](const btMatrix3x3& to_own, const Point& shift) {
      const btMatrix3x3 axes = to_own.transpose();
      const double height = model.unit * double{c.radius} - settings.margin - double{Plate::depth};
      btVector3 own(btScalar(-model.unit * shift[0]), btScalar(height - model.unit * shift[1]),
                    btScalar(-model.unit * shift[2]));
      const Point from{drive.origin[0] - origin[0], drive.origin[1] - origin[1], drive.origin[2] - origin[2]};
      return btTransform(axes, axes * own + vector_of(from));
    };
    if (is_first) {
      const btTransform before = place({c.before_xx, c.before_xy, c.before_xz, c.before_yx, c.before_yy,
                                        c.before_yz, c.before_zx, c.before_zy, c.before_zz},
                                       {c.before_xt, c.before_yt, c.before_zt});
      plate.setWorldTransform(before);
      plate.setInterpolationWorldTransform(before);
      plate.setCollisionFlags(plate.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
      plate.setActivationState(DISABLE_DEACTIVATION);
      world->addRigidBody(&plate);
    }
    // Bullet derives the velocity from the previous position.
    plate.setWorldTransform(
        place({c.xx, c.xy, c.xz, c.yx, c.yy, c.yz, c.zx, c.zy, c.zz}, {c.xt, c.yt, c.zt}));
    plate.setFriction(body->m_cfg.kDF > 0 ? btScalar(double{c.friction} / double{body->m_cfg.kDF}) : 0);
  }
  has_plates = has_plates || model.collider_count > 0;
}

// The skinned position and velocity of each vertex at the end of the substep, and the acceleration of gravity
// there.
void BulletSolver::Impl::skin(const model::Drive& drive, std::uint32_t substep) {
  for (std::size_t i = 0; i < model.vertex_count; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      acceleration[i][axis] = model.unit * double{drive.gravity[axis]};
  if (!model.has_skeleton()) return;
  const shader::Bone* bones = drive.bones.data() + std::size_t{substep} * model.joint_count;
  for (std::size_t i = 0; i < model.vertex_count; ++i) {
    const double x = double{model.rest[3 * i]}, y = double{model.rest[3 * i + 1]},
                 z = double{model.rest[3 * i + 2]};
    Point place{0, 0, 0};
    for (std::uint32_t e = model.skin_offset[i]; e < model.skin_offset[i + 1]; ++e) {
      const shader::Bone& b = bones[model.skin_joint[e]];
      const double w = double{model.skin_weight[e]};
      place[0] += w * (b.xx * x + b.xy * y + b.xz * z + double{b.xt});
      place[1] += w * (b.yx * x + b.yy * y + b.yz * z + double{b.yt});
      place[2] += w * (b.zx * x + b.zy * y + b.zz * z + double{b.zt});
      acceleration[i][0] += w * model.unit * double{b.gravity_x};
      acceleration[i][1] += w * model.unit * double{b.gravity_y};
      acceleration[i][2] += w * model.unit * double{b.gravity_z};
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double now = model.unit * place[axis] + drive.origin[axis] - origin[axis];
      carried_velocity[i][axis] = (now - skinned[i][axis]) / drive.h;
      skinned[i][axis] = now;
    }
  }
}

void BulletSolver::Impl::step(const model::Drive& drive, std::uint32_t substep) {
  skin(drive, substep);
  place_plates(drive, substep, !has_plates);
  const auto h = btScalar(drive.h);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    btSoftBody::Node& n = node(i);
    const btVector3 u = vector_of(carried_velocity[i]);
    if (model.is_kinematic(i))
      n.m_v = model.has_skeleton() ? (vector_of(skinned[i]) - n.m_x) / h : btVector3(0, 0, 0);
    else
      n.m_v = u + (n.m_v + h * vector_of(acceleration[i]) - u) * btScalar(drive.decay[model.layer_of(i)]);
    n.m_vn = n.m_v;
  }
  world->stepSimulation(h, 0);
}

std::vector<float> BulletSolver::Impl::positions(const Point& frame_origin) const {
  std::vector<float> values(3 * std::size_t{model.vertex_count});
  for (std::size_t i = 0; i < model.vertex_count; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      values[3 * i + axis] = working(component(node(i).m_x, axis), axis, frame_origin);
  return values;
}

std::vector<float> BulletSolver::Impl::velocities() const {
  std::vector<float> values(3 * std::size_t{model.vertex_count});
  for (std::size_t i = 0; i < model.vertex_count; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      values[3 * i + axis] = static_cast<float>(component(node(i).m_v, axis) / model.unit);
  return values;
}

std::vector<float> BulletSolver::Impl::skinned_positions(const Point& frame_origin) const {
  std::vector<float> values(model.has_skeleton() ? 3 * skinned.size() : 0);
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = working(skinned[k / 3][k % 3], k % 3, frame_origin);
  return values;
}

BulletSolver::BulletSolver(const model::Model& model, const BulletSettings& settings)
    : impl_(std::make_unique<Impl>(model, settings)) {
  load(model::rest_state(model));
}
BulletSolver::~BulletSolver() = default;

void BulletSolver::submit(const model::Drive& drive, model::Read what, model::Probe* probe) {
  if (probe != nullptr) throw std::invalid_argument("BulletSolver: it has no stages to show");
  if (!drive.cuts.empty()) throw std::invalid_argument("BulletSolver: the motion breaks");
  model::check_drive(impl_->model, drive);
  for (std::uint32_t s = 0; s < drive.substeps; ++s) impl_->step(drive, s);
  impl_->last_origin = drive.origin;
  model::Frame frame{.index = ++impl_->frame,
                     .origin = drive.origin,
                     .positions = impl_->positions(drive.origin),
                     .velocities = {},
                     .surface = {}};
  if (what.velocities) frame.velocities = impl_->velocities();
  if (what.surface) frame.surface = formats::embed(impl_->model, frame.positions);
  if (what.skinned) frame.skinned = impl_->skinned_positions(drive.origin);
  impl_->done.push_back(std::move(frame));
}

model::Frame BulletSolver::collect() {
  model::Frame frame = std::move(impl_->done.front());
  impl_->done.pop_front();
  return frame;
}

model::State BulletSolver::save() const {
  model::State state = model::rest_state(impl_->model);
  state.frame = impl_->frame;
  state.origin = impl_->last_origin;
  state.positions = impl_->positions(state.origin);
  state.velocities = impl_->velocities();
  state.skinned = impl_->skinned_positions(state.origin);
  return state;
}

void BulletSolver::load(const model::State& state) {
  const model::Model& model = impl_->model;
  model::check_state(model, state);
  impl_->frame = state.frame;
  impl_->origin = impl_->last_origin = state.origin;
  impl_->done.clear();
  const std::size_t n = model.vertex_count;
  impl_->skinned.resize(n);
  impl_->carried_velocity.assign(n, Point{0, 0, 0});
  impl_->acceleration.assign(n, Point{0, 0, 0});
  for (std::size_t i = 0; i < n; ++i) {
    btSoftBody::Node& node = impl_->node(i);
    node.m_x = node.m_q = vector_of(impl_->metres(&state.positions[3 * i], state.origin));
    for (std::size_t axis = 0; axis < 3; ++axis)
      node.m_v[static_cast<int>(axis)] = btScalar(model.unit * double{state.velocities[3 * i + axis]});
    node.m_vn = node.m_v;
    if (model.has_skeleton()) impl_->skinned[i] = impl_->metres(&state.skinned[3 * i], state.origin);
  }
  impl_->body->updateBounds();
}

std::vector<double> BulletSolver::flesh_forces() {
  for (int k = 0; k < impl_->body->m_nodes.size(); ++k)
    impl_->body->m_nodes[k].m_q = impl_->body->m_nodes[k].m_x;
  impl_->body->updateDeformation();
  Forces forces;
  forces.resize(impl_->body->m_nodes.size(), btVector3(0, 0, 0));
  impl_->force->addScaledForces(1, forces);
  std::vector<double> values;
  for (std::size_t i = 0; i < impl_->model.vertex_count; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) values.push_back(component(forces[impl_->node_of[i]], axis));
  return values;
}

std::string bullet_version() {
  return std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100);
}

}  // namespace fascicle::bench
