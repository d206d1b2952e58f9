#include "sim/view/recorded_surface.h"

namespace weft::sim {

RecordedSurface::RecordedSurface(const TrajectoryBody& body) : image_(body.atlas) {
  if (body.spline_degree > 0 && !body.is_part()) sampled_.emplace(body.atlas, body.spline_degree);
}

std::vector<Vec3> RecordedSurface::on_samples(std::span<const Vec3> image) const {
  const std::vector<Vec3> control = sampled_->surface.interpolate(image_, image);
  std::vector<Vec3> points;
  sampled_->sampling.map.points_of(control, atlas().particle_count(), points);
  return points;
}

std::vector<Vec3> RecordedSurface::points(std::vector<Vec3> image) const {
  return sampled_ ? on_samples(image) : image;
}

std::vector<double> RecordedSurface::values(std::vector<double> image) const {
  if (!sampled_) return image;
  std::vector<Vec3> vectors;
  for (const double value : image) vectors.emplace_back(value, 0, 0);
  std::vector<double> result;
  for (const Vec3& each : on_samples(vectors)) result.push_back(each.x());
  return result;
}

double RecordedSurface::deviation(std::span<const Vec3> image) const {
  if (!sampled_) return 0;
  return deviation_from_samples(image_, sampled_->surface,
                                sampled_->surface.interpolate(image_, image));
}

}  // namespace weft::sim
