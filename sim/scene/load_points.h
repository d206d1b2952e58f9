// The points of surfaces on which loads act.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

// A point of a body's surface: a sum of its particles (local indices), of nodes_per_load_point().
// The parameters u and v run along the columns and the rows of the image. On an edge, u runs along
// it and v into the surface, and the normal a_u x a_v is that of the surface.
struct LoadPoint {
  SplineSurface::Point at;
  double measure = 1;  // part of the length (m) or area (m^2) at rest; of a vertex 1
  // Area (m^2) at rest per area of the parameters: measure / area_factor is the point's part of the
  // parameters.
  double area_factor = 1;
};

// 4 for cloth, whose cells are interpolated between their corners; of shells those of an element.
int nodes_per_load_point(const SceneBody& body);

// Returns the points that carry a load: the selected vertices, two Gauss points per segment of the
// edges, or four per cell of the surface. `positions` (m) has the particles of the body at the
// start; a box selects points there. Throws CaseError at the load if it selects nothing or an edge
// that a closed surface has not.
std::vector<LoadPoint> find_load_points(const SceneBody& body, const LoadCase& load,
                                        std::span<const Vec3> positions);

}  // namespace weft::sim
