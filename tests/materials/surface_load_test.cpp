#include "materials/surface_load.h"

#include <gtest/gtest.h>

#include <functional>
#include <utility>

namespace weft::materials::surface_load_test {
namespace {

const Tangents skew{Vec3(1.1, 0.2, -0.3), Vec3(-0.4, 0.9, 0.5)};
const Vec3 normal = skew.u.cross(skew.v).normalized();

using Load = std::function<SurfaceForce(const Tangents&)>;
using Slopes = std::function<SurfaceForceSlopes(const Tangents&)>;

std::array<Vec3, 3> parts(const SurfaceForce& force) {
  return {force.position, force.along_u, force.along_v};
}

// Slopes of a load against differences along each component of both tangents.
void expect_slopes(const Load& load, const Slopes& slopes) {
  constexpr double step = 1e-6;
  const SurfaceForceSlopes exact = slopes(skew);
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool is_u : {true, false}) {
      Tangents more = skew, less = skew;
      (is_u ? more.u : more.v)[axis] += step;
      (is_u ? less.u : less.v)[axis] -= step;
      const auto after = parts(load(more)), before = parts(load(less));
      for (int part = 0; part < 3; ++part) {
        const Vec3 found = (after[part] - before[part]) / (2 * step);
        const Vec3 expected = (is_u ? exact.by_u : exact.by_v)[part].col(axis);
        EXPECT_LT((found - expected).norm(), 1e-8) << part << ' ' << axis << ' ' << is_u;
      }
    }
  }
}

// Virtual work of a load on a surface that moves with the tangents' rates.
double work(const SurfaceForce& force, const Vec3& rate_u, const Vec3& rate_v) {
  return force.along_u.dot(rate_u) + force.along_v.dot(rate_v);
}

TEST(PressureLoad, ActsAlongTheNormalByTheArea) {
  const SurfaceForce force = pressure_load(skew, 3);
  EXPECT_LT((force.position - 3 * skew.u.cross(skew.v).norm() * normal).norm(), 1e-14);
  expect_slopes([](const Tangents& t) { return pressure_load(t, 3); },
                [](const Tangents& t) { return pressure_load_slopes(t, 3); });
}

TEST(TurningLoad, KeepsItsComponentsInTheFrame) {
  const Vec3 components(2, -1, 0.5);
  const Mat3 frame = frame_of(skew);
  EXPECT_LT((frame.transpose() * frame - Mat3::Identity()).norm(), 1e-14);
  EXPECT_LT((frame.col(2) - normal).norm(), 1e-14);
  const Mat3 turn = Eigen::AngleAxisd(0.8, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const SurfaceForce here = turning_load(skew, components);
  const SurfaceForce there = turning_load({turn * skew.u, turn * skew.v}, components);
  EXPECT_LT((there.position - turn * here.position).norm(), 1e-14);
  expect_slopes([&](const Tangents& t) { return turning_load(t, components); },
                [&](const Tangents& t) { return turning_load_slopes(t, components); });
}

TEST(EdgeMoment, WorksOnTheRotationOfItsEdgeAlone) {
  const SurfaceForce force = edge_moment(skew, 3);
  const Vec3 edge = skew.u.normalized();
  // The surface lies on the side of a_v: it falls as what continues it beyond the edge rises.
  EXPECT_NEAR(work(force, Vec3::Zero(), (-edge).cross(skew.v)), 3, 1e-14);
  for (const Vec3& axis : {normal, Vec3(normal.cross(edge))})
    EXPECT_NEAR(work(force, axis.cross(skew.u), axis.cross(skew.v)), 0, 1e-14);
  // Stretching does not turn the edge.
  EXPECT_NEAR(work(force, skew.u, Vec3::Zero()), 0, 1e-14);
  EXPECT_NEAR(work(force, Vec3::Zero(), skew.v), 0, 1e-14);
  expect_slopes([](const Tangents& t) { return edge_moment(t, 3); },
                [](const Tangents& t) { return edge_moment_slopes(t, 3); });
}

}  // namespace
}  // namespace weft::materials::surface_load_test
