#include "bsi/detail/detail_border.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace weft::bsi {

namespace {

// Fewest quads around the wrapped axis of a patch that can become coarser. With five quads, level 2
// has four blocks around the axis. Fewer than three blocks would touch each other on both sides and
// fold the surface onto itself.
constexpr int fewest_round_a_wrap = 5;

// Sets found[patch] to 1 if two of a patch's texels share a particle, or if one of its inner texels
// shares a particle with any other texel. Blocks beside such a seam could touch each other more
// than once.
void mark_sewn_to_themselves(const Atlas& atlas, std::vector<char>& found) {
  if (atlas.is_identity()) return;
  const int patches = static_cast<int>(atlas.patches().size());
  std::vector<int> holders(atlas.particle_count(), 0);
  std::vector<int> last_patch(atlas.particle_count(), -1);
  for (int patch = 0; patch < patches; ++patch) {
    for (int i = 0; i < atlas.patches()[patch].texel_count(); ++i) {
      const int particle = atlas.particle_of_texel(atlas.first_texel(patch) + i);
      if (last_patch[particle] == patch) found[patch] = 1;
      last_patch[particle] = patch;
      ++holders[particle];
    }
  }
  for (int patch = 0; patch < patches; ++patch) {
    const Patch& size = atlas.patches()[patch];
    for (int row = size.wrap_v ? 0 : 1; row < size.quad_rows(); ++row) {
      for (int col = size.wrap_u ? 0 : 1; col < size.quad_cols(); ++col) {
        if (holders[atlas.particle(patch, row, col)] > 1) found[patch] = 1;
      }
    }
  }
}

// A side of a patch: its first or last row or column, as particles in order. A wrapped axis has no
// sides at its ends. A side is closed if it runs around a wrapped axis.
struct Side {
  int patch = 0;
  bool along_u = false;
  bool is_closed = false;
  std::vector<int> particles;
};

std::vector<Side> open_sides(const Atlas& atlas) {
  std::vector<Side> sides;
  for (int patch = 0; patch < static_cast<int>(atlas.patches().size()); ++patch) {
    const Patch& size = atlas.patches()[patch];
    const auto add = [&](bool along_u, int line) {
      Side side{patch, along_u, along_u ? size.wrap_u : size.wrap_v, {}};
      for (int i = 0; i < (along_u ? size.cols : size.rows); ++i) {
        side.particles.push_back(along_u ? atlas.particle(patch, line, i)
                                         : atlas.particle(patch, i, line));
      }
      sides.push_back(std::move(side));
    };
    for (const int row : {0, size.rows - 1}) {
      if (!size.wrap_v) add(true, row);
    }
    for (const int col : {0, size.cols - 1}) {
      if (!size.wrap_u) add(false, col);
    }
  }
  return sides;
}

// A stretch of a border: the particles `inside` between two consecutive kept particles, `from` and
// `to`. On a ring with one kept particle, both ends are that particle.
struct Stretch {
  int from = 0, to = 0;
  std::vector<int> inside;
  int parts = 1;  // number of parts into which the stretch is divided

  int edges() const { return static_cast<int>(inside.size()) + 1; }
  std::pair<int, int> ends() const { return std::minmax(from, to); }
  int particle(int place) const {
    if (place == 0) return from;
    return place == edges() ? to : inside[place - 1];
  }
};

class Borders {
 public:
  Borders(const Pyramid& pyramid, std::span<const int> levels, std::span<const char> left_alone)
      : pyramid_(pyramid),
        levels_(levels),
        left_alone_(left_alone),
        sides_(open_sides(pyramid.atlas())),
        kept_(pyramid.atlas().particle_count(), 0),
        stretch_of_(kept_.size(), -1) {}

  std::vector<int> sample() {
    keep_ends();
    for (Side& side : sides_) add_stretches(side);
    part_neighbours();
    std::vector<int> sample_of(kept_.size());
    std::iota(sample_of.begin(), sample_of.end(), 0);
    for (const Stretch& stretch : stretches_) give(stretch, sample_of);
    return sample_of;
  }

 private:
  void keep_ends();
  void keep_junctions();
  void add_stretches(Side& side);
  void add_stretch(const Side& side, std::size_t begin, std::size_t end);
  int parts_wanted(const Side& side, int edges) const;
  void part_neighbours();
  static void give(const Stretch& stretch, std::vector<int>& sample_of);

