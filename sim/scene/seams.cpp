#include "sim/scene/seams.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/case/membrane_stiffness.h"
#include "sim/scene/cloth_laws.h"
#include "sim/scene/index_range.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

// Default stiffness of a seam as a multiple of that of the stiffer row of triangles beside it.
constexpr double default_stiffness = 60;
// Openings at the start that need no closing_time, as a fraction of the mean edge.
constexpr double closed_gap = 1e-3;
// A point this near a vertex, as a fraction of the length of the border, is the vertex.
constexpr double same_place = 1e-9;

// A border of a body, or a part of it.
struct SewnBorder {
  int body = 0;               // in the order of the case
  bool is_first = false;      // the side that the case names first
  std::vector<int> vertices;  // particles along it, counted within the body
  bool is_closed = false;
  // Fractions of the rest length where the vertices lie; one more, which is 1, if it is closed.
  std::vector<double> fractions;
  double length = 0;  // m, at rest

  int segment_count() const { return static_cast<int>(fractions.size()) - 1; }
  int start_of(int segment) const { return vertices[segment]; }
  int end_of(int segment) const {
    return vertices[(segment + 1) % static_cast<int>(vertices.size())];
  }
};

// A point of a border.
struct BorderPoint {
  int segment = 0;
  std::array<int, 2> nodes{};
  double weight = 1;  // of the first node
};

BorderPoint point_at(const SewnBorder& border, double fraction) {
  const auto after = std::ranges::upper_bound(border.fractions, fraction);
  const int segment = std::clamp(static_cast<int>(after - border.fractions.begin()) - 1, 0,
                                 border.segment_count() - 1);
  const double first = border.fractions[segment], last = border.fractions[segment + 1];
  const int start = border.start_of(segment), end = border.end_of(segment);
  if (fraction - first < same_place) return {segment, {start, start}, 1};
  if (last - fraction < same_place) return {segment, {end, end}, 1};
  return {segment, {start, end}, (last - fraction) / (last - first)};
}

// The place on the other border that belongs to a place on one: both by their fractions.
struct Matching {
  bool is_closed = false, is_reversed = false;
  double offset = 0;

  double operator()(double fraction) const {
    if (!is_closed) return is_reversed ? 1 - fraction : fraction;
    const double other = offset + (is_reversed ? -fraction : fraction);
    return other - std::floor(other);
  }
};

class SeamBuilder {
 public:
  SeamBuilder(const Scene& scene, const SeamCase& source) : scene_(scene), source_(source) {}

  Seam build(int number) {
    SewnBorder one = border(source_.body, source_.edge, source_.range, source_.patch);
    one.is_first = true;
    SewnBorder other = border(source_.to, source_.to_edge, source_.to_range, source_.to_patch);
    if (one.is_closed != other.is_closed) {
      fail("an edge that is closed sewn to one that is open",
           "expected two closed edges, or a range of the closed one");
    }
    if (one.vertices.size() < other.vertices.size()) std::swap(one, other);
    const Matching matching = matching_of(one, other);
    Seam seam;
    seam.source = &source_;
    seam.number = number;
    seam.body = one.body;
    seam.to = other.body;
    add_stitches(one, other, matching, seam);
    require_closed(seam, other);
    seam.stiffness = source_.stiffness.value_or(0);
    add_folds(one, other, matching, seam);
    return seam;
  }

 private:
  // An edge of a mesh at a border, with the triangle beside it.
  struct Side {
    int triangle = -1, edge = 0, opposite = 0;
    bool is_along = false;  // the triangle's own direction is that of the border
    double height = 0;      // m, of the triangle on the edge, at rest
    double stiffness = 0;   // N m, against bending about the edge
  };

  [[noreturn]] void fail(const std::string& what, const std::string& hint) const {
    throw CaseError(source_.location, what, hint);
  }
  const SceneBody& body_of(const SewnBorder& border) const {
    return scene_.bodies[scene_.case_order[border.body]];
  }
  Vec3 place(const SewnBorder& border, int vertex) const {
    return scene_.initial_position[body_of(border).first_particle + vertex];
  }
  Vec3 place(const SewnBorder& border, const BorderPoint& point) const {
    return point.weight * place(border, point.nodes[0]) +
           (1 - point.weight) * place(border, point.nodes[1]);
  }

