// Batches of rows, and the solutions for velocities and displacements of spheres that use them,
// compared with one row after the other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "sim/base/islands.h"
#include "sim/case/case_reader.h"
#include "sim/particles/displacement_solver.h"
#include "sim/particles/impulse_solver.h"
#include "sim/particles/row_batches.h"

namespace weft::sim::sphere_solvers_test {
namespace {

struct Row {
  int sphere, other;
};

// Random pairs of spheres, each row with one sphere in five alone, and one sphere in every third.
std::vector<Row> random_rows(int spheres, int count) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> sphere(1, spheres - 1);
  std::vector<Row> rows;
  for (int i = 0; i < count; ++i) {
    Row row{i % 3 == 0 ? 0 : sphere(random), i % 5 == 1 ? -1 : sphere(random)};
    if (row.sphere != row.other) rows.push_back(row);
  }
  return rows;
}

TEST(RowBatches, HoldEveryRowOnceAndNoSphereTwice) {
  constexpr int spheres = 400;
  const std::vector<Row> rows = random_rows(spheres, 3000);
  RowBatches batches;
  batches.clear(spheres);
  std::set<int> places;
  for (const Row& row : rows) {
    const int place = batches.add(row.sphere, row.other);
    EXPECT_TRUE(places.insert(place).second);
    ASSERT_LT(place, batches.count() * RowBatches::width);
    EXPECT_EQ(batches.spheres_of(batch_of(place))[lane_of(place)], row.sphere);
    EXPECT_EQ(batches.others_of(batch_of(place))[lane_of(place)],
              row.other < 0 ? batches.nobody() : row.other);
  }
  for (int b = 0; b < batches.count(); ++b) {
    std::multiset<int> in_batch;
    for (int row = 0; row < RowBatches::width; ++row) {
      const bool exists = places.contains(b * RowBatches::width + row);
      for (const int sphere : {batches.spheres_of(b)[row], batches.others_of(b)[row]}) {
        EXPECT_TRUE(exists || sphere == batches.nobody());
        if (sphere != batches.nobody()) in_batch.insert(sphere);
      }
    }
    for (const int sphere : in_batch) EXPECT_EQ(in_batch.count(sphere), 1U);
  }
  // A third of the rows have the first sphere, so that there are at least as many batches.
  EXPECT_LE(batches.count(), 1000 + 64);
}

TEST(RowBatches, AreNearlyFullWhereSpheresHaveFewRows) {
  constexpr int spheres = 1000;
  RowBatches batches;
  batches.clear(spheres);
  for (int i = 0; i + 1 < spheres; ++i) batches.add(i, i + 1);
  EXPECT_LE(batches.count(), spheres / RowBatches::width + 3);
}

TEST(RowBatches, AreSolvedAgainWhereSpheresHaveChanged) {
  RowBatches batches;
  batches.clear(200);
  std::vector<int> batch_of;  // by row, which joins the spheres i and i + 1
  for (int i = 0; i < 150; ++i) batch_of.push_back(batches.add(i, i + 1) / RowBatches::width);
  batch_of.push_back(batches.add(150, -1) / RowBatches::width);
  std::vector<int> solved;
  const auto nothing_changes = [&](int batch) {
    solved.push_back(batch);
    return 0U;
  };
  EXPECT_TRUE(batches.sweep(nothing_changes));
  EXPECT_EQ(static_cast<int>(solved.size()), batches.count());
  EXPECT_TRUE(std::ranges::is_sorted(solved));
  EXPECT_FALSE(batches.sweep(nothing_changes));

  solved.clear();
  batches.touch(150);
  EXPECT_TRUE(batches.sweep(nothing_changes));
  EXPECT_EQ(std::set<int>(solved.begin(), solved.end()), (std::set{batch_of[149], batch_of[150]}));

  // A row that changes its spheres has the batches of their other rows solved again, and not its
  // own.
  const int place = batches.add(64, 65), own = place / RowBatches::width;
  solved.clear();
  EXPECT_TRUE(batches.sweep([&](int batch) {
    solved.push_back(batch);
    return batch == own ? 1U << place % RowBatches::width : 0U;
  }));
  batches.sweep(nothing_changes);
  EXPECT_FALSE(batches.sweep(nothing_changes));
  const std::set others{batch_of[63], batch_of[64], batch_of[65]};
  EXPECT_FALSE(others.contains(own));
  EXPECT_EQ(solved.size(), others.size() + 1);
  for (const int batch : others) EXPECT_EQ(std::ranges::count(solved, batch), 1);

  // A row that is solved in part has its own batch solved again, too.
  batches.touch(64);
  batches.sweep([&](int batch) { return batch == own ? 1U << lane_of(place) : 0U; }, false);
  solved.clear();
  EXPECT_TRUE(batches.sweep(nothing_changes));
  EXPECT_EQ(std::ranges::count(solved, own), 1);
  EXPECT_FALSE(batches.sweep(nothing_changes));
}

// The clock of the batches begins anew within this many sweeps.
TEST(RowBatches, AreSolvedAgainHoweverManyHaveBeenSolved) {
  RowBatches batches;
  batches.clear(20);
  for (int i = 0; i + 1 < 20; ++i) batches.add(i, i + 1);
  const auto nothing_changes = [](int) { return 0U; };
  batches.sweep(nothing_changes);
  int swept = 0;
  for (int i = 0; i < 500'000; ++i) {
    batches.touch(i % 20);
    swept += batches.sweep(nothing_changes) ? 1 : 0;
    swept += batches.sweep(nothing_changes) ? 1'000'000'000 : 0;
    if (swept != i + 1) break;
  }
  EXPECT_EQ(swept, 500'000);
}

TEST(ConnectedElements, FormIslands) {
  constexpr int spheres = 300;
  std::mt19937 random(11);
  std::uniform_int_distribution<int> sphere(0, spheres - 1);
  Islands islands;
  for (int trial = 0; trial < 2; ++trial) {
    islands.clear(spheres);
    std::vector<int> expected(spheres);  // the lowest sphere that can be reached
    std::iota(expected.begin(), expected.end(), 0);
    for (int k = 0; k < 170; ++k) {
      const int a = sphere(random), b = sphere(random);
      islands.connect(a, b);
      const auto [low, high] = std::minmax({expected[a], expected[b]});
      std::ranges::replace(expected, high, low);
    }
    for (int i = 0; i < spheres; ++i) EXPECT_EQ(islands.island_of(i), expected[i]);
  }
}

// Thirty spheres of a radius (m), and thirty of twice the radius.
std::unique_ptr<const Scene> heap_scene(const std::string& radius, const std::string& twice) {
  return build_scene(parse_case(R"(
[time]
method = "impulses"
duration = 1
[[particles]]
name = "small"
radius = )" + radius + R"(
positions = { type = "grid", count = [30, 1, 1], centre = [0, 0, 0] }
[[particles]]
name = "large"
radius = )" + twice + R"(
positions = { type = "grid", count = [30, 1, 1], centre = [0, 1, 0] }
)",
                                "heap.toml"));
}

// A heap without gravity: spheres of two sizes that touch at random, some of them a wall.
class Heap : public testing::Test {
 protected:
  static constexpr int count = 60;
  Heap() : scene(heap_scene("0.01", "0.02")), solver(*scene) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> part(-1, 1);
    const auto vector = [&] { return Vec3(part(random), part(random), part(random)); };
    for (int i = 0; i < count; ++i) velocity.push_back(vector());
    for (int a = 0; a < count; ++a) {
      for (int b = a + 1; b < count; ++b) {
        if ((b - a) % 19 == 0 || b == a + 1) add({a, b}, vector().normalized());
      }
    }
    std::ranges::sort(contacts, {}, &SphereContact::key);
    acceleration.assign(count, Vec3::Zero());
  }
  void add(const Row& row, const Vec3& normal) {
    SphereContact contact;
    contact.sphere = row.sphere;
    contact.other = row.other;
    contact.surface = row.other < 0 ? 0 : -1;
    contact.normal = normal;
    contact.gap = 0;
    contacts.push_back(contact);
  }
  ImpulseStep step() const { return {1e-3, 1e-9, velocity, acceleration}; }
  double mass(int sphere) const { return 1 / solver.inverse_masses()[sphere]; }