  const Pyramid& pyramid_;
  std::span<const int> levels_;
  std::span<const char> left_alone_;
  std::vector<Side> sides_;
  std::vector<char> kept_;       // 1 for each particle that is kept, else 0
  std::vector<int> stretch_of_;  // stretch inside which each particle lies, or -1
  std::vector<Stretch> stretches_;
  std::map<std::pair<int, int>, int> joined_;  // number of stretches for each pair of ends
  std::set<std::pair<int, int>> direct_;       // pairs of kept particles that a border edge joins
};

void Borders::keep_ends() {
  const Atlas& atlas = pyramid_.atlas();
  for (int patch = 0; patch < pyramid_.patch_count(); ++patch) {
    if (left_alone_[patch] == 0) continue;
    const int first = atlas.first_texel(patch);
    for (int i = 0; i < atlas.patches()[patch].texel_count(); ++i)
      kept_[atlas.particle_of_texel(first + i)] = 1;
  }
  for (const Side& side : sides_) {
    if (!side.is_closed) kept_[side.particles.front()] = kept_[side.particles.back()] = 1;
  }
  keep_junctions();
  // A ring without a kept particle keeps the particle with the lowest index. Patches on both sides
  // of the ring thus keep the same particle.
  for (const Side& side : sides_) {
    const bool is_ring = std::ranges::none_of(side.particles, [&](int p) { return kept_[p] != 0; });
    if (is_ring) kept_[std::ranges::min(side.particles)] = 1;
  }
}

// Keeps particles with more than two neighbours along borders.
void Borders::keep_junctions() {
  std::vector<std::array<int, 2>> neighbours(kept_.size(), {-1, -1});
  const auto join = [&](int from, int to) {
    for (int& neighbour : neighbours[from]) {
      if (neighbour < 0) neighbour = to;
      if (neighbour == to) return;
    }
    kept_[from] = 1;
  };
  for (const Side& side : sides_) {
    const std::size_t count = side.particles.size();
    for (std::size_t i = side.is_closed ? 0 : 1; i < count; ++i) {
      const int before = side.particles[i == 0 ? count - 1 : i - 1];
      join(before, side.particles[i]);
      join(side.particles[i], before);
    }
  }
}

// Cuts a side at its kept particles.
void Borders::add_stretches(Side& side) {
  std::vector<int>& all = side.particles;
  if (side.is_closed) {
    const auto is_kept = [&](int particle) { return kept_[particle] != 0; };
    std::rotate(all.begin(), std::ranges::find_if(all, is_kept), all.end());
    all.push_back(all.front());
  }
  std::size_t begin = 0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    if (kept_[all[i]] == 0) continue;
    add_stretch(side, begin, i);
    begin = i;
  }
}

void Borders::add_stretch(const Side& side, std::size_t begin, std::size_t end) {
  const std::vector<int>& all = side.particles;
  const int parts = parts_wanted(side, static_cast<int>(end - begin));
  if (end - begin == 1) {
    direct_.insert(std::minmax(all[begin], all[end]));
    return;
  }
  int& number = stretch_of_[all[begin + 1]];
  if (number >= 0) {
    Stretch& known = stretches_[number];
    known.parts = std::max(known.parts, parts);
    return;
  }
  const auto first = all.begin() + static_cast<std::ptrdiff_t>(begin);
  const auto last = all.begin() + static_cast<std::ptrdiff_t>(end);
  for (auto it = first + 1; it != last; ++it)
    stretch_of_[*it] = static_cast<int>(stretches_.size());
  stretches_.push_back({*first, *last, {first + 1, last}, parts});
  ++joined_[stretches_.back().ends()];
}

// Returns the number of blocks of the side's patch along a stretch of `edges` edges, rounded up.
// Returns `edges` if the patch keeps all vertices.
int Borders::parts_wanted(const Side& side, int edges) const {
  const Patch& size = pyramid_.atlas().patches()[side.patch];
  const int last = pyramid_.levels(side.patch) - 1;
  const int coarsest = size.wrap_u || size.wrap_v ? 2 : 0;
  const int level = std::max(levels_[side.patch], coarsest);
  if (left_alone_[side.patch] != 0 || level > last) return edges;
  const int blocks =
      side.along_u ? pyramid_.blocks_u(side.patch, level) : pyramid_.blocks_v(side.patch, level);
  const int quads = side.along_u ? size.quad_cols() : size.quad_rows();
  return static_cast<int>((std::int64_t{edges} * blocks + quads - 1) / quads);
}

// Divides each stretch into at least two parts if another stretch or edge has the same ends, and a
// ring into at least three. Otherwise different stretches would become the same edge.
void Borders::part_neighbours() {
  for (Stretch& stretch : stretches_) {
    const bool is_alone = joined_[stretch.ends()] == 1 && !direct_.contains(stretch.ends());
    int fewest = is_alone ? 1 : 2;
    if (stretch.from == stretch.to) fewest = 3;
    stretch.parts = std::clamp(stretch.parts, fewest, stretch.edges());
  }
}

// Assigns each particle between two samples of a stretch to the nearer sample, counted in edges.
void Borders::give(const Stretch& stretch, std::vector<int>& sample_of) {
  const auto sample = [&](int part) {
    return static_cast<int>(std::int64_t{part} * stretch.edges() / stretch.parts);
  };
  for (int part = 0; part < stretch.parts; ++part) {
    const int begin = sample(part), end = sample(part + 1);
    for (int place = begin + 1; place < end; ++place) {
      const int nearest = 2 * (place - begin) <= end - begin ? begin : end;
      sample_of[stretch.particle(place)] = stretch.particle(nearest);
    }
  }
}

}  // namespace

std::vector<char> patches_left_alone(const Atlas& atlas) {
  std::vector<char> found(atlas.patches().size(), 0);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Patch& size = atlas.patches()[i];
    const bool is_narrow = (size.wrap_u && size.quad_cols() < fewest_round_a_wrap) ||
                           (size.wrap_v && size.quad_rows() < fewest_round_a_wrap);
    const bool is_hollow = (!size.wrap_u && size.cols < 3) || (!size.wrap_v && size.rows < 3);
    found[i] = is_narrow || is_hollow ? 1 : 0;
  }
  mark_sewn_to_themselves(atlas, found);
  return found;
}

std::vector<int> sampled_borders(const Pyramid& pyramid, std::span<const int> levels,
                                 std::span<const char> left_alone) {
  return Borders(pyramid, levels, left_alone).sample();
}

}  // namespace weft::bsi
