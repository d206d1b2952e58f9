// The plastic state of the bodies whose bending yields. It belongs to the state of a run: it
// advances with accepted steps alone.
#pragma once

#include <span>
#include <vector>

#include "materials/crease.h"
#include "sim/base/state_archive.h"
#include "sim/base/step_history.h"

namespace weft::sim {

struct MaterialCase;
struct Scene;

// Returns the law by which a triangle of this material yields; that of an elastic one never does.
// Rest positions are columns (m).
materials::YieldLaw yield_law_of(const materials::Nodes3& rest, const MaterialCase& material);

// True if the bending of a dynamic body of the scene can yield.
bool has_yielding_bodies(const Scene& scene);

// The creases of all triangles of these bodies. Bodies are numbered as in the case, so that one
// history serves all scenes that are made from a case in the course of a run.
class CreaseHistory : public StepHistory<std::vector<materials::Crease>> {
 public:
  using Creases = std::vector<materials::Crease>;

  // Starts without creases.
  explicit CreaseHistory(const Scene& scene);

  // Returns the selected creases of a body, by triangle of its mesh; empty if it does not yield.
  std::span<const materials::Crease> of_body(int case_body) const;
  // Returns those at the end of the step that is being accepted. Forces replace each by what
  // follows from that of of_body().
  std::span<materials::Crease> advanced(int case_body) {
    return std::span(at_end()).subspan(first_[case_body], count_of(case_body));
  }
  void transfer(StateArchive& archive);

 private:
  std::size_t count_of(int case_body) const { return first_[case_body + 1] - first_[case_body]; }

  std::vector<std::size_t> first_;  // by body of the case, one more at the end
};

}  // namespace weft::sim
