// Describes the tables of pins, motions, ties and loads.
#include "sim/case/case_schema.h"
#include "sim/case/field_makers.h"

namespace weft::sim {

namespace {

std::vector<Field> fields_of(VertexSelection& target) {
  auto& [corners, edges, rows, cols, patch, region_min, region_max] = target;
  return {
      field("corners", &corners, "Corners of the image, row before column, or all four.")
          .entries(1, 4)
          .out_of({"first_first", "first_last", "last_first", "last_last", "all"}),
      field("edges", &edges, "Borders of the image.")
          .entries(1, 4)
          .out_of({"first_row", "last_row", "first_col", "last_col"}),
      field("rows", &rows, "", any,
            "First and last row of a block, counted from 0, or from -1 backwards. Without cols: "
            "whole rows.")
          .entries(2, 2),
      field("cols", &cols, "", any,
            "First and last column of a block, counted from 0, or from -1 backwards. Without rows: "
            "whole columns.")
          .entries(2, 2),
      field("patch", &patch, "", at_least(0),
            "Patch in which corners, edges, rows and cols are counted."),
      field("region_min", &region_min, "m", any,
            "Lower corner of a box in space. It selects all vertices that are in it at the start, "
            "or outside of it by less than 1e-9 of the body's size; of a shell, those whose points "
            "of its surface are."),
      field("region_max", &region_max, "m", any, "Upper corner of the box."),
  };
}

Choice edge_choice(ImageEdge* target) {
  return choice(target, {{ImageEdge::first_row, "first_row"},
                         {ImageEdge::last_row, "last_row"},
                         {ImageEdge::first_col, "first_col"},
                         {ImageEdge::last_col, "last_col"}});
}

}  // namespace

Table describe(KeyframeCase& target) {
  auto& [time, translation, rotation] = target;
  return {{
      field("time", &time, "s", not_negative, "Time of the keyframe; later than the one before.")
          .needed(),
      field("translation", &translation, "m", any, "Displacement from the start."),
      field("rotation_deg", &rotation, "degrees", any,
            "Rotation from the start about the centre: axis times angle."),
  }};
}

Table describe(MotionCase& target) {
  auto& [velocity, angular_velocity, centre, start, stop, keyframes, location] = target;
  Table result{{
      field("velocity", &velocity, "m/s", any, "Constant velocity.").not_with("keyframes"),
      field("angular_velocity_deg", &angular_velocity, "degrees/s", any,
            "Constant rotation about the centre: axis times rate.")
          .not_with("keyframes"),
      field("centre", &centre, "m", any, "Centre of the rotation.")
          .with_default("the mean of the moved points at the start"),
      field("start_time", &start, "s", not_negative, "Start of the motion; at rest before.")
          .not_with("keyframes"),
      field("stop_time", &stop, "s", positive,
            "End of the motion, later than start_time; at rest after.")
          .with_default("never")
          .not_with("keyframes"),
      field("keyframes", tables(&keyframes),
            "Poses to pass through, instead of constant velocities."),
  }};
  result.location = &location;
  return result;
}

Table describe(PinCase& target) {
  auto& [vertices, clamp, axes, symmetry, hold_time, release_time, motion, location] = target;
  Table result{fields_of(vertices)};
  for (Field& each : std::vector<Field>{
           field("clamp", &clamp,
                 "Holds the surface's tangent plane at the held edges, too, as it is when the pin "
                 "takes hold. Needs a material with bending_stiffness, and an edge of which the "
                 "pin holds both ends.")
               .not_with("symmetry_normal"),
           field("axes", &axes,
                 "Directions in which the vertices are held; along the others they are free. Not "
                 "with clamp.")
               .entries(1, 2)
               .out_of({"x", "y", "z"})
               .with_default("all three")
               .not_with("clamp"),
           field("symmetry_normal", &symmetry, "", any,
                 "Normal of a plane of symmetry on which the vertices of a shell lie: they stay on "
                 "it, and a shell whose whole border the pin names stays perpendicular to it.")
               .with_default("none")
               .not_with("axes"),
           field("hold_time", &hold_time, "s", not_negative,
                 "Time at which the pin takes hold of its vertices where they then are; they are "
                 "free before. Not with time.method = \"static\"."),
           field("release_time", &release_time, "s", positive,
                 "Time at which the pin lets go, later than hold_time; its vertices keep their "
                 "velocity. Not with time.method = \"static\".")
               .with_default("never"),
           field("motion", table(&motion),
                 "Motion of the held vertices; without it they stay at rest."),
       })
    result.fields.push_back(std::move(each));
  result.location = &location;
  return result;
}

Table describe(TieCase& target) {
  auto& [vertices, body, to, stiffness, break_force, location] = target;
  Table result{{
      field("body", &body, "Name of the body whose vertices are tied.")
          .needed()
          .named_with_letters(),
      field("to", &to,
            "Name of another body, to whose nearest points the vertices are tied, or of an "
            "obstacle.")
          .needed()
          .named_with_letters(),
      field("stiffness", &stiffness, "N/m", positive,
            "Stiffness of all springs of the tie together; each vertex has a part as large as the "
            "area around it."),
      field("break_force", &break_force, "N", positive,
            "Sum of the forces of the springs at which the tie breaks. Not with time.method = "
            "\"static\".")
          .with_default("never"),
  }};
  for (Field& each : fields_of(vertices)) result.fields.push_back(std::move(each));
  result.location = &location;
  return result;
}

Table describe(SeamCase& target) {
  auto& [body, edge, range, patch, to, to_edge, to_range, to_patch, stiffness, bending, angle,
         closing_time, location] = target;
  Table result{{
      field("body", &body, "Name of a body, of cloth.").needed().named_with_letters(),
      field("edge", edge_choice(&edge), "Border of its image that is sewn.").needed(),
      field("range", &range, "", any,
            "First and last vertex along the edge, counted from 0, or from -1 backwards.")
          .entries(2, 2)
          .with_default("the whole edge"),
      field("patch", &patch, "", at_least(0), "Patch of the edge."),
      field("to", &to, "Name of another body, or of the same one.").needed().named_with_letters(),
      field("to_edge", edge_choice(&to_edge), "Border to which it is sewn.").needed(),
      field("to_range", &to_range, "", any, "First and last vertex along that edge.")
          .entries(2, 2)
          .with_default("the whole edge"),
      field("to_patch", &to_patch, "", at_least(0), "Patch of that edge."),
      field("stiffness", &stiffness, "N/m^2", positive,
            "Force per length of the seam and per opening between the edges.")
          .with_default("60 times that of the stiffer row of triangles at the seam"),
      field("bending",
            choice(&bending,
                   {{SeamBending::continuous, "continuous"}, {SeamBending::hinged, "hinged"}}),
            "continuous: the surfaces bend across the seam, each with its own stiffness. hinged: "
            "the seam turns without resistance."),
      field("angle_deg", &angle, "degrees", {-180, 180, true, true},
            "Angle of the fold in which the seam has no moment; positive where the surfaces rise "
            "to the side of their normals.")
          .only_for("bending", {"continuous"}),
      field("closing_time", &closing_time, "s", not_negative,
            "Time in which edges that start apart are drawn together. At 0 they must meet at the "
            "start."),
  }};
  result.location = &location;
  return result;
}

Table describe(LoadCase& target) {
  auto& [vertices, body, type, force, pressure, moment, follower, location] = target;
  Table result{{
      field("body", &body, "Name of the body on which the load acts.")
          .needed()
          .named_with_letters(),
      field("type",
            choice(&type, {{LoadType::point, "point"},
                           {LoadType::line, "line"},
                           {LoadType::area, "area"},
                           {LoadType::pressure, "pressure"},
                           {LoadType::moment, "moment"}}),
            "point: a force at each selected vertex. line: a force along the selected edges. area: "
            "a force on the whole surface, or on the part in the box. pressure: along the normal, "
            "likewise. moment: about the selected edges of a shell, which turns with them."),
      field("force", &force, "N", any,
            "Force: N at each vertex of a point load, N/m of a line load, N/m^2 of an area load; "
            "lengths and areas are those at rest.")
          .needed()
          .only_for("type", {"point", "line", "area"}),
      field(
          "follower", &follower,
          "The force turns with the surface: its components are along the rows of the image, from "
          "column to column, beside that in the surface, and along the normal; of a line load "
          "along the edge, into the surface, and along the normal.")
          .only_for("type", {"point", "line", "area"}),
      field("pressure", &pressure, "Pa", any,
            "Pressure along the normal of the deformed surface, which points to the side from "
            "which columns turn into rows counter-clockwise.")
          .needed()
          .only_for("type", {"pressure"}),
      field("moment", &moment, "N", any,
            "Moment per length of the edge, N m/m. Positive: what continues the surface beyond its "
            "edge would move along the normal.")
          .needed()
          .only_for("type", {"moment"}),
  }};
  for (Field& each : fields_of(vertices)) {
    if (each.key == "patch") each.only_for("type", {"point", "line", "moment"});
    result.fields.push_back(std::move(each));
  }
  result.location = &location;
  return result;
}

}  // namespace weft::sim
