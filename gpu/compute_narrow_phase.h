// The narrow phase of contact on the device, in float64: distances of candidates, the signed sums
// over the features around samples (bsi/detail/surface_terms.h), and barrier, damping and friction
// of what is in reach.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bsi/geometry_image.h"
#include "gpu/gl_context.h"

namespace weft::gpu {

using bsi::Vec3;

// The parameters that candidates have in common. The law is that of materials/contact.h.
struct ContactGroup {
  bool edges = false;       // the candidates are pairs of edges; otherwise vertices with triangles
  bool samples = false;     // a row is a sample with its triangles; otherwise a single pair
  bool obstacle = false;    // one feature of every candidate belongs to an obstacle
  double thickness = 0;     // m
  double range = 0;         // m, > 0
  double damping_time = 0;  // s
  double friction = 0;      // Coulomb coefficient
  double friction_speed = 0;  // m/s, > 0
  Vec3 spin{0, 0, 0};         // angular velocity of the obstacle, rad/s
  // Candidates whose ContactCandidate::distance (m) exceeds the limit are not measured.
  float limit = std::numeric_limits<float>::infinity();
};

// A sample with its triangles, or a single pair: the candidates from `first` to the next row's.
struct ContactRow {
  std::uint32_t first = 0;
  std::uint32_t group = 0;        // index in the groups
  double stiffness = 0;           // of the barrier, times the area, N/m
  double parallel_threshold = 0;  // m^4, of the mollifier; 0: no mollifier. Only for edges.
};

// A vertex and a triangle, or two edges, by their four points in the order of bsi/proximity.h.
// Candidates of a row of samples have a common vertex and different triangles of one mesh.
struct ContactCandidate {
  std::array<std::uint32_t, 4> points{};
  // For samples: bsi::SurfaceTerms::own_features() of the triangle.
  std::uint32_t own_features = 0;
  float distance = 0;  // m, lower bound of the distance
};

// One term of the sum of a row.
struct ContactTerm {
  std::uint32_t candidate = 0;
  std::uint32_t source_and_coefficient = 0;  // private to the shaders
  std::uint32_t row = 0;
  std::uint32_t flags = 0;  // private to the shaders

  int coefficient() const { return static_cast<std::int32_t>(source_and_coefficient) >> 3; }
  bool slides() const { return (flags & 1) != 0; }        // has a ContactSliding
  bool is_mollified() const { return (flags & 2) != 0; }  // has a turning force
};

// The push of a term along its normal. Energy, push and slopes include the coefficient.
struct ContactPush {
  std::array<double, 4> weight{};        // as in bsi::Closest
  std::array<double, 3> normal{};        // unit vector from the second feature to the first
  double gap = 0, energy = 0, push = 0;  // m, J, N
  double stiffness = 0, damping = 0;     // -dpush/dgap (N/m), -dpush/drate (N s/m)
  // Forces (N) from the slope of the mollifier on the ends of both edges, negative at their starts.
  std::array<double, 3> turn_first{}, turn_second{};
};

// The friction of a term. Matrices are stored by columns.
struct ContactSliding {
  std::array<std::array<double, 9>, 4> lever{};  // du/dv of the four points
  std::array<double, 3> force{};                 // on the first feature, N
  std::array<double, 9> slope{};                 // -d force / d u, N s/m
};

// The result of an evaluation. Term order[k] is the k-th in the order of the CPU: by rows, then by
// candidates. The entries of one term have one index in all three lists.
struct ContactResult {
  std::span<const ContactTerm> terms;
  std::span<const ContactPush> pushes;
  std::span<const ContactSliding> slidings;  // empty if no group has friction
  std::span<const std::uint32_t> order;
  // The first candidate that is in reach without a gap. The terms are meaningless then.
  std::optional<std::uint32_t> touching;
};

// Candidates stay on the device until they are replaced. An evaluation uploads positions and
// velocities (48 bytes per point), makes two dispatches and copies the terms to the host (160
// bytes, with friction 544 more). If a list outgrows its memory, the list is enlarged and the
// evaluation repeated, so that no term is lost. Memory is kept between calls.
//
// Decisions are those of the CPU's functions, operation by operation: a device that rounds to
// nearest finds the same terms in the same order. Values agree within a few units in the last
// place. The order does not depend on the device's schedule.
//
// All functions make the context current on the calling thread. They throw std::runtime_error with
// the reason if OpenGL fails, has no memory, or limits a buffer to less than its list needs.
class ComputeNarrowPhase {
 public:
  explicit ComputeNarrowPhase(GlContext& context);
  ~ComputeNarrowPhase();
  ComputeNarrowPhase(const ComputeNarrowPhase&) = delete;
  ComputeNarrowPhase& operator=(const ComputeNarrowPhase&) = delete;

  // Replaces the rows and candidates. Rows are sorted by `first`, and the first one begins at 0.
  void set_candidates(std::span<const ContactRow> rows,
                      std::span<const ContactCandidate> candidates);
  // Evaluates all rows. `positions` (m) and `velocities` (m/s) have the same size. The result is
  // valid until the next call. Preconditions: positions are finite, and candidates and rows name
  // points and groups that exist.
  ContactResult evaluate(std::span<const ContactGroup> groups, std::span<const Vec3> positions,
                         std::span<const Vec3> velocities);
  // Returns the number of repetitions of evaluations since construction.
  int reruns() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::gpu
