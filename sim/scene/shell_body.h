// Bodies that are shells: spline surfaces whose control points are the particles of an image.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

// Gives a body its spline surface. Precondition: its material is a shell. Throws CaseError at the
// shape if an axis has fewer control points than the degree needs.
void make_spline(SceneBody& body, const BodyCase& from);

// Returns the control points of a shell for an image of points on it (m, by particle): the image
// itself if the body's image is its control net.
std::vector<Vec3> control_points_of(const SceneBody& body, const BodyCase& from,
                                    std::span<const Vec3> image);

// Calls visit(place, point, mass) for points of a shell's rest surface with their parts of its mass
// (kg), element by element: four by four Gauss points, which integrate products of two basis
// functions exactly on flat nets of equal spacing. The mass is 0 where the surface has no area.
// Precondition, here and below: `rest` holds control points.
using MassVisit =
    std::function<void(const SplineSurface::Place&, const SplineSurface::Point&, double)>;
void visit_shell_mass(const SceneBody& body, const MassVisit& visit);

// Returns the masses (kg) of a shell's control points: the row sums of its mass matrix
// (sim/motion/mass_matrix.h). Throws CaseError at the shape if the rest surface has no area at a
// point.
std::vector<double> shell_masses(const SceneBody& body, const BodyCase& from);

// Gives a shell the surface on which contact acts: points at the ends and in the middle of its
// elements. The shell's thickness grows by twice the largest distance of its rest surface from the
// triangles between these points.
void sample_shell(SceneBody& body);

// A control point of the row next to a border, and the one beside it on the border: together they
// span the tangent of the surface across the border.
struct BesideBorder {
  int particle = 0, border = 0;
};
// Lists the control points next to each border of a patch that `held` (local indices, sorted)
// contains as a whole.
std::vector<BesideBorder> rows_beside_borders(const SceneBody& body, std::span<const int> held);

// Adds the control points that a clamp holds beside those that its pin names (local indices,
// sorted): the row next to each border that it names as a whole. Both rows together span the
// tangent planes along the border. Throws CaseError at the pin if it names no whole border.
std::vector<int> with_clamped_rows(const SceneBody& body, const PinCase& pin,
                                   std::vector<int> held);

}  // namespace weft::sim
