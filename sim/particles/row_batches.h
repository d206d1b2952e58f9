// Rows of a system of contacts, in batches that vector instructions solve at once.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace weft::sim {

// A row belongs to one sphere or two. No two rows of a batch have a sphere in common, so that the
// result of solving them at once is that of one after the other. Sweeps over the batches leave out
// those whose spheres have not changed since they were solved. Batches depend on the order in which
// rows are added, and on nothing else.
class RowBatches {
 public:
  static constexpr int width = 8;  // rows of a batch

  // Removes all rows, and begins with a number of spheres.
  void clear(int spheres);
  // Adds a row, which the next sweep solves. `other` is negative if there is no second sphere.
  // Returns its place, which is the index of its batch times `width` plus that within the batch.
  // O(1) on average.
  int add(int sphere, int other);
  int count() const { return static_cast<int>(batches_.size()); }
  // Return the spheres of a batch, by row. A row that does not exist has nobody() twice, a row of
  // one sphere has it once.
  const std::array<int, width>& spheres_of(int batch) const { return batches_[batch].sphere; }
  const std::array<int, width>& others_of(int batch) const { return batches_[batch].other; }
  // Returns the number of spheres, which stands for a missing sphere.
  int nobody() const { return static_cast<int>(changed_.size()) - 1; }
  // Lets the next sweep solve the rows of a sphere.
  void touch(int sphere) { changed_[sphere] = ++clock_; }
  // Calls `solve` with the index of each batch that has to be solved, in ascending order. It
  // returns one bit per row, the lowest for the first, which is set if the row's spheres have
  // changed. Batches of these spheres have to be solved from then on. Their own batch is among them
  // unless `solve` is exact, so that the row has nothing to gain. Returns false if there was no
  // batch to solve.
  template <class Solve>
  bool sweep(const Solve& solve, bool is_exact = true) {
    if (clock_ > latest_clock) restart_clock();
    bool is_any = false;
    for (int b = 0; b < count(); ++b) {
      if (!has_changed(b)) continue;
      is_any = true;
      unsigned rows = solve(b);
      solved_[b] = ++clock_;
      if (!is_exact) ++clock_;
      for (; rows != 0; rows &= rows - 1) {
        const int row = std::countr_zero(rows);
        changed_[batches_[b].sphere[row]] = changed_[batches_[b].other[row]] = clock_;
      }
      changed_.back() = 0;
    }
    return is_any;
  }

 private:
  struct Batch {
    std::array<int, width> sphere, other;
  };
  // True if a sphere of the batch has changed since it was solved. Loads of all clocks at once cost
  // less than branches.
  bool has_changed(int batch) const {
    const std::int32_t since = solved_[batch];
    bool is_any = false;
    for (int row = 0; row < width; ++row) {
      is_any |= changed_[batches_[batch].sphere[row]] > since;
      is_any |= changed_[batches_[batch].other[row]] > since;
    }
    return is_any;
  }
  void restart_clock();
  int open_slot(std::uint64_t taken);
  void close(int slot);

  static constexpr std::int32_t latest_clock = 1 << 20;  // far from an overflow
  static constexpr int slots = 64;                       // batches that are filled at the same time
  struct Open {
    int batch = -1;
    int rows = 0;
  };
  std::vector<Batch> batches_;
  // Numbers of batches solved so far: by batch, when it was solved, -1 if it has to be; by sphere,
  // when it changed. The last sphere is nobody(), which never changes.
  std::vector<std::int32_t> solved_, changed_;
  std::int32_t clock_ = 0;
  std::array<Open, slots> open_;
  int next_to_close_ = 0;
  std::vector<std::uint64_t> taken_;  // by sphere: one bit per slot whose batch has a row of it
};

// Return the batch of the row at a place, and its number within the batch.
inline int batch_of(int place) { return place / RowBatches::width; }
inline int lane_of(int place) { return place % RowBatches::width; }

}  // namespace weft::sim
