#include "materials/drag.h"

namespace weft::materials {

namespace {

struct Flow {
  Vec3 relative_wind;          // w, m/s
  Vec3 normal = Vec3::Zero();  // unit, or zero without area
  double area = 0;             // m^2
};

Flow flow_past(const Nodes3& x, const Nodes3& v, const Vec3& wind) {
  Flow flow;
  flow.relative_wind = wind - (v.col(0) + v.col(1) + v.col(2)) / 3;
  const Vec3 area = 0.5 * Vec3(x.col(1) - x.col(0)).cross(Vec3(x.col(2) - x.col(0)));
  flow.area = area.norm();
  if (flow.area != 0) flow.normal = area / flow.area;
  return flow;
}

// B w, kg/(m^2 s).
Vec3 weighted_wind(const Drag& drag, const Flow& flow) {
  return drag.tangential * flow.relative_wind +
         ((drag.normal - drag.tangential) * dot(flow.relative_wind, flow.normal)) * flow.normal;
}

}  // namespace

Vec3 drag_force(const Drag& drag, const Nodes3& x, const Nodes3& v, const Vec3& wind) {
  const Flow flow = flow_past(x, v, wind);
  return (0.5 * flow.area * flow.relative_wind.norm()) * weighted_wind(drag, flow);
}

Mat3 drag_damping(const Drag& drag, const Nodes3& x, const Nodes3& v, const Vec3& wind) {
  const Flow flow = flow_past(x, v, wind);
  const Vec3 weighted = weighted_wind(drag, flow);
  Mat3 result = (drag.normal - drag.tangential) * flow.normal * flow.normal.transpose();
  result.diagonal().array() += drag.tangential;
  const double power = dot(weighted, flow.relative_wind);
  if (power > 0) result += weighted * (weighted / power).transpose();
  return (0.5 * flow.area * flow.relative_wind.norm()) * result;
}

}  // namespace weft::materials
