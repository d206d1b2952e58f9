#include <iostream>

#include "bsi/pyramid.h"
#include "bsi/shapes.h"

int main() {
  const weft::bsi::Surface torus = weft::bsi::make_torus(0.3, 0.1, 32, 64);
  weft::bsi::Pyramid pyramid(torus.atlas, {.spheres = true});
  if (pyramid.rebuild(torus.positions)) return 1;
  std::cout << pyramid.sphere(0, 0, 0, 0).radius << '\n';
}
