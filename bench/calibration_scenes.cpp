#include "bench/calibration_scenes.h"

#include "sim/case/case_reader.h"

namespace weft::bench {

namespace {

// A square held at two corners.
constexpr const char* corners = R"(
[time]
duration = 0.25
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 1000
stiffness_damping = 1e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [17, 17] }
[[body.pin]]
corners = ["last_first", "last_last"]
)";

// Cloth on a pole in a wind.
constexpr const char* flag = R"(
[time]
duration = 0.12
[world]
wind = [6.0, 0.8, 0.0]
[contact]
enabled = false
[material.cloth]
density = 0.15
membrane_stiffness = 1500
bending_stiffness = 5e-5
stiffness_damping = 1e-3
bending_damping = 1e-3
normal_drag = 1.2
tangential_drag = 0.05
[[body]]
name = "sheet"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [1.5, 1.0], resolution = [17, 25] }
[[body.pin]]
edges = ["first_col"]
)";

// A strip held by its first two columns falls like a springboard.
constexpr const char* strip = R"(
[time]
duration = 0.25
[contact]
enabled = false
[material.cloth]
density = 0.3
membrane_stiffness = 5000
bending_stiffness = 2e-3
stiffness_damping = 1e-4
bending_damping = 1e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.4, 0.1], resolution = [9, 33] }
[[body.pin]]
cols = [0, 1]
)";

// A sheet held at two opposite borders, one of which moves along itself.
constexpr const char* shear = R"(
[time]
duration = 0.13
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 500
stiffness_damping = 2e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [17, 17] }
[[body.pin]]
edges = ["first_row"]
[[body.pin]]
edges = ["last_row"]
motion = { keyframes = [{ time = 0.0 }, { time = 0.2, translation = [0.08, 0.0, 0.0] }] }
)";

// A drum, held all around and struck.
constexpr const char* drum = R"(
[time]
duration = 0.2
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 1000
stiffness_damping = 5e-4
[[body]]
name = "sheet"
velocity = [0, 0, 2]
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [17, 17] }
[[body.pin]]
edges = ["first_row", "last_row", "first_col", "last_col"]
)";

// A sheet comes down on a sphere.
constexpr const char* sphere = R"(
[time]
duration = 0.15
[contact]
range = 4e-3
[material.cloth]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-4
stiffness_damping = 2e-3
bending_damping = 1e-3
[[body]]
name = "sheet"
position = [0.01, 0.02, 0.31]
velocity = [0, 0, -0.5]
shape = { type = "rectangle", size = [0.8, 0.8], resolution = [17, 17] }
[[obstacle]]
name = "ball"
shape = { type = "sphere", radius = 0.3, resolution = [13] }
)";

// A tilted sheet falls on a plate.
constexpr const char* floor_plate = R"(
[time]
duration = 0.12
[contact]
range = 4e-3
[material.cloth]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-4
stiffness_damping = 2e-3
bending_damping = 1e-3
[[body]]
name = "sheet"
position = [0, 0, 0.05]
rotation_deg = [6, 4, 0]
velocity = [0, 0, -0.5]
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [13, 13] }
[[obstacle]]
name = "plate"
shape = { type = "rectangle", size = [0.9, 0.9], resolution = [5, 5] }
)";

// A tube held at its upper end.
constexpr const char* tube = R"(
[time]
duration = 0.2
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 800
bending_stiffness = 1e-4
stiffness_damping = 1e-3
[[body]]
name = "sheet"
rotation_deg = [90, 0, 0]
shape = { type = "cylinder", radius = 0.15, length = 0.6, resolution = [17, 24] }
[[body.pin]]
edges = ["last_row"]
)";

std::string set(const char* key, const char* value) { return std::string(key) + "=" + value; }
std::string resolution(int rows, int cols) {
  return "body.sheet.shape.resolution=[" + std::to_string(rows) + ", " + std::to_string(cols) + "]";
}
std::string size(const char* text) { return set("body.sheet.shape.size", text); }
std::string material(const char* key, const char* value) {
  return set((std::string("material.cloth.") + key).c_str(), value);
}
std::string duration(const char* seconds) { return set("time.duration", seconds); }

}  // namespace