  std::unique_ptr<const Scene> scene;
  ImpulseSolver solver;
  std::vector<Vec3> velocity, acceleration;
  std::vector<SphereContact> contacts;
};

// Projected Gauss-Seidel, one row after the other in the order of their places. All sweeps but the
// first and the last two are over-relaxed. A last sweep follows the order of the contacts.
class RowByRow {
 public:
  RowByRow(const ImpulseSolver& solver, std::vector<Vec3> velocity, const std::vector<Vec3>& spin)
      : solver_(solver), velocity_(std::move(velocity)), spin_(spin) {}

  void solve(std::span<const SphereContact> contacts, int sweeps) {
    RowBatches batches;
    batches.clear(static_cast<int>(velocity_.size()));
    using Placed = std::pair<int, const SphereContact*>;
    std::vector<Placed> rows;
    for (const SphereContact& contact : contacts)
      rows.emplace_back(batches.add(contact.sphere, contact.other), &contact);
    std::ranges::sort(rows);
    std::vector<double> normal(contacts.size(), 0.0);
    std::vector<Vec3> tangential(contacts.size(), Vec3::Zero());
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      const double factor = sweep == 0 || sweep >= sweeps - 2 ? 1 : 1.8;
      for (std::size_t r = 0; r < rows.size(); ++r)
        solve(*rows[r].second, factor, normal[r], tangential[r]);
    }
    for (const SphereContact& contact : contacts) {
      const std::size_t r = std::ranges::find(rows, &contact, &Placed::second) - rows.begin();
      solve(contact, 1, normal[r], tangential[r]);
    }
  }
  const std::vector<Vec3>& velocity() const { return velocity_; }
  const std::vector<Vec3>& spin() const { return spin_; }

 private:
  double radius(int sphere) const { return sphere < 30 ? 0.01 : 0.02; }
  double turning_share(int sphere) const {
    return radius(sphere) * radius(sphere) / solver_.inertia(sphere);
  }
  void solve(const SphereContact& at, double factor, double& normal, Vec3& tangential) {
    const int a = at.sphere, b = at.other;
    double share = solver_.inverse_masses()[a], sliding_share = share + turning_share(a);
    Vec3 relative = velocity_[a] - radius(a) * spin_[a].cross(at.normal) - at.drive;
    if (b >= 0) {
      const double other = solver_.inverse_masses()[b];
      share += other;
      sliding_share += other + turning_share(b);
      relative -= velocity_[b] + radius(b) * spin_[b].cross(at.normal);
    }
    const double speed = relative.dot(at.normal), before = normal;
    normal = std::max(0.0, before - factor * speed / share);
    const Vec3 old = tangential;
    tangential -= (relative - speed * at.normal) / sliding_share;
    const double limit = at.friction * normal;
    if (tangential.norm() > limit) tangential *= limit / tangential.norm();
    const Vec3 impulse = (normal - before) * at.normal + tangential - old;
    const Vec3 turn = at.normal.cross(tangential - old);
    velocity_[a] += solver_.inverse_masses()[a] * impulse;
    spin_[a] -= radius(a) / solver_.inertia(a) * turn;
    if (b < 0) return;
    velocity_[b] -= solver_.inverse_masses()[b] * impulse;
    spin_[b] -= radius(b) / solver_.inertia(b) * turn;
  }

  const ImpulseSolver& solver_;
  std::vector<Vec3> velocity_, spin_;
};

