// The triangulated surface of a recorded body.
#pragma once

#include <optional>
#include <vector>

#include "sim/scene/spline_sampling.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// The triangulated surface of a recorded body. For a shell recorded as a whole, it has the
// triangles on which contact acts: their corners are samples of the spline surface through the
// points of the recorded image. For any other body, and for a shell recorded in part, it has the
// triangles of the recorded image.
class RecordedSurface {
 public:
  explicit RecordedSurface(const TrajectoryBody& body);

  // Returns the triangles. Their corners are particles of atlas(). Throws std::invalid_argument if
  // bsi::build_mesh() does.
  bsi::Mesh mesh() const { return bsi::build_mesh(atlas()); }
  // Returns the atlas of the samples of a curved surface, or else that of the recorded image.
  const bsi::Atlas& atlas() const { return sampled_ ? sampled_->sampling.atlas : image_; }
  // Returns the points (m) of the surface, by particle of atlas(). `image` has the points of the
  // recorded image, by particle of that image.
  std::vector<Vec3> points(std::vector<Vec3> image) const;
  // Returns the values at the points of the surface, by particle of atlas(). `image` has one value
  // per particle of the recorded image.
  std::vector<double> values(std::vector<double> image) const;
  // Returns an upper bound (m) of the distance between the curved surface and its triangles.
  // Returns 0 if the surface is not curved.
  double deviation(std::span<const Vec3> image) const;
  // True if the triangles approximate a curved surface: that of a shell recorded as a whole.
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