  SewnBorder border(const std::string& name, ImageEdge edge, const std::vector<int>& range,
                    int patch) const {
    SewnBorder border;
    const auto found = std::ranges::find(scene_.source.body, name, &BodyCase::name);
    border.body = static_cast<int>(found - scene_.source.body.begin());
    const SceneBody& body = body_of(border);
    const auto& patches = body.atlas.patches();
    if (patch >= static_cast<int>(patches.size())) {
      fail("body " + in_quotes(name) + " has no patch " + std::to_string(patch),
           "expected 0.." + std::to_string(patches.size() - 1));
    }
    const bsi::Patch& image = patches[patch];
    const bool is_row = edge == ImageEdge::first_row || edge == ImageEdge::last_row;
    const bool is_last = edge == ImageEdge::last_row || edge == ImageEdge::last_col;
    if (is_row ? image.wrap_v : image.wrap_u) {
      fail("body " + in_quotes(name) + " is closed along its " + (is_row ? "rows" : "columns") +
               ": it has no such edge",
           "expected an edge where its surface ends");
    }
    const int across = is_last ? (is_row ? image.rows : image.cols) - 1 : 0;
    const int count = is_row ? image.cols : image.rows;
    const IndexRange part = resolve_range(range, count, "seam", "range", source_.location);
    for (int i = part.first; i <= part.last; ++i)
      border.vertices.push_back(is_row ? body.atlas.particle(patch, across, i)
                                       : body.atlas.particle(patch, i, across));
    border.is_closed = (is_row ? image.wrap_u : image.wrap_v) && range.empty();
    if (border.vertices.size() < 2)
      fail("a range of a single vertex", "expected two vertices at least");
    find_fractions(border);
    return border;
  }

  void find_fractions(SewnBorder& border) const {
    const std::vector<Vec3>& rest = body_of(border).rest;
    const int count = static_cast<int>(border.vertices.size());
    border.fractions.push_back(0);
    for (int i = 0; i < (border.is_closed ? count : count - 1); ++i) {
      border.length += (rest[border.end_of(i)] - rest[border.start_of(i)]).norm();
      border.fractions.push_back(border.length);
    }
    if (border.length == 0) fail("an edge without length", "expected an edge that is no point");
    for (double& fraction : border.fractions) fraction /= border.length;
    border.fractions.back() = 1;
  }

  // Sum of the squares of the openings at the start, m^2.
  double openings(const SewnBorder& one, const SewnBorder& other, const Matching& matching) const {
    double sum = 0;
    for (std::size_t i = 0; i < one.vertices.size(); ++i) {
      sum +=
          (place(one, one.vertices[i]) - place(other, point_at(other, matching(one.fractions[i]))))
              .squaredNorm();
    }
    return sum;
  }

  // Two parts of an edge that begin or end at the same vertex are the sides of a dart: they close
  // from that vertex on. Returns whether one of them is then reversed, or nothing for other sides.
  static std::optional<bool> reversed_in_dart(const SewnBorder& one, const SewnBorder& other) {
    if (one.is_closed || one.body != other.body) return std::nullopt;
    const auto &mine = one.vertices, &others = other.vertices;
    const bool goes_along = mine.front() == others.front() || mine.back() == others.back();
    const bool is_reversed = mine.front() == others.back() || mine.back() == others.front();
    return goes_along == is_reversed ? std::nullopt : std::optional(is_reversed);
  }

  // Chooses the direction, and on closed edges the vertex to begin with, so that the sides lie
  // closest at the start. The sides of a dart have only one direction.
  Matching matching_of(const SewnBorder& one, const SewnBorder& other) const {
    const std::optional<bool> direction = reversed_in_dart(one, other);
    Matching best;
    double least = std::numeric_limits<double>::infinity();
    const std::size_t offsets = one.is_closed ? other.vertices.size() : 1;
    for (const bool is_reversed : {false, true}) {
      if (is_reversed != direction.value_or(is_reversed)) continue;
      for (std::size_t i = 0; i < offsets; ++i) {
        const Matching matching{one.is_closed, is_reversed, other.fractions[i]};
        const double sum = openings(one, other, matching);
        if (!(sum < least)) continue;
        least = sum;
        best = matching;
      }
    }
    return best;
  }

