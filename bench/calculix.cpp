#include "bench/calculix.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <span>
#include <sstream>
#include <stdexcept>

#include "bench/temporary_folder.h"
#include "bench/timed_command.h"
#include "sim/scene/pins.h"
#include "sim/scene/shape_builder.h"

namespace weft::bench {

namespace {

using sim::Case;
using sim::Vec3;

// The first increment of the load, as a share of it. CalculiX chooses the others by itself. Among
// first increments from 0.02 to 1, this one takes the least time for the hemisphere.
constexpr double first_increment = 0.1;

// The layers of nodes: on the inner face, the middle surface and the outer face.
constexpr int inner = 0, middle = 1, outer = 2, layers = 3;

// Nodes on a grid of 2 n + 1 rows and columns, with midside nodes at the odd ones.
class Nodes {
 public:
  Nodes(const Case& source, double thickness, int elements) : side_(2 * elements + 1) {
    for (int layer = 0; layer < layers; ++layer) {
      sim::ShapeCase shape = source.body.at(0).shape;
      shape.resolution = {side_, side_};
      *shape.radius += 0.5 * thickness * (layer - middle);
      surface_[layer] = sim::build_shape(shape, source);
    }
    int next = 0;
    number_.assign(static_cast<std::size_t>(layers * side_ * side_), 0);
    for (int row = 0; row < side_; ++row) {
      for (int col = 0; col < side_; ++col) {
        for (int layer = 0; layer < layers; ++layer) {
          if (exists(row, col, layer)) number_[index(row, col, layer)] = ++next;
        }
      }
    }
  }

  int side() const { return side_; }
  // The middle surface.
  const bsi::Surface& surface() const { return surface_[middle]; }
  // The number of a node, or 0 if the elements have none there.
  int number(int row, int col, int layer) const { return number_[index(row, col, layer)]; }
  // Numbers of the nodes at a particle of the middle surface: the middle one, or all layers.
  std::vector<int> numbers(int particle, bool all_layers) const {
    std::vector<int> found;
    for (int layer = 0; layer < layers; ++layer) {
      const int node = number(particle / side_, particle % side_, layer);
      if (node != 0 && (all_layers || layer == middle)) found.push_back(node);
    }
    return found;
  }
  void write(std::ostream& out) const {
    out << "*NODE, NSET=all\n";
    for (int row = 0; row < side_; ++row) {
      for (int col = 0; col < side_; ++col) {
        for (int layer = 0; layer < layers; ++layer) {
          if (!exists(row, col, layer)) continue;
          const bsi::Surface& of = surface_[layer];
          const Vec3& x = of.positions[static_cast<std::size_t>(of.atlas.particle(0, row, col))];
          char line[96];
          std::snprintf(line, sizeof line, "%d, %.12g, %.12g, %.12g\n", number(row, col, layer),
                        x.x(), x.y(), x.z());
          out << line;
        }
      }
    }
  }

 private:
  // Elements have no node in their middle, and edges through the thickness one at corners only.
  static bool exists(int row, int col, int layer) {
    const bool odd_row = row % 2 == 1, odd_col = col % 2 == 1;
    return layer == middle ? !odd_row && !odd_col : !odd_row || !odd_col;
  }
  std::size_t index(int row, int col, int layer) const {
    return static_cast<std::size_t>((row * side_ + col) * layers + layer);
  }