const std::vector<CalibrationScene>& calibration_scenes() {
  static const std::vector<CalibrationScene> scenes = {
      {"corners", "a sheet swings from two corners", {}, corners, false},
      {"undamped",
       "a softer, finer one without damping",
       {resolution(33, 33), material("membrane_stiffness", "300"),
        material("stiffness_damping", "0"), duration("0.2")},
       corners,
       false},
      {"one_corner",
       "soft, much damped, held by one corner",
       {"body.sheet.pin.0.corners=[\"first_first\"]", material("membrane_stiffness", "100"),
        material("stiffness_damping", "1e-2"), duration("0.4")},
       corners,
       false},
      {"stiff",
       "a small stiff sheet",
       {size("[0.2, 0.2]"), material("membrane_stiffness", "1e4"),
        material("stiffness_damping", "2e-4"), duration("0.1")},
       corners,
       false},
      {"heavy",
       "heavy springs in oil",
       {material("membrane", "springs"), material("density", "1.0"), material("mass_damping", "2"),
        duration("0.5")},
       corners,
       false},
      {"flag", "a flag in the wind", {}, flag, false},
      {"strip", "a bending strip", {}, strip, false},
      {"shear", "a sheet is sheared", {}, shear, false},
      {"drum", "a drum is struck", {}, drum, false},
      {"sphere", "a sheet meets a sphere", {}, sphere, false},
      {"floor", "a tilted sheet falls on a plate", {}, floor_plate, false},
      {"soft_on_sphere",
       "soft cloth meets a small sphere, slowly",
       {"body.sheet.velocity=[0, 0, -0.2]", material("membrane_stiffness", "150"),
        material("density", "0.1"), size("[0.6, 0.6]"), "obstacle.ball.shape.radius=0.2",
        "body.sheet.position=[0.0, 0.01, 0.208]", duration("0.12")},
       sphere,
       false},
      {"fast_on_sphere",
       "stiff cloth meets a sphere, fast",
       {"body.sheet.velocity=[0, 0.3, -2]", material("membrane_stiffness", "2000"),
        duration("0.06")},
       sphere,
       false},
      {"rubbing",
       "heavy cloth slides on a sphere",
       {"body.sheet.velocity=[0.5, 0.2, -0.5]", "contact.friction=0.3", size("[0.5, 0.5]"),
        material("density", "0.4"), material("membrane_stiffness", "300"), duration("0.1")},
       sphere,
       false},
      {"slanting",
       "a steep sheet falls on a plate",
       {"body.sheet.rotation_deg=[20, 5, 0]", "body.sheet.position=[0, 0, 0.12]",
        "body.sheet.velocity=[0, 0, -1]", material("membrane_stiffness", "200")},
       floor_plate,
       false},
      {"hammock",
       "a soft, finer sheet hangs from four corners",
       {resolution(25, 25), "body.sheet.pin.0.corners=[\"all\"]",
        material("membrane_stiffness", "150"), material("density", "0.3"), duration("0.2")},
       corners,
       false},
      {"banner",
       "a banner in a cross wind",
       {"body.sheet.pin.0.edges=[\"last_row\"]", "world.wind=[2, 10, 0]", resolution(21, 17),
        material("density", "0.2"), duration("0.15")},
       flag,
       false},
      {"stiff_strip",
       "a longer, stiffer strip",
       {size("[0.6, 0.1]"), material("bending_stiffness", "1e-2"),
        material("membrane_stiffness", "2e4"), duration("0.2")},
       strip,
       false},
      {"twist",
       "a sheet is twisted",
       {"body.sheet.pin.1.motion.keyframes.1.rotation_deg=[60, 0, 0]",
        "body.sheet.pin.1.motion.keyframes.1.translation=[0.0, 0.0, 0.05]",
        material("stiffness_damping", "5e-3")},
       shear,
       false},
      {"tube", "a tube hangs and collapses", {}, tube, false},
      {"spinning",
       "a spinning sheet held by a corner",
       {"body.sheet.pin.0.corners=[\"first_first\"]",
        "body.sheet.angular_velocity_deg=[0, 90, 180]", material("membrane_stiffness", "2000"),
        duration("0.06")},
       corners,
       false},

      {"fine_corners",
       "65 x 65 vertices, from two corners",
       {resolution(65, 65), duration("0.15")},
       corners,
       true},
      {"light_undamped",
       "light, without damping",
       {material("density", "0.08"), material("membrane_stiffness", "200"),
        material("stiffness_damping", "0"), size("[0.6, 0.6]"), duration("0.2")},
       corners,
       true},
      {"edge",
       "33 x 33 vertices, thrown, held by an edge",
       {resolution(33, 33), "body.sheet.pin.0.edges=[\"last_row\"]",
        "body.sheet.velocity=[0.5, 0, 1.5]", material("membrane_stiffness", "500"),
        material("stiffness_damping", "5e-3"), duration("0.1")},
       corners,
       true},
      {"gale",
       "a lighter flag in a stronger wind",
       {"world.wind=[3.0, 9.0, 1.0]", resolution(17, 17), size("[1.0, 1.0]"),
        material("density", "0.1"), material("membrane_stiffness", "800"), duration("0.1")},
       flag,
       true},
      {"soft_strip",
       "a soft, short strip",
       {size("[0.3, 0.06]"), resolution(7, 31), material("bending_stiffness", "5e-4"),
        material("bending_damping", "3e-3"), material("membrane_stiffness", "2000"),
        duration("0.3")},
       strip,
       true},
      {"fast_shear",
       "a stiffer sheet is sheared faster",
       {material("membrane_stiffness", "3000"), duration("0.08"), resolution(25, 25),
        "body.sheet.pin.1.motion.keyframes.1.translation=[0.15, 0.0, 0.05]"},
       shear,
       true},
      {"soft_drum",
       "a soft heavy drum",
       {material("membrane_stiffness", "200"), material("density", "0.5"),
        "body.sheet.velocity=[0, 0, 3]", duration("0.25")},
       drum,
       true},
      {"fall_on_sphere",
       "33 x 33 vertices fall on a sphere",
       {resolution(33, 33), "body.sheet.position=[0.02, -0.01, 0.312]", size("[0.9, 0.9]"),
        "body.sheet.velocity=[0.2, 0, -1.0]", material("membrane_stiffness", "1000"),
        material("density", "0.3"), duration("0.1")},
       sphere,
       true},
      {"spring_net",
       "springs, damped by the air",
       {material("membrane", "springs"), material("membrane_stiffness", "400"),
        material("density", "0.3"), material("normal_drag", "1.0"), duration("0.35")},
       corners,
       true},
      {"wide_tube",
       "a wide heavy tube",
       {"body.sheet.shape.radius=0.25", "body.sheet.shape.length=0.5", material("density", "0.5"),
        material("membrane_stiffness", "1500"), material("stiffness_damping", "3e-4")},
       tube,
       true},
  };
  return scenes;
}

sim::Case case_of(const CalibrationScene& scene, const std::vector<std::string>& more) {
  std::vector<std::string> overrides = scene.overrides;
  overrides.insert(overrides.end(), more.begin(), more.end());
  return sim::parse_case(scene.base, std::string(scene.name) + ".toml", overrides);
}

}  // namespace weft::bench