  void add_stitches(const SewnBorder& one, const SewnBorder& other, const Matching& matching,
                    Seam& seam) const {
    const int count = static_cast<int>(one.vertices.size());
    for (int i = 0; i < count; ++i) {
      const BorderPoint point = point_at(other, matching(one.fractions[i]));
      const bool is_vertex = point.nodes[0] == point.nodes[1];
      // A vertex where an edge meets itself is sewn already.
      if (one.body == other.body && is_vertex && one.vertices[i] == point.nodes[0]) continue;
      Stitch stitch{one.vertices[i], point.nodes, point.weight, 0, 0};
      const bool begins = i == 0 && !one.is_closed, ends = i == count - 1 && !one.is_closed;
      const int before = i == 0 ? count - 1 : i - 1;
      if (!begins) stitch.length += 0.5 * length_of(one, before);
      if (!ends) stitch.length += 0.5 * length_of(one, i);
      stitch.gap = (place(one, stitch.vertex) - place(other, point)).norm();
      seam.largest_gap = std::max(seam.largest_gap, stitch.gap);
      seam.stitches.push_back(stitch);
    }
    if (seam.stitches.empty())
      fail("the seam sews an edge to itself", "expected two edges, or two parts of one");
  }
  static double length_of(const SewnBorder& border, int segment) {
    return border.length * (border.fractions[segment + 1] - border.fractions[segment]);
  }

  void require_closed(const Seam& seam, const SewnBorder& other) const {
    const double mean = other.length / other.segment_count();
    if (source_.closing_time > 0 || seam.largest_gap <= closed_gap * mean) return;
    fail("the edges of the seam start up to " + rounded_text(seam.largest_gap) + " m apart",
         "expected edges that meet, or a closing_time in which they are drawn together");
  }

  std::vector<Side> sides_of(const SewnBorder& border) const {
    const SceneBody& body = body_of(border);
    const bsi::Mesh mesh = bsi::build_mesh(body.atlas);  // the body's own mesh may have no edges
    std::vector<Side> sides(border.segment_count());
    std::vector<int> segment_from(body.particle_count(), -1);  // by the vertex where it starts
    for (int s = 0; s < border.segment_count(); ++s) segment_from[border.start_of(s)] = s;
    for (const bsi::Edge& edge : mesh.edges) {
      for (const bool is_along : {true, false}) {
        const int s = segment_from[edge.vertex[is_along ? 0 : 1]];
        if (s < 0 || border.end_of(s) != edge.vertex[is_along ? 1 : 0]) continue;
        if (edge.triangle[1] >= 0) {
          fail("an edge of body " + in_quotes(body.name) + " at which its surface does not end",
               "expected a border: there the patches of the shape are joined already");
        }
        sides[s] = side_of(body, mesh, edge, is_along);
      }
    }
    return sides;
  }
  static Side side_of(const SceneBody& body, const bsi::Mesh& mesh, const bsi::Edge& edge,
                      bool is_along) {
    Side side;
    side.triangle = edge.triangle[0];
    side.opposite = edge.opposite[0];
    side.is_along = is_along;
    const auto& corners = mesh.triangles[side.triangle];
    side.edge = static_cast<int>(std::ranges::find(corners, side.opposite) - corners.begin());
    const Vec3 along = body.rest[edge.vertex[1]] - body.rest[edge.vertex[0]];
    const Vec3 arm = body.rest[side.opposite] - body.rest[edge.vertex[0]];
    side.height = along.cross(arm).norm() / along.norm();
    side.stiffness = stiffness_across(body, side.triangle, along);
    return side;
  }

