// Bodies that are shells: spline surfaces whose control points are the particles of an image.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

// Gives a body its spline surface. Precondition: its material is a shell. Throws CaseError at the
// shape if an axis has fewer control points than the degree needs, or if patches have only a part
// of a border in common.
void make_spline(SceneBody& body, const BodyCase& from);

// Returns the control points (m, by particle) of the shell through the points of `image` (m, by
// particle). If the image of the body is its control net, returns `image` itself.
std::vector<Vec3> control_points_of(const SceneBody& body, const BodyCase& from,
                                    std::span<const Vec3> image);

// Calls visit(place, point, mass) for the quadrature points of a shell's mass, element by element.
// `mass` (kg) is the point's part of the mass, 0 where the surface has no area. Each element has
// four by four Gauss points, which integrate products of two basis functions exactly on flat nets
// of equal spacing. Precondition, here and below: `rest` of the body holds control points.
using MassVisit =
    std::function<void(const SplineSurface::Place&, const SplineSurface::Point&, double)>;
void visit_shell_mass(const SceneBody& body, const MassVisit& visit);

// Returns the masses (kg) of a shell's control points: the row sums of its mass matrix
// (sim/motion/mass_matrix.h). Throws CaseError at the shape if the rest surface has no area at a
// point.
std::vector<double> shell_masses(const SceneBody& body, const BodyCase& from);

// Gives a shell the surface on which contact acts: points at the ends and in the middle of its
// elements. The shell's thickness grows by twice a bound of the distance between its rest surface
// and the triangles of these points.
void sample_shell(SceneBody& body);

// A control point of the row next to a border, and its neighbour on the border. Their difference
// has the direction of the surface's tangent across the border.
struct BesideBorder {
  int particle = 0, border = 0;
};
// Returns the control points next to each border of a patch that `held` (local indices, sorted)
// contains as a whole.
std::vector<BesideBorder> rows_beside_borders(const SceneBody& body, std::span<const int> held);

// Returns the control points that a clamp of a shell holds (local indices, sorted): those of
// `held`, which the pin selects, and the row next to each border that `held` contains as a whole.
// Both rows together span the tangent planes along the border. Throws CaseError at the pin if
// `held` contains no whole border.
std::vector<int> with_clamped_rows(const SceneBody& body, const PinCase& pin,
                                   std::vector<int> held);

}  // namespace weft::sim
