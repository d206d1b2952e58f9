// Describes the table [static]: equilibria and load paths.
#include "sim/case/case_schema.h"
#include "sim/case/field_makers.h"

namespace weft::sim {

Table describe(StaticCase& target) {
  auto& [loading, at_limit_point, scale_gravity, first_load_factor, largest_step,
         largest_load_factor, largest_displacement] = target;
  return {{
      field("loading",
            choice(&loading, {{Loading::proportional, "proportional"},
                              {Loading::in_time, "in_time"},
                              {Loading::arc_length, "arc_length"}}),
            "Course of the loads. proportional: gravity and loads grow in proportion to the time, "
            "from zero to their full values at time.duration. in_time: each frame is the "
            "equilibrium at its time, under the loads, curves and motions of that time. "
            "arc_length: each frame is a point on the path of equilibria under loads times one "
            "factor, which may fall; nothing else changes."),
      field("at_limit_point",
            choice(&at_limit_point, {{AtLimitPoint::stop, "stop"}, {AtLimitPoint::jump, "jump"}}),
            "Action where no equilibrium follows near the last one. stop: the run ends there. "
            "jump: it goes on from a stable equilibrium elsewhere, to which the body relaxes.")
          .only_for("loading", {"in_time"}),
      field("scale_gravity", &scale_gravity, "Multiplies gravity by the load factor, too.")
          .only_for("loading", {"arc_length"}),
      field("first_load_factor", &first_load_factor, "", positive,
            "Load factor of the first point, as the tangent at the start predicts it; it sets the "
            "length of the first step.")
          .only_for("loading", {"arc_length"}),
      field("largest_step", &largest_step, "m", positive,
            "Longest step along the path: root mean square, over the free vertices, of the "
            "displacement between two points.")
          .with_default("5 times the first step")
          .only_for("loading", {"arc_length"}),
      field("largest_load_factor", &largest_load_factor, "", positive,
            "The path ends with the first point whose load factor reaches this.")
          .with_default("no limit")
          .only_for("loading", {"arc_length"}),
      field(
          "largest_displacement", &largest_displacement, "m", positive,
          "The path ends with the first point at which a vertex is as far from its start as this.")
          .with_default("no limit")
          .only_for("loading", {"arc_length"}),
  }};
}

}  // namespace weft::sim
