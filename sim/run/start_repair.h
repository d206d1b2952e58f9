// Separates surfaces that intersect slightly in the initial state.
#pragma once

#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

struct RepairedBody {
  int body = 0;         // index into Scene::bodies
  int moved = 0;        // count of its points that moved
  double farthest = 0;  // m, longest way of a point
};

struct StartRepair {
  std::vector<Vec3> position;        // m, by particle of the scene
  std::vector<RepairedBody> bodies;  // those with points that moved, in the order of the scene
  int crossings = 0;                 // count of intersecting pairs of triangles before
};

// Moves points of cloth until no forbidden pair of triangles intersects and all surfaces are
// farther apart than their thickness: to thickness + half of contact.range where they were too
// close. Points that are far from others do not move. Nothing to repair gives a result without
// bodies.
//
// Each part that a line of intersection cuts off from the rest of its surface (wrong_sides.h) is
// taken through the surface that cuts it off, to the side of the rest. Of two bodies that cut each
// other, the one of which fewer points are cut off is taken through. Both bodies give way alike;
// pinned and sewn points, bodies held as a whole and obstacles do not. Then features that are too
// close are pushed apart along the shortest way between them.
//
// Throws CaseError with the reason, and with the place of a point, for what is not repaired:
//  - a part that reaches deeper than the mean edge of the body, of either, that can move;
//  - surfaces that cross without cutting off a point of either, such as two slotted cards: the line
//    of intersection ends on either surface more than two mean edges from its border;
//  - parts that are held, or that have no room on the right side;
//  - scenes in which a shell has contact, and starts from another run.
//
// Takes as long as 1000 searches for crossings at the most. The same scene gives the same bits.
// Preconditions: contact is enabled, and the positions are finite.
StartRepair repair_start(const Scene& scene);

}  // namespace weft::sim