TEST_F(Heap, HasTheVelocitiesOfOneRowAfterTheOther) {
  for (int i = 0; i < count; i += 7) add({i, -1}, Vec3(0.6, 0, 0.8));
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    contacts[c].friction = c % 4 == 0 ? 0 : 0.3;
    if (contacts[c].other < 0) contacts[c].drive = contacts[c].end_drive = {0.1, -0.2, 0.3};
  }
  std::ranges::sort(contacts, {}, &SphereContact::key);
  std::vector<Vec3> found(count), spin(count, Vec3(1, -2, 3));
  RowByRow expected(solver, velocity, spin);
  expected.solve(contacts, 25);
  solver.find_velocities(contacts, step(), found, spin);
  EXPECT_EQ(solver.sweeps(), 25);
  for (int i = 0; i < count; ++i) {
    // Sweeps are in single precision. Spins are about a hundred times as large as velocities.
    EXPECT_LT((found[i] - expected.velocity()[i]).norm(), 2e-6) << i;
    EXPECT_LT((spin[i] - expected.spin()[i]).norm(), 2e-4) << i;
  }
}

// Equal velocities have equal results whatever the masses: dust of 10 nm weighs 1e-18 of balls of
// 1 cm.
TEST_F(Heap, MovesLikeOneOfDust) {
  for (SphereContact& contact : contacts) contact.friction = 0.3;
  std::vector<Vec3> found(count), spin(count, Vec3::Zero());
  solver.find_velocities(contacts, step(), found, spin);
  const auto small_scene = heap_scene("1e-8", "2e-8");
  ImpulseSolver dust(*small_scene);
  std::vector<Vec3> of_dust(count), spin_of_dust(count, Vec3::Zero());
  dust.find_velocities(contacts, step(), of_dust, spin_of_dust);
  for (int i = 0; i < count; ++i) {
    EXPECT_LT((found[i] - of_dust[i]).norm(), 2e-6) << i;
    EXPECT_LT((spin[i] - 1e-6 * spin_of_dust[i]).norm(), 2e-4) << i;
  }
}

