// Bullet's two methods of moving cloth: position-based soft bodies, and deformable bodies with
// forces.
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "bench/medians.h"
#include "bench/peers/cloth_peer.h"

namespace weft::bench {

namespace {

btVector3 vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

// The parts that every world of Bullet needs.
struct Ground {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
};

// Makes nodes and links with the given rest lengths. Without m_bUpdateRtCst = false, Bullet would
// replace these by the lengths at the first step.
std::unique_ptr<btSoftBody> make_body(const ClothProblem& problem, btSoftBodyWorldInfo& info) {
  std::vector<btVector3> position;
  for (const auto& p : problem.position) position.push_back(vector(p));
  auto body = std::make_unique<btSoftBody>(&info, static_cast<int>(position.size()),
                                           position.data(), problem.mass.data());
  for (int i = 0; i < body->m_nodes.size(); ++i) {
    body->m_nodes[i].m_v = body->m_nodes[i].m_vn = vector(problem.velocity[i]);
  }
  for (const ClothSpring& spring : problem.springs) {
    body->appendLink(spring.ends[0], spring.ends[1]);
    btSoftBody::Link& link = body->m_links[body->m_links.size() - 1];
    link.m_rl = spring.rest_length;
    link.m_c1 = spring.rest_length * spring.rest_length;
  }
  body->m_bUpdateRtCst = false;
  body->m_cfg.collisions = 0;
  body->setActivationState(DISABLE_DEACTIVATION);
  return body;
}

// The ball, in a world of soft bodies. Nodes of the cloth collide with its signed distance, which
// is Bullet's usual contact of soft with rigid bodies.
class Ball {
 public:
  Ball(const ClothBall& ball, btSoftRigidDynamicsWorld& world, btSoftBody& cloth)
      : shape_(ball.radius),
        body_(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &shape_)),
        world_(world),
        used_(ball.radius > 0) {
    if (!used_) return;
    body_.setWorldTransform(btTransform(btQuaternion::getIdentity(), vector(ball.centre)));
    body_.setFriction(1);
    world_.addRigidBody(&body_);
    cloth.m_cfg.collisions = btSoftBody::fCollision::SDF_RS;
    cloth.m_cfg.kDF = ball.friction;
    cloth.getCollisionShape()->setMargin(ball.gap);
  }
  ~Ball() {
    if (used_) world_.removeRigidBody(&body_);
  }
  Ball(const Ball&) = delete;
  Ball& operator=(const Ball&) = delete;

 private:
  btSphereShape shape_;
  btRigidBody body_;
  btSoftRigidDynamicsWorld& world_;
  bool used_;
};

template <class World>
ClothOutcome run(World& world, const btSoftBody& body, const ClothSettings& settings) {
  ClothOutcome outcome;
  const double start = seconds(CLOCK_PROCESS_CPUTIME_ID);
  for (long i = 0; i < settings.steps && outcome.failure.empty(); ++i) {
    world.stepSimulation(settings.step, 0);
    outcome.cpu = seconds(CLOCK_PROCESS_CPUTIME_ID) - start;
    if (outcome.cpu > settings.budget) outcome.failure = "over the budget";
  }
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btVector3& x = body.m_nodes[i].m_x;
    if (!std::isfinite(x.length2())) outcome.failure = "not finite";
    outcome.position.push_back({x.x(), x.y(), x.z()});
  }
  return outcome;
}

