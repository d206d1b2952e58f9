// Numbers and vectors of several rows at once, one per lane of a vector register.
#pragma once

#include <Eigen/Core>
#include <array>

#include "materials/lanes.h"
#include "sim/base/vectors.h"
#include "sim/particles/row_batches.h"

namespace weft::sim {

using materials::Lanes;
using LaneVec3 = Eigen::Matrix<Lanes, 3, 1>;

// A batch of rows (row_batches.h) fills this number of registers.
inline constexpr int registers_per_batch = RowBatches::width / materials::lane_count;

// Return the register and the lane of the row at a place, and the place of a register's first row.
inline int register_of(int place) { return place / materials::lane_count; }
inline int lane_of(int place) { return place % materials::lane_count; }
inline int first_place(int index) { return index * materials::lane_count; }

// Calls `solve` with the index of each register of a batch. It returns one bit per lane. Returns
// these bits for all rows of the batch.
template <class Solve>
unsigned solve_batch(int batch, const Solve& solve) {
  unsigned bits = 0;
  for (int i = 0; i < registers_per_batch; ++i)
    bits |= solve(batch * registers_per_batch + i) << (i * materials::lane_count);
  return bits;
}

// A vector and a number of each of lane_count spheres.
struct LaneRecords {
  LaneVec3 vector;
  Lanes number;
};

// Loads a vector, and the number that follows it in memory, of each lane. `vector_of` returns the
// vector of a lane, aligned to 32 bytes.
template <class VectorOf>
[[gnu::always_inline]] inline LaneRecords load_records(const VectorOf& vector_of) {
  const std::array<Lanes, 4> fours =
      materials::load_fours([&](int lane) { return vector_of(lane).data(); });
  return {{fours[0], fours[1], fours[2]}, fours[3]};
}
// Stores what load_records() returns, lane 0 first.
template <class VectorOf>
[[gnu::always_inline]] inline void store_records(const LaneRecords& records,
                                                 const VectorOf& vector_of) {
  materials::store_fours({records.vector[0], records.vector[1], records.vector[2], records.number},
                         [&](int lane) { return vector_of(lane).data(); });
}

inline void set_lane(LaneVec3& vectors, int lane, const Vec3& vector) {
  for (int k = 0; k < 3; ++k) vectors[k].values[lane] = vector[k];
}
inline Vec3 get_lane(const LaneVec3& vectors, int lane) {
  return {vectors[0].values[lane], vectors[1].values[lane], vectors[2].values[lane]};
}

}  // namespace weft::sim