TEST_F(Heap, KeepsItsMomentum) {
  for (SphereContact& contact : contacts) contact.friction = 0.4;
  std::vector<Vec3> found(count), spin(count, Vec3(1, -2, 3));
  solver.find_velocities(contacts, step(), found, spin);
  Vec3 momentum = Vec3::Zero();
  double size = 0;
  for (int i = 0; i < count; ++i) {
    momentum += mass(i) * (found[i] - velocity[i]);
    size += mass(i) * (found[i] - velocity[i]).norm();
  }
  EXPECT_GT(size, 1e-3);
  EXPECT_LT(momentum.norm(), 1e-13 * size);
}

// The energy (J) that impulses add to an island of spheres, relative to walls that move.
struct AddedEnergy {
  double sum = 0;
  double before = 0;  // J, kinetic energy before
  bool has_changed = false;
};

// Islands of equally many spheres, with impacts of any restitution at any times within a step,
// beside contacts that rest, with and without friction.
class Islands : public Heap {
 protected:
  int in_island = 4;
  const Vec3 drive{0.1, -0.2, 0.3}, spin_before{1, -2, 3};

  void throw_spheres(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(0, 1);
    const auto vector = [&] {
      return Vec3(2 * part(random) - 1, 2 * part(random) - 1, 2 * part(random) - 1);
    };
    acceleration.assign(count, Vec3(1, 2, -9.81));
    for (Vec3& each : velocity) each = vector();
    contacts.clear();
    for (int i = 0; i < count; ++i) {
      if (i % in_island != in_island - 1) add({i, i + 1}, (Vec3(2, 0, 1) + vector()).normalized());
      if (i % 3 == 0) add({i, -1}, Vec3(0.6, 0, 0.8));
      for (int other = i + 19; in_island == count && other < count; other += 19)
        add({i, other}, vector().normalized());
    }
    for (SphereContact& contact : contacts) {
      contact.gap = part(random) < 0.3 ? 0 : 1e-3 * part(random);
      contact.restitution = part(random) < 0.7 ? 1 : 0;
      contact.friction = seed % 2 == 0 ? 0 : part(random);
      if (contact.other < 0) contact.drive = drive;
    }
    std::ranges::sort(contacts, {}, &SphereContact::key);
  }

  std::vector<AddedEnergy> added_energies() {
    const ImpulseStep step{1e-3, 5e-3, velocity, acceleration};
    ImpulseSolver fresh(*scene);
    std::vector<Vec3> found(count), mean(count), spin(count, spin_before);
    fresh.find_velocities(contacts, step, found, spin);
    fresh.find_displacements(step, found, mean);
    std::vector<AddedEnergy> added(count / in_island);
    for (int i = 0; i < count; ++i) {
      const Vec3 before = velocity[i] - drive, after = found[i] - drive;
      const Vec3 way = step.length * (mean[i] - drive);
      const double kinetic = 0.5 * mass(i) * (after.squaredNorm() - before.squaredNorm()),
                   turning =
                       0.5 * fresh.inertia(i) * (spin[i].squaredNorm() - spin_before.squaredNorm()),
                   change = kinetic + turning - mass(i) * acceleration[i].dot(way);
      added[i / in_island].sum += change;
      added[i / in_island].before += 0.5 * mass(i) * before.squaredNorm();
      if (std::abs(change) > 1e-6 * mass(i)) added[i / in_island].has_changed = true;
    }
    return added;
  }
};