// Runs position-based cloth. One iteration moves a link of fraction kLST by kLST of the distance to
// its rest length. Implicit Euler leaves the share 1 / (1 + s), s = k h^2 (1/m_a + 1/m_b), of the
// stretch that gravity and inertia alone would give a spring. kLST is chosen so that n iterations
// leave the same share.
ClothOutcome run_soft_body(const ClothProblem& problem, const ClothSettings& settings) {
  Ground ground;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world(&ground.dispatcher, &ground.broadphase, &solver,
                                 &ground.configuration);
  world.setGravity(vector(problem.gravity));
  world.getWorldInfo().m_gravity = vector(problem.gravity);
  const auto body = make_body(problem, world.getWorldInfo());
  for (int i = 0; i < body->m_links.size(); ++i) {
    btSoftBody::Link& link = body->m_links[i];
    const double inverse_mass = link.m_n[0]->m_im + link.m_n[1]->m_im;
    const double s = problem.springs[i].stiffness * settings.step * settings.step * inverse_mass;
    link.m_c0 = inverse_mass / (1 - std::pow(1 + s, -1.0 / settings.iterations));
  }
  body->m_cfg.piterations = settings.iterations;
  const Ball ball(problem.ball, world, *body);
  const int group = problem.ball.radius > 0 ? btBroadphaseProxy::DefaultFilter : 0;
  const int mask = problem.ball.radius > 0 ? btBroadphaseProxy::AllFilter : 0;
  world.addSoftBody(body.get(), group, mask);
  ClothOutcome outcome = run(world, *body, settings);
  world.removeSoftBody(body.get());
  return outcome;
}

// Gives access to protected settings of Bullet. By default it stops Newton's method after five
// iterations, and conjugate gradients at a residual of the order of rounding.
struct DeformableSolver : btDeformableBodySolver {
  explicit DeformableSolver(const ClothSettings& settings) {
    m_maxNewtonIterations = settings.iterations;
    if (settings.tolerance > 0) m_cg.m_tolerance = settings.tolerance;
  }
};

// Makes the springs. Bullet has two stiffnesses, one of most links and one of "bending" links.
btDeformableMassSpringForce make_springs(const ClothProblem& problem, btSoftBody& body) {
  const double first = problem.springs.at(0).stiffness;
  double second = first;
  for (int i = 0; i < body.m_links.size(); ++i) {
    const double own = problem.springs[i].stiffness;
    if (own == first) continue;
    if (second != first && own != second)
      throw std::invalid_argument("springs of more than two stiffnesses");
    second = own;
    body.m_links[i].m_bbending = -1;  // a bit field of one bit
  }
  return {first, 0, true, second};
}

// Runs deformable cloth. Without Bullet's projection, pinned nodes make its linear solver fail, and
// nothing moves.
ClothOutcome run_deformable(const ClothProblem& problem, const ClothSettings& settings,
                            bool implicit) {
  if (problem.ball.radius > 0) throw std::invalid_argument("a ball beside deformable bodies");
  Ground ground;
  DeformableSolver solver(settings);
  btDeformableMultiBodyConstraintSolver constraint_solver;
  constraint_solver.setDeformableSolver(&solver);
  btDeformableMultiBodyDynamicsWorld world(&ground.dispatcher, &ground.broadphase,
                                           &constraint_solver, &ground.configuration, &solver);
  world.setImplicit(implicit);
  world.setLineSearch(settings.line_search);
  world.setUseProjection(true);
  const auto body = make_body(problem, world.getWorldInfo());
  btDeformableMassSpringForce springs = make_springs(problem, *body);
  world.addSoftBody(body.get(), 0, 0);
  btDeformableGravityForce gravity(vector(problem.gravity));
  world.addForce(body.get(), &springs);
  world.addForce(body.get(), &gravity);
  ClothOutcome outcome = run(world, *body, settings);
  world.removeSoftBody(body.get());
  return outcome;
}

}  // namespace

ClothOutcome simulate_cloth(const ClothProblem& problem, const ClothSettings& settings) {
  if (settings.method == "soft-body") return run_soft_body(problem, settings);
  if (settings.method == "deformable") return run_deformable(problem, settings, true);
  if (settings.method == "deformable-explicit") return run_deformable(problem, settings, false);
  throw std::invalid_argument("no method of Bullet: " + settings.method);
}

}  // namespace weft::bench
