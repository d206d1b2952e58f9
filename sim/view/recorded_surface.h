// The surface of a recorded body as triangles.
#pragma once

#include <optional>
#include <vector>

#include "sim/scene/spline_sampling.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// The triangles of a recorded body. A shell has the triangles on which contact acts: those between
// samples of the spline through the points of its image. Any other body, and a shell of which only
// a part is recorded, has the triangles of its image.
class RecordedSurface {
 public:
  explicit RecordedSurface(const TrajectoryBody& body);

  // Returns the triangles of atlas(). Throws std::invalid_argument as bsi::build_mesh().
  bsi::Mesh mesh() const { return bsi::build_mesh(atlas()); }
  const bsi::Atlas& atlas() const { return sampled_ ? sampled_->sampling.atlas : image_; }
  // Returns the points (m) of atlas() by particle, from the points of the recorded image by
  // particle.
  std::vector<Vec3> points(std::vector<Vec3> image) const;
  // Returns the values at the points of atlas(), from one value per particle of the recorded image.
  std::vector<double> values(std::vector<double> image) const;
  // Returns an upper bound (m) of the distance of the curved surface from the triangles; 0 if the
  // surface is not curved.
  double deviation(std::span<const Vec3> image) const;
  bool is_curved() const { return sampled_.has_value(); }

 private:
  struct Sampled {
    Sampled(const bsi::Atlas& image, int degree)
        : surface(image, degree), sampling(image, surface) {}
    SplineSurface surface;
    SplineSampling sampling;
  };
  std::vector<Vec3> on_samples(std::span<const Vec3> image) const;

  bsi::Atlas image_;
  std::optional<Sampled> sampled_;
};

}  // namespace weft::sim
