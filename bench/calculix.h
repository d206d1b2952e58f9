// Shells of cases, computed by CalculiX (Debian: calculix-ccx).
#pragma once

#include <string>
#include <vector>

#include "sim/base/vectors.h"
#include "sim/case/case.h"

namespace weft::bench {

// A case as input of CalculiX.
struct CalculixDeck {
  std::string text;
  std::vector<int> loaded;  // nodes of the loaded points, in the order of the loads
};

// Writes the first body of a case as n x n elements under the full loads, in a step with large
// displacements or in a linear one.
//
// The elements are C3D20R, one through the thickness: those into which CalculiX itself expands S8R.
// On a whole hemisphere without symmetry planes, both give the same displacements to five digits.
// Written out, they are held in symmetry planes by their displacements alone; rotations of S8R that
// are held make CalculiX tie the nodes of its expansion rigidly, and the shell far too stiff.
//
// Precondition: the shape is an open sector of a cylinder or a sphere, its material a shell, its
// pins hold edges or corners along axes or in planes of symmetry normal to an axis, and its loads
// are forces at corners that grow to their last value.
CalculixDeck calculix_deck(const sim::Case& source, int elements, bool is_linear);

// True if `ccx` can be found.
bool has_calculix();

struct CalculixRun {
  std::vector<sim::Vec3> displacements;  // of the loaded points, m
  double cpu_s = 0;                      // of the whole command, on one thread
};

// Runs `ccx` in a temporary folder. Throws std::runtime_error if it fails.
CalculixRun run_calculix(const CalculixDeck& deck);

}  // namespace weft::bench
