// Shells: bodies whose surface is a spline with particles as its control points.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

// Sets the spline surface of a body. Precondition: the material of the body is a shell. Throws
// CaseError at the shape if an axis has fewer control points than the degree needs, or if patches
// share only a part of a border.
void make_spline(SceneBody& body, const BodyCase& from);

// Returns the control points (m, by particle) of the shell that passes through the points of
// `image` (m, by particle). If the case gives the control points themselves (control_net), returns
// `image`.
std::vector<Vec3> control_points_of(const SceneBody& body, const BodyCase& from,
                                    std::span<const Vec3> image);

// Returns the map from a body's particles to the points of its image, by particle: points of the
// surface for shells, else the particles.
SurfaceMap map_to_image(const SceneBody& body);
// Returns the mean (m) of image points of a body. `position` has its particles (m). `points` are
// local indices.
Vec3 mean_of_image_points(const SceneBody& body, std::span<const Vec3> position,
                          std::span<const int> points);

// Throws CaseError at the shape if the rest surface has no area at one of the 4 x 4 Gauss points
// per element, or if its normals at neighbouring ones differ by 90 degrees or more: it is folded
// there. Precondition: `rest` of the body has control points.
void require_regular_rest(const SceneBody& body, const BodyCase& from);

// Calls visit(place, point, mass) for the quadrature points of a shell's mass, element by element.
// `mass` (kg) is the mass that the point stands for, 0 where the surface has no area. Each element
// has 4 x 4 Gauss points. They integrate products of two basis functions exactly where the area per
// parameter area is constant. Precondition: `rest` of the body has control points.
using MassVisit =
    std::function<void(const SplineSurface::Place&, const SplineSurface::Point&, double)>;
void visit_shell_mass(const SceneBody& body, const MassVisit& visit);

// Returns the masses (kg) of a shell's control points: the row sums of its mass matrix
// (sim/motion/mass_matrix.h). Precondition: `rest` of the body has control points.
std::vector<double> shell_masses(const SceneBody& body);

// Sets the surface of a shell on which contact acts. Its points lie at the ends and in the middle
// of the elements. The thickness of the shell grows by twice a bound of the distance between its
// rest surface and the triangles of these points. Precondition: `rest` of the body has control
// points.
void sample_shell(SceneBody& body);

// A control point in the row or column next to a border, and its neighbour on the border. Their
// difference has the direction of the surface's tangent across the border.
struct BesideBorder {
  int particle = 0, border = 0;
};
// Returns the control points next to each border of a patch whose control points all lie in `held`
// (local indices, sorted).
std::vector<BesideBorder> rows_beside_borders(const SceneBody& body, std::span<const int> held);

// Returns the control points that a clamp of a shell holds (local indices, sorted). These are
// `held`, the control points that the pin selects, and the row or column next to each border that
// lies wholly in `held`. Both together span the tangent planes along the border. Throws CaseError
// at the pin if no border lies wholly in `held`.
std::vector<int> with_clamped_rows(const SceneBody& body, const PinCase& pin,
                                   std::vector<int> held);

}  // namespace weft::sim
