// The plastic state of the bodies whose bending yields. It belongs to the state of a run: it
// advances with accepted steps alone.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "materials/crease.h"
#include "sim/base/state_archive.h"

namespace weft::sim {

struct MaterialCase;
struct Scene;

// Returns the law by which a triangle of this material yields; that of an elastic one never does.
// Rest positions are columns (m).
materials::YieldLaw yield_law_of(const materials::Nodes3& rest, const MaterialCase& material);

// True if the bending of a dynamic body of the scene can yield.
bool has_yielding_bodies(const Scene& scene);

// The creases of all triangles of these bodies, at the start and at the end of the last accepted
// step. Forces at a time after the start of that step and before its end follow from the creases at
// its start; those at later times follow from the creases at its end. Bodies are numbered as in the
// case, so that one history serves all scenes that are made from a case in the course of a run.
class CreaseHistory {
 public:
  using Creases = std::vector<materials::Crease>;

  // Starts without creases.
  explicit CreaseHistory(const Scene& scene);

  // Selects the creases from which forces at a time (s) follow.
  void choose(double time);
  // Returns the selected creases of a body, by triangle of its mesh; empty if it does not yield.
  std::span<const materials::Crease> of_body(int case_body) const;
  // Differs from all earlier values whenever other creases are selected.
  std::int64_t version() const { return version_; }

  // Begins to accept a step that ends at `time`: its start keeps the creases so far. Forces then
  // replace those of of_body(), each by what follows from it, through advanced().
  void begin_accept(double time);
  std::span<materials::Crease> advanced(int case_body) {
    return std::span(at_end_).subspan(first_[case_body], count_of(case_body));
  }
  void end_accept() { ++version_; }
  // Takes the last step back if it ended after `time`. Returns true if `time` is later than the end
  // of the steps that are left.
  bool take_back(double time);

  // Returns the selected creases of all bodies.
  const Creases& selected() const;
  // Selects these creases, whatever the time, until the call with null.
  void fix(const Creases* creases);
  void transfer(StateArchive& archive);

 private:
  std::size_t count_of(int case_body) const { return first_[case_body + 1] - first_[case_body]; }

  std::vector<std::size_t> first_;  // by body of the case, one more at the end
  Creases at_begin_, at_end_;
  double begin_ = 0, end_ = 0;  // s
  bool is_earlier_ = false;     // the creases at the start of the last step are selected
  const Creases* fixed_ = nullptr;
  std::int64_t version_ = 0;
};

}  // namespace weft::sim