  // Returns the stiffness against bending about an edge, N m.
  static double stiffness_across(const SceneBody& body, int triangle, const Vec3& edge) {
    if (!body.material->orthotropic_bending) return body.material->bending_stiffness;
    const materials::OrthotropicModuli moduli = flat_bending_moduli(*body.material);
    const Vec3 warp = warp_direction(body, triangle);
    const double cc = warp.cross(edge).squaredNorm() / (warp.squaredNorm() * edge.squaredNorm());
    const double ss = 1 - cc;
    return moduli.warp * cc * cc + 2 * (moduli.coupling + 2 * moduli.shear) * cc * ss +
           moduli.weft * ss * ss;
  }

  void add_folds(const SewnBorder& one, const SewnBorder& other, const Matching& matching,
                 Seam& seam) {
    const std::vector<Side> sides = sides_of(one), others = sides_of(other);
    if (seam.stiffness == 0)
      seam.stiffness =
          default_stiffness * std::max(stiffness_of(one, sides), stiffness_of(other, others));
    const auto bends = [&](const SewnBorder& border) {
      return body_of(border).material->resists_bending();
    };
    if (source_.bending != SeamBending::continuous || !bends(one) || !bends(other)) return;
    for (int s = 0; s < one.segment_count(); ++s) {
      const double middle = 0.5 * (one.fractions[s] + one.fractions[s + 1]);
      const Side& beyond = others[point_at(other, matching(middle)).segment];
      add_fold(one, sides[s], other, beyond, matching, seam);
    }
    Matching inverse = matching;
    if (matching.is_closed && !matching.is_reversed) inverse.offset = -matching.offset;
    for (int s = 0; s < other.segment_count(); ++s) {
      const double middle = 0.5 * (other.fractions[s] + other.fractions[s + 1]);
      const Side& beyond = sides[point_at(one, inverse(middle)).segment];
      add_fold(other, others[s], one, beyond, matching, seam);
    }
  }

  void add_fold(const SewnBorder& own, const Side& side, const SewnBorder& other,
                const Side& beyond, const Matching& matching, Seam& seam) const {
    if (side.triangle < 0 || beyond.triangle < 0) return;  // a segment without length
    // The edge turns so that the moments on its two sides are the same, at small curvatures.
    const double yielding = side.height / side.stiffness;
    const double all = yielding + beyond.height / beyond.stiffness;
    const bool is_oriented = side.is_along != (beyond.is_along != matching.is_reversed);
    const double angle = source_.angle_deg * std::numbers::pi / 180;
    seam.folds.push_back({own.body, other.body, side.triangle, side.edge, beyond.opposite,
                          2 * yielding / all, own.is_first || is_oriented ? angle : -angle});
  }
  // The stiffness (N/m^2) of the row of triangles at a border across it, per length.
  double stiffness_of(const SewnBorder& border, const std::vector<Side>& sides) const {
    double height = 0;
    for (const Side& side : sides) height += side.height / static_cast<double>(sides.size());
    return largest_membrane_stiffness(*body_of(border).material) / height;
  }

  const Scene& scene_;
  const SeamCase& source_;
};

}  // namespace

void add_seams(Scene& scene) {
  for (const SeamCase& source : scene.source.seam) {
    scene.seams.push_back(SeamBuilder(scene, source).build(static_cast<int>(scene.seams.size())));
  }
}

std::vector<const SeamFold*> seam_folds_of(const Scene& scene, int body) {
  std::vector<const SeamFold*> folds;
  for (const Seam& seam : scene.seams) {
    for (const SeamFold& fold : seam.folds) {
      if (scene.case_order[fold.body] == body) folds.push_back(&fold);
    }
  }
  std::ranges::stable_sort(folds, {}, [](const SeamFold* fold) { return fold->triangle; });
  return folds;
}

bool closes_after(const Scene& scene, int body, double time) {
  return std::ranges::any_of(scene.seams, [&](const Seam& seam) {
    const bool is_of_body =
        scene.case_order[seam.body] == body || scene.case_order[seam.to] == body;
    return is_of_body && seam.source->closing_time > time;
  });
}

}  // namespace weft::sim