// Newton's law alone adds energy to one island of four spheres in six. In a large island
// impulses settle slowly.
TEST_F(Islands, GainNoEnergyByImpacts) {
  int kept = 0;
  for (const int size : {4, 60}) {
    in_island = size;
    for (unsigned seed = 1; seed <= 100; ++seed) {
      throw_spheres(seed);
      for (const AddedEnergy& added : added_energies()) {
        EXPECT_LT(added.sum, 1e-9 * added.before) << size << " spheres, seed " << seed;
        kept += added.has_changed && std::abs(added.sum) < 1e-9 * added.before ? 1 : 0;
      }
    }
  }
  // No more is taken than what would be gained.
  EXPECT_GT(kept, 300);
}

// A floor that has to lift a sphere, at rest or moving itself.
TEST_F(Heap, PaysWithItsMotionForBeingLifted) {
  constexpr double length = 1e-3, gravity = 9.81;
  const Vec3 up(0, 0, 1);
  for (const double drive : {0.0, 0.5}) {
    contacts.clear();
    add({3, -1}, up);   // falls
    add({4, -1}, up);   // moves up, and is lifted nevertheless
    add({5, -1}, up);   // too slow to pay
    add({6, -1}, -up);  // rises, and is pushed down by a ceiling
    for (SphereContact& contact : contacts) {
      contact.gap = solver.rest_gaps()[contact.sphere];
      contact.drive = drive * contact.normal;
    }
    const Vec3 sideways(0.7, 0, 0);
    std::vector<Vec3> mean(count, sideways), found(count, sideways);
    for (const int i : {3, 4, 5}) mean[i] -= 2 * up;
    mean[6] += 2 * up;
    found[3] += (drive - 1.5) * up;
    found[4] += (drive + 1.5) * up;
    found[5] += (drive - 0.1) * up;
    found[6] -= (drive - 1.5) * up;
    found[7] = sideways - 1.5 * up;  // stays where it is
    mean[7] = sideways - up;
    const std::vector<Vec3> before = found;
    DisplacementSolver displacements(solver.rest_gaps(), solver.inverse_masses());
    displacements.start(contacts, length, mean);
    displacements.correct();
    EXPECT_TRUE(displacements.fix(7));
    displacements.keep_energy(-gravity * up, found);
    const auto left = [&](int sphere) {
      const double lift = length * (displacements.mean(sphere) - mean[sphere]).z();
      EXPECT_NEAR(lift, length * (2 + drive), 1e-8);
      return std::sqrt(1.5 * 1.5 - 2 * gravity * lift);
    };
    EXPECT_LT((found[3] - sideways - (drive - left(3)) * up).norm(), 1e-6);
    EXPECT_LT((found[4] - sideways - (drive + left(4)) * up).norm(), 1e-6);
    EXPECT_LT((found[5] - sideways - drive * up).norm(), 1e-6);
    const double fallen = length * (2 + drive);
    EXPECT_LT(
        (found[6] - before[6] - (std::sqrt(1.5 * 1.5 + 2 * gravity * fallen) - 1.5) * up).norm(),
        1e-6);
    // The energy of its motion along the way that it did not go.
    const Vec3 way = mean[7].normalized();
    const double speed = way.dot(before[7]);
    const double slower = std::sqrt(speed * speed - 2 * length * mean[7].dot(-gravity * up));
    EXPECT_LT((found[7] - before[7] - (slower - speed) * way).norm(), 1e-6);
    for (int i = 8; i < count; ++i) EXPECT_EQ(found[i], before[i]);
    // The next step pays for nothing of this one.
    found = before;
    displacements.start({}, length, mean);
    displacements.keep_energy(-gravity * up, found);
    EXPECT_EQ(found, before);
  }
}

