#include "sim/particles/row_batches.h"

#include <algorithm>

namespace weft::sim {

void RowBatches::clear(int spheres) {
  batches_.clear();
  solved_.clear();
  changed_.assign(static_cast<std::size_t>(spheres) + 1, 0);
  clock_ = 0;
  open_.fill({});
  next_to_close_ = 0;
  taken_.assign(static_cast<std::size_t>(spheres) + 1, 0);
}

// Lets the clock begin anew. The same batches have to be solved as before.
void RowBatches::restart_clock() {
  for (int b = 0; b < count(); ++b) solved_[b] = has_changed(b) ? -1 : 0;
  std::ranges::fill(changed_, 0);
  clock_ = 0;
}

// The batch of a slot takes no further rows.
void RowBatches::close(int slot) {
  const Batch& batch = batches_[open_[slot].batch];
  for (const auto* spheres : {&batch.sphere, &batch.other}) {
    for (const int sphere : *spheres) taken_[sphere] &= ~(std::uint64_t{1} << slot);
  }
  open_[slot] = {};
}

// Returns a slot that is not among those taken. If all are, as around a sphere with very many
// contacts, one of them gets a new batch.
int RowBatches::open_slot(std::uint64_t taken) {
  int slot = std::countr_one(taken);
  if (slot == slots) {
    slot = next_to_close_;
    next_to_close_ = (next_to_close_ + 1) % slots;
    close(slot);
  }
  if (open_[slot].batch < 0) {
    open_[slot] = {count(), 0};
    Batch empty;
    empty.sphere.fill(nobody());
    empty.other.fill(nobody());
    batches_.push_back(empty);
    solved_.push_back(-1);
  }
  return slot;
}

int RowBatches::add(int sphere, int other) {
  const int second = other < 0 ? nobody() : other;
  const int slot = open_slot(taken_[sphere] | (other < 0 ? 0 : taken_[other]));
  Open& open = open_[slot];
  const int batch = open.batch, row = open.rows++;
  batches_[batch].sphere[row] = sphere;
  batches_[batch].other[row] = second;
  solved_[batch] = -1;
  for (const int each : {sphere, second}) taken_[each] |= std::uint64_t{1} << slot;
  taken_[nobody()] = 0;
  if (open.rows == width) close(slot);
  return batch * width + row;
}

}  // namespace weft::sim