  int side_;
  bsi::Surface surface_[layers];
  std::vector<int> number_;
};

// Corners, then midside nodes, of the inner and the outer face; then nodes between both.
void write_elements(const Nodes& nodes, std::ostream& out) {
  static constexpr int corner[4][2] = {{0, 0}, {0, 2}, {2, 2}, {2, 0}};
  static constexpr int midside[4][2] = {{0, 1}, {1, 2}, {2, 1}, {1, 0}};
  struct Part {
    const int (*places)[2];
    int layer;
  };
  constexpr Part parts[] = {
      {corner, inner}, {corner, outer}, {midside, inner}, {midside, outer}, {corner, middle}};
  out << "*ELEMENT, TYPE=C3D20R, ELSET=shell\n";
  int element = 0;
  for (int row = 0; row + 2 < nodes.side(); row += 2) {
    for (int col = 0; col + 2 < nodes.side(); col += 2) {
      out << ++element;
      int written = 0;
      for (const Part& part : parts) {
        for (int i = 0; i < 4; ++i) {
          // A line has at most 16 entries.
          out << (written++ == 10 ? ",\n" : ", ")
              << nodes.number(row + part.places[i][0], col + part.places[i][1], part.layer);
        }
      }
      out << '\n';
    }
  }
}

// Directions (1, 2, 3) in which a pin holds.
std::vector<int> directions_of(const sim::PinCase& pin) {
  std::vector<int> directions;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name(1, "xyz"[axis]);
    const bool is_held = pin.symmetry ? std::abs((*pin.symmetry)[axis]) == 1
                                      : pin.axes.empty() || std::ranges::count(pin.axes, name) > 0;
    if (is_held) directions.push_back(axis + 1);
  }
  return directions;
}

void write_supports(const Case& source, const Nodes& nodes, std::ostream& out) {
  out << "*BOUNDARY\n";
  const bsi::Surface& surface = nodes.surface();
  for (const sim::PinCase& pin : source.body.at(0).pin) {
    const bool is_edge = !pin.vertices.edges.empty();
    for (const int particle : sim::select_vertices(pin.vertices, pin.location, "pin", surface.atlas,
                                                   surface.positions)) {
      for (const int node : nodes.numbers(particle, is_edge)) {
        for (const int direction : directions_of(pin))
          out << node << ", " << direction << ", " << direction << '\n';
      }
    }
  }
}

std::vector<int> loaded_nodes(const Case& source, const Nodes& nodes) {
  std::vector<int> loaded;
  const bsi::Surface& surface = nodes.surface();
  for (const sim::LoadCase& load : source.load) {
    for (const int particle : sim::select_vertices(load.vertices, load.location, "load",
                                                   surface.atlas, surface.positions))
      loaded.push_back(nodes.numbers(particle, false).at(0));
  }
  return loaded;
}

const sim::MaterialCase& material_of(const Case& source) {
  const auto found =
      std::ranges::find(source.material, source.body.at(0).material, &sim::MaterialCase::name);
  if (found == source.material.end() || !found->is_shell())
    throw std::runtime_error("CalculiX computes shells only");
  return *found;
}

}  // namespace

CalculixDeck calculix_deck(const Case& source, int elements, bool is_linear) {
  const sim::MaterialCase& material = material_of(source);
  const Nodes nodes(source, material.shell_thickness, elements);
  CalculixDeck deck{{}, loaded_nodes(source, nodes)};
  std::ostringstream out;
  nodes.write(out);
  write_elements(nodes, out);
  out << "*MATERIAL, NAME=wall\n*ELASTIC\n"
      << material.youngs_modulus << ", " << material.poisson_ratio
      << "\n*SOLID SECTION, ELSET=shell, MATERIAL=wall\n*NSET, NSET=loaded\n";
  for (const int node : deck.loaded) out << node << ",\n";
  write_supports(source, nodes, out);
  out << "*STEP, INC=1000" << (is_linear ? "" : ", NLGEOM") << "\n*STATIC\n";
  if (!is_linear) out << first_increment << ", 1.\n";
  out << "*CLOAD\n";
  for (std::size_t i = 0; i < deck.loaded.size(); ++i) {
    const Vec3 force = source.load.at(i).force.curve()->values.back();
    for (int axis = 0; axis < 3; ++axis) {
      if (force[axis] != 0)
        out << deck.loaded[i] << ", " << axis + 1 << ", " << force[axis] << '\n';
    }
  }
  out << "*NODE PRINT, NSET=loaded, FREQUENCY=1000\nU\n*END STEP\n";
  deck.text = out.str();
  return deck;
}

bool has_calculix() { return is_installed("ccx"); }

CalculixRun run_calculix(const CalculixDeck& deck) {
  const TemporaryFolder folder;
  std::ofstream(folder.path("shell.inp")) << deck.text;
  const TimedCommand command = run_command({"ccx", "shell"}, folder.path());
  // Lines of a node and its three displacements; those of the last increment count.
  std::map<int, Vec3> displacement;
  std::ifstream file(folder.path("shell.dat"));
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    int node = 0;
    Vec3 u;
    if (words >> node >> u[0] >> u[1] >> u[2]) displacement[node] = u;
  }
  CalculixRun run{{}, command.cpu_s};
  for (const int node : deck.loaded) {
    const auto found = displacement.find(node);
    if (!command.is_well || found == displacement.end())
      throw std::runtime_error("ccx has failed:\n" + command.output);
    run.displacements.push_back(found->second);
  }
  return run;
}

}  // namespace weft::bench
