// Other libraries' methods of moving cloth, each in a separate program beside weft-bench.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/peers/cloth_peer.h"
#include "sim/scene/scene.h"

namespace weft::bench {

// Settings of a method that are worth trying at any step. The names are those of ClothSettings.
struct ClothVariant {
  const char* label;
  int iterations = 1;
  double tolerance = 0;
  bool line_search = false;
};

struct ClothMethod {
  const char* name;
  const char* library;  // of the program weft-bench-LIBRARY
  const char* method;   // in its words
  std::vector<ClothVariant> variants;
};

// Returns all known methods, whether they were built or not.
std::span<const ClothMethod> cloth_methods();

// Returns the path of the program, beside this one or in the build folder; empty if it was not
// built.
std::optional<std::string> cloth_program(const ClothMethod& method);

// Returns a feature of the scene that the libraries cannot express; empty if they can express all
// of it.
std::optional<std::string> beyond_peers(const sim::Scene& scene);

// Returns the springs and point masses of the scene. Precondition: !beyond_peers(scene).
ClothProblem cloth_problem(const sim::Scene& scene);

// Runs the program. Reports errors as the outcome's failure.
ClothOutcome run_cloth(const std::string& program, const ClothProblem& problem,
                       const ClothSettings& settings);

}  // namespace weft::bench
