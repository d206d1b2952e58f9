// The triangles of a surface around each of its vertices, up to a geodesic distance at rest.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "bsi/geometry_image.h"

namespace weft::bsi {

// The neighbourhood of a vertex v is a set of triangles. It contains the triangles with the vertex
// v and, with a triangle, every triangle that shares a vertex with it and comes within `radius` of
// v at rest. It is therefore the part of the surface inside a ball around v that is connected with
// v inside this ball.
//
// Every point within the geodesic distance `radius` of v lies in the neighbourhood, because the
// shortest path to it stays in the ball. On a flat surface, no triangle beyond that distance
// belongs to it. On a folded surface, triangles farther away along the surface may belong to it,
// but only those that the ball around v contains at rest in one piece with v.
//
// Distances at rest do not change, so that whatever depends on neighbourhoods alone is constant in
// time.
class Neighbourhoods {
 public:
  // `rest` holds positions (m) by vertex. The mesh must outlive the object. Precondition: radius
  // >= 0, m. O(triangles in all neighbourhoods) time. A neighbourhood is stored in runs of
  // consecutive triangles, about two per row of the image that it meets.
  Neighbourhoods(const Mesh& mesh, std::span<const Vec3> rest, double radius, int threads = 1);
  // Stores neighbourhoods that are given by their triangles, by vertex. The vertices may belong to
  // another surface. The mesh, of `vertex_count` vertices, must outlive the object.
  Neighbourhoods(const Mesh& mesh, int vertex_count, std::span<const std::vector<int>> triangles);

  // True if every neighbourhood consists of the triangles with the vertex itself. Nothing is stored
  // then, and the functions below return false for features without a common vertex.
  bool are_rings() const { return runs_.empty(); }
  // True if the triangle belongs to the neighbourhood of the vertex. O(log runs).
  bool contains(int vertex, int triangle) const;
  // True if both triangles of the quad do.
  bool contains_quad(int vertex, int quad) const;
  // True if every triangle of the edge does.
  bool contains_edge(int vertex, const Edge& edge) const;
  // Returns the triangles of the neighbourhood, sorted.
  std::vector<int> triangles(int vertex) const;
  // True if a triangle with the vertex `other` belongs to the neighbourhood of `vertex`.
  bool touches(int vertex, int other) const;
  // True if one edge has an end whose neighbourhood contains every triangle of the other edge. The
  // edges must not have a common vertex. At rest, edges of a flat surface that are no neighbours
  // are at least `radius` apart.
  bool are_neighbours(const Edge& one, const Edge& other) const;

 private:
  struct Run {
    int first = 0, last = 0;  // triangles first .. last
  };
  struct Flood;

  std::span<const int> triangles_of(int vertex) const {
    return std::span(triangles_)
        .subspan(triangle_start_[vertex], triangle_start_[vertex + 1] - triangle_start_[vertex]);
  }
  void list_triangles(int vertex_count);
  bool collect(int vertex, std::span<const Vec3> rest, Flood& flood) const;
  bool holds_run(int vertex, int first, int last) const;

  const Mesh& mesh_;
  double squared_radius_;
  std::vector<int> triangle_start_, triangles_;  // triangles of each vertex, in compressed rows
  // Sorted runs of each neighbourhood, in compressed rows. Empty if all are rings.
  std::vector<int> run_start_;
  std::vector<Run> runs_;
};

}  // namespace weft::bsi
