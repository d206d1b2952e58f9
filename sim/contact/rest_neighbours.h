// Neighbourhoods at rest of the contact search: those within a body and those across seams.
#pragma once

#include <memory>

#include "sim/contact/contact_search.h"

namespace weft::sim {

// Returns neighbourhoods of the vertices of a body with the triangles of both.
std::unique_ptr<const bsi::Neighbourhoods> united(const SceneBody& body,
                                                  const bsi::Neighbourhoods& one,
                                                  const bsi::Neighbourhoods& other);

}  // namespace weft::sim
