// fascicle-bench-bullet KIND NX NY NZ SUBSTEPS: Bullet's soft bodies on the bar of `fascicle bench`, timed on
// one thread. Prints nanoseconds per vertex and substep on stderr; its caller reads the last line.
//
// KIND: bullet-clusters, shape matching of overlapping clusters, one per one-ring, the closest that Bullet
// has to our regions; bullet-links, springs along the tetrahedra's edges.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include "host/base/process_start.h"

namespace {

constexpr btScalar h = btScalar(1.0 / 600.0);

struct Bar {
  std::vector<btVector3> points;
  std::vector<std::set<int>> rings;
};

// Kuhn's tetrahedra connect a grid point with the seven others of its cell.
Bar make_bar(const std::array<int, 3>& count) {
  Bar bar;
  const auto number = [&](int x, int y, int z) { return (x * count[1] + y) * count[2] + z; };
  for (int x = 0; x < count[0]; ++x)
    for (int y = 0; y < count[1]; ++y)
      for (int z = 0; z < count[2]; ++z)
        bar.points.emplace_back(btScalar(0.1 * x / (count[0] - 1)), btScalar(0.5 * y / (count[1] - 1)),
                                btScalar(0.1 * z / (count[2] - 1)));
  bar.rings.resize(bar.points.size());
  for (int x = 0; x < count[0]; ++x)
    for (int y = 0; y < count[1]; ++y)
      for (int z = 0; z < count[2]; ++z)
        for (int step = 1; step < 8; ++step) {
          const int a = x + (step & 1), b = y + (step >> 1 & 1), c = z + (step >> 2 & 1);
          if (a >= count[0] || b >= count[1] || c >= count[2]) continue;
          const int i = number(x, y, z), j = number(a, b, c);
          bar.rings[static_cast<std::size_t>(i)].insert(j);
          bar.rings[static_cast<std::size_t>(j)].insert(i);
        }
  return bar;
}

void add_links(btSoftBody& body, const Bar& bar) {
  for (int i = 0; i < static_cast<int>(bar.rings.size()); ++i)
    for (const int j : bar.rings[static_cast<std::size_t>(i)])
      if (i < j) body.appendLink(i, j);
}

void add_clusters(btSoftBody& body, const Bar& bar) {
  body.m_clusters.resize(static_cast<int>(bar.rings.size()));
  for (int r = 0; r < body.m_clusters.size(); ++r) {
    auto* cluster = new (btAlignedAlloc(sizeof(btSoftBody::Cluster), 16)) btSoftBody::Cluster();
    cluster->m_collide = false;
    cluster->m_matching = btScalar(0.5);
    cluster->m_nodes.push_back(&body.m_nodes[r]);
    for (const int j : bar.rings[static_cast<std::size_t>(r)]) cluster->m_nodes.push_back(&body.m_nodes[j]);
    body.m_clusters[r] = cluster;
  }
  body.initializeClusters();
  body.updateClusters();
}

double measure(const std::string& kind, const std::array<int, 3>& count, int substeps) {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity(btVector3(0, btScalar(-9.81), 0));
  world.getWorldInfo().m_gravity = btVector3(0, btScalar(-9.81), 0);

  const Bar bar = make_bar(count);
  auto* body =
      new btSoftBody(&world.getWorldInfo(), static_cast<int>(bar.points.size()), bar.points.data(), nullptr);
  if (kind == "bullet-links") add_links(*body, bar);
  body->setTotalMass(5, false);
  for (int i = 0; i < body->m_nodes.size(); ++i)
    if (bar.points[static_cast<std::size_t>(i)].y() > btScalar(0.4999)) body->setMass(i, 0);
  // No collisions, one iteration of each kind: this times one substep.
  body->m_cfg.collisions = 0;
  body->m_cfg.piterations = kind == "bullet-links" ? 1 : 0;
  body->m_cfg.viterations = body->m_cfg.citerations = body->m_cfg.diterations = 0;
  if (kind == "bullet-clusters") add_clusters(*body, bar);
  world.addSoftBody(body);

  const auto step = [&] { world.stepSimulation(h, 0, h); };
  step();
  const auto start = std::chrono::steady_clock::now();
  for (int k = 0; k < substeps; ++k) step();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;

  // A body that has not moved, or is not finite, has not been stepped.
  const btVector3 tip = body->m_nodes[0].m_x - bar.points[0];
  const bool moved = tip.length() > 0 && tip.length() < btScalar(1);
  world.removeSoftBody(body);
  delete body;
  if (!moved) return -1.0;
  return seconds.count() * 1e9 / substeps / static_cast<double>(bar.points.size());
}

}  // namespace

int main(int argc, char** argv) {
  fascicle::base::open_standard_streams();
  const std::string kind = argc == 6 ? argv[1] : "";
  if (kind != "bullet-clusters" && kind != "bullet-links") {
    std::fprintf(stderr, "usage: fascicle-bench-bullet bullet-clusters|bullet-links NX NY NZ SUBSTEPS\n");
    return 2;
  }
  std::array<int, 3> count{};
  for (std::size_t k = 0; k < 3; ++k) count[k] = std::max(2, std::atoi(argv[2 + k]));
  const double nanoseconds = measure(kind, count, std::max(1, std::atoi(argv[5])));
  if (nanoseconds < 0.0) {
    std::fprintf(stderr, "the body did not move as a falling one does\n");
    return 1;
  }
  std::fprintf(stderr, "%.6g\n", nanoseconds);
  return 0;
}
