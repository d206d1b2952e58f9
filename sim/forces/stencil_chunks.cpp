#include "sim/forces/stencil_chunks.h"

namespace weft::sim {

namespace {

// Returns the number of stencils in a chunk, a multiple of every possible lane_count. Chunks of a
// small image are short, so that several threads have some of each colour. But shorter ones would
// share particles with more of their neighbours, which takes more colours.
int chunk_length(int stencils) {
  constexpr int shortest = 128, longest = 512, chunks_of_small_images = 16, multiple = 16;
  const int equal = stencils / chunks_of_small_images / multiple * multiple;
  return std::clamp(equal, shortest, longest);
}

// Gives each chunk a colour that differs from the colours of all earlier chunks with which it
// shares a particle. It chooses the lowest such colour.
class ChunkColouring {
 public:
  ChunkColouring(std::span<const int> particles, int particles_per_chunk, int particle_count)
      : particles_(particles),
        particles_per_chunk_(particles_per_chunk),
        chunk_count_((static_cast<int>(particles.size()) + particles_per_chunk - 1) /
                     particles_per_chunk),
        chunk_by_colour_(particle_count) {
    for (int chunk = 0; chunk < chunk_count_; ++chunk) colour(chunk);
  }

  std::vector<std::vector<int>> take_colours() { return std::move(colours_); }
  // Returns all chunks in an order for one thread. Each chunk comes after the chunks of lower
  // colours with which it shares a particle.
  std::vector<int> order() const {
    std::vector<int> order;
    std::vector<char> is_ordered(chunk_count_, 0);
    const auto put = [&](const auto& self, int chunk) -> void {
      if (is_ordered[chunk] != 0) return;
      is_ordered[chunk] = 1;
      for (const int particle : particles_of(chunk)) {
        for (std::size_t k = 0; k < colour_of_[chunk]; ++k) {
          if (chunk_by_colour_[particle][k] >= 0) self(self, chunk_by_colour_[particle][k]);
        }
      }
      order.push_back(chunk);
    };
    for (int chunk = 0; chunk < chunk_count_; ++chunk) put(put, chunk);
    return order;
  }

 private:
  std::span<const int> particles_of(int chunk) const {
    const std::size_t first = static_cast<std::size_t>(chunk) * particles_per_chunk_;
    return particles_.subspan(
        first, std::min<std::size_t>(particles_per_chunk_, particles_.size() - first));
  }

  void colour(int chunk) {
    std::vector<char> is_used(colours_.size() + 1, 0);
    for (const int particle : particles_of(chunk)) {
      const std::vector<int>& chunks = chunk_by_colour_[particle];
      for (std::size_t k = 0; k < chunks.size(); ++k) is_used[k] |= chunks[k] >= 0;
    }
    const std::size_t colour = std::find(is_used.begin(), is_used.end(), 0) - is_used.begin();
    if (colour == colours_.size()) colours_.emplace_back();
    colours_[colour].push_back(chunk);
    colour_of_.push_back(colour);
    for (const int particle : particles_of(chunk)) {
      std::vector<int>& chunks = chunk_by_colour_[particle];
      if (chunks.size() <= colour) chunks.resize(colour + 1, -1);
      chunks[colour] = chunk;
    }
  }

  std::span<const int> particles_;
  int particles_per_chunk_, chunk_count_;
  std::vector<std::vector<int>> chunk_by_colour_;  // chunk, by particle and colour; -1: no chunk
  std::vector<std::vector<int>> colours_;          // chunks by colour
  std::vector<std::size_t> colour_of_;             // colour, by chunk
};

}  // namespace

StencilChunks::StencilChunks(std::span<const int> particles, int nodes, int particle_count)
    : stencil_count_(static_cast<int>(particles.size()) / nodes),
      stencils_per_chunk_(chunk_length(stencil_count_)) {
  ChunkColouring colouring(particles, nodes * stencils_per_chunk_, particle_count);
  order_ = colouring.order();
  colours_ = colouring.take_colours();
}

}  // namespace weft::sim
