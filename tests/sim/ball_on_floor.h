// A scene of one ball above a floor, of which tests override places and laws.
#pragma once

#include <string>

namespace weft::sim {

inline const std::string ball_on_floor = R"(
[time]
method = "impulses"
duration = 20
[[particles]]
name = "ball"
radius = 0.02
restitution = 0.5
friction = 0
positions = { type = "grid", count = [1, 1, 1], centre = [0.003, 0.001, 0.5] }
[[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [4, 4], resolution = [5, 5] }
)";

}  // namespace weft::sim