TEST_F(Heap, HasDisplacementsThatKeepEveryGapOpen) {
  for (SphereContact& contact : contacts) contact.gap = solver.rest_gaps()[contact.sphere];
  constexpr double length = 1e-3;
  DisplacementSolver displacements(solver.rest_gaps(), solver.inverse_masses());
  for (Vec3& mean : velocity) mean *= 0.05;
  displacements.start(contacts, length, velocity);
  for (int call = 0; call < 50; ++call) displacements.correct();
  double moved = 0;
  const auto check = [&] {
    for (const SphereContact& contact : contacts) {
      const double rest =
          std::min(solver.rest_gaps()[contact.sphere], solver.rest_gaps()[contact.other]);
      const Vec3 apart = displacements.mean(contact.sphere) - displacements.mean(contact.other);
      EXPECT_GT(contact.gap + length * contact.normal.dot(apart), 0.3 * rest);
    }
  };
  check();
  Vec3 momentum = Vec3::Zero();
  for (int i = 0; i < count; ++i) {
    momentum += mass(i) * (displacements.mean(i) - velocity[i]);
    moved = std::max(moved, (displacements.mean(i) - velocity[i]).norm());
  }
  EXPECT_GT(moved, 1e-3);
  EXPECT_LT(momentum.norm(), 1e-9);
  // A sphere that stays where it is pushes the others away.
  EXPECT_TRUE(displacements.fix(20));
  EXPECT_FALSE(displacements.fix(20));
  for (int call = 0; call < 50; ++call) displacements.correct();
  EXPECT_EQ(displacements.mean(20), Vec3::Zero());
  check();
}

// A step restores a fifth of what a gap lacks at its start. Both spheres move by amounts inverse to
// their masses, also where they would stay at rest.
TEST(Displacements, RestoreAFifthOfALackingGap) {
  const std::vector<double> rest{1e-5, 2e-5}, inverse_mass{1, 3};
  constexpr double length = 1e-3;
  SphereContact contact;
  contact.sphere = 0;
  contact.other = 1;
  contact.normal = Vec3(0, 0, 1);
  for (const double gap : {0.0, 0.4e-5, 0.9e-5}) {
    contact.gap = gap;
    DisplacementSolver displacements(rest, inverse_mass);
    const std::vector<Vec3> still(2, Vec3::Zero());
    displacements.start(std::span(&contact, 1), length, still);
    for (int call = 0; call < 50; ++call) displacements.correct();
    const double up = length * displacements.mean(0).z(), down = length * displacements.mean(1).z();
    EXPECT_NEAR(up - down, 0.2 * (1e-5 - gap), 1e-10) << gap;
    EXPECT_NEAR(down, -3 * up, 1e-10) << gap;
  }
}

TEST_F(Heap, BeginsWithMostOfTheLastCorrections) {
  for (SphereContact& contact : contacts) contact.gap = solver.rest_gaps()[contact.sphere];
  DisplacementSolver displacements(solver.rest_gaps(), solver.inverse_masses());
  const auto begin = [&](double length) {
    displacements.start(contacts, length, velocity);
    std::vector<Vec3> moved;
    for (int i = 0; i < count; ++i) moved.push_back(displacements.mean(i) - velocity[i]);
    return moved;
  };
  for (const Vec3& each : begin(1e-3)) EXPECT_EQ(each, Vec3::Zero());
  displacements.correct();
  std::vector<Vec3> corrections;
  for (int i = 0; i < count; ++i) corrections.push_back(displacements.mean(i) - velocity[i]);
  displacements.keep();
  const std::vector<Vec3> same = begin(1e-3), shorter = begin(0.5e-3);
  for (int i = 0; i < count; ++i) {
    EXPECT_LT((same[i] - 0.8 * corrections[i]).norm(), 1e-6);
    EXPECT_LT((shorter[i] - 0.4 * corrections[i]).norm(), 1e-6);
  }
  displacements.forget();
  for (const Vec3& each : begin(1e-3)) EXPECT_EQ(each, Vec3::Zero());
}

}  // namespace
}  // namespace weft::sim::sphere_solvers_test
