#include "bench/stability_grid.h"

#include <algorithm>
#include <cmath>

#include "sim/case/case_text.h"

namespace weft::bench {

namespace {

using sim::number_text;

// Keys and their values; a later value replaces an earlier one.
class Keys {
 public:
  void set(const std::string& key, const std::string& value) {
    std::erase_if(texts_, [&](const std::string& text) { return text.starts_with(key + "="); });
    texts_.push_back(key + "=" + value);
  }
  void set(const std::string& key, double value) { set(key, number_text(value)); }
  const std::vector<std::string>& texts() const { return texts_; }

 private:
  std::vector<std::string> texts_;
};

struct Scene {
  const char* name;                    // of its file
  const char* body;                    // body whose shape and velocity are varied
  std::vector<const char*> materials;  // materials whose stiffness and damping are varied
  double duration;                     // s
  double path = 0;                     // m: longest path of a thrown body
  const char* velocity = nullptr;      // how a speed becomes a velocity
  bool has_moving_parts = false;
};

const Scene hang{"hang", "sheet", {"cloth"}, 0.1};
const Scene needles{"needles", "ring", {"cloth"}, 0.1};
const Scene buckle{"buckle", "strip", {"cloth"}, 0.1};
const Scene invert{"invert", "sheet", {"cloth"}, 0.1, 0.5, "[0, -*, 0]"};
const Scene crumple{"crumple", "sheet", {"cloth"}, 0.1, 0.3, "[0, -*, 0]"};
const Scene impact{"impact", "sheet", {"cloth"}, 0.1, 0.3, "[0, 0, -*]"};
const Scene load{"load", "load", {"heavy", "light"}, 0.1};
const Scene fly{"free", "sheet", {"cloth"}, 0.1};
const Scene ball{"ball", "sheet", {"cloth"}, 1.0, 0, nullptr, true};
const Scene paddle{"paddle", "sheet", {"cloth"}, 1.0, 0, nullptr, true};
const Scene pole{"pole", "sheet", {"cloth"}, 1.0, 0, nullptr, true};

struct Method {
  const char* name;
  const char* key;  // time.method
  bool by_step;
  bool linear;
  double setting;  // default, unless the slice varies it
  bool is_quick;   // part of the quick grid
};

// The integrators by name, and two more uses of `euler`.
constexpr Method methods[] = {
    {"cvode", "cvode", false, false, 1e-5, true},
    {"arkode", "arkode", false, false, 1e-5, true},
    {"euler", "euler", false, false, 1e-5, true},
    {"backward-euler", "euler", true, false, 1e-4, true},
    {"linear-euler", "euler", true, true, 1e-4, false},
    {"implicit-midpoint", "implicit_midpoint", true, false, 1e-4, false},
    {"verlet", "verlet", true, false, 1e-5, false},
    {"static", "static", false, false, 1e-5, false},
};

// The settings of a cell, to which the axes apply their values one after the other.
struct Setup {
  const Scene& scene;
  double duration;  // s
  double setting;   // see apply_setting()
  double size = 1;
  Keys keys;

  void set_materials(const char* key, double value) {
    for (const char* material : scene.materials)
      keys.set(std::string("material.") + material + "." + key, value);
  }
  void set_body(const char* key, const std::string& value) {
    keys.set(std::string("body.") + scene.body + "." + key, value);
  }
};

struct Axis {
  const char* title;
  std::vector<double> values;
  void (*apply)(Setup& setup, double value);
};

std::string in_brackets(double a, double b) {
  return "[" + number_text(a) + ", " + number_text(b) + "]";
}

Axis stiffness(std::vector<double> values) {
  return {"stiffness, N/m", std::move(values),
          [](Setup& setup, double value) { setup.set_materials("membrane_stiffness", value); }};
}

Axis setting(std::vector<double> values) {
  return {"tolerance, m, or a tenth of the step, s", std::move(values),
          [](Setup& setup, double value) { setup.setting = value; }};
}

Axis mass_ratio(std::vector<double> values) {
  return {"mass ratio", std::move(values), [](Setup& setup, double value) {
            setup.keys.set("material.heavy.density", 0.02 * value);
          }};
}

Axis stiffness_damping(std::vector<double> values) {
  return {"damping time, s", std::move(values), [](Setup& setup, double value) {
            setup.set_materials("stiffness_damping", value);
            setup.set_materials("bending_damping", value);
          }};
}

Axis mass_damping(std::vector<double> values) {
  return {"mass damping, 1/s", std::move(values),
          [](Setup& setup, double value) { setup.set_materials("mass_damping", value); }};
}

// Varies the vertices along the longer side; quads stay square. Finer meshes are simulated for a
// shorter time, so that a wave passes as many vertices.
Axis resolution(std::vector<double> values) {
  return {"vertices a side", std::move(values), [](Setup& setup, double n) {
            const bool strip = setup.scene.body == std::string("strip");
            const double columns = strip ? std::floor((n - 1) / 4) + 1 : n;
            setup.set_body("shape.resolution", in_brackets(n, columns));
            setup.duration *= std::min(1.0, 9 / n);
            setup.size = std::max(1.0, n / 9);
          }};
}

Axis aspect_ratio(std::vector<double> values) {
  return {"aspect ratio", std::move(values), [](Setup& setup, double value) {
            setup.set_body("shape.size", in_brackets(1, 1 / value));
          }};
}

// Varies the hole of the ring as a part of its radius, and so the shape of the innermost triangles.
Axis needle(std::vector<double> values) {
  return {"short / long edges", std::move(values), [](Setup& setup, double value) {
            setup.set_body("shape.minor_radius", number_text(0.3 * (1 - value)));
          }};
}

Axis speed(std::vector<double> values) {
  return {"speed, m/s", std::move(values), [](Setup& setup, double value) {
            std::string velocity = setup.scene.velocity;
            velocity.replace(velocity.find('*'), 1, number_text(value));
            setup.set_body("velocity", velocity);
            setup.duration = std::min(setup.duration, setup.scene.path / value);
          }};
}

Axis spin(std::vector<double> values) {
  return {"spin, degrees/s", std::move(values), [](Setup& setup, double value) {
            setup.set_body("angular_velocity_deg", "[" + number_text(value) + ", " +
                                                       number_text(0.5 * value) + ", " +
                                                       number_text(2 * value) + "]");
          }};
}

// Varies the ball's speed. The ball passes the sheet and stops 0.8 m from its start.
Axis ball_speed(std::vector<double> values) {
  return {"speed of the ball, m/s", std::move(values), [](Setup& setup, double value) {
            setup.keys.set("obstacle.ball.motion.velocity", "[0, 0, " + number_text(value) + "]");
            setup.keys.set("obstacle.ball.motion.stop_time", 0.8 / value);
          }};
}

Axis paddle_rate(std::vector<double> values) {
  return {"rate of the paddle, degrees/s", std::move(values), [](Setup& setup, double value) {
            setup.keys.set("obstacle.paddle.motion.angular_velocity_deg",
                           "[" + number_text(value) + ", 0, 0]");
          }};
}

Axis pole_rate(std::vector<double> values) {
  return {"rate of the pins, degrees/s", std::move(values), [](Setup& setup, double value) {
            setup.keys.set("body.sheet.pin.0.motion.angular_velocity_deg",
                           "[0, " + number_text(value) + ", 0]");
          }};
}

Axis compression(std::vector<double> values) {
  return {"load / weight", std::move(values), [](Setup& setup, double value) {
            setup.keys.set("world.gravity", "[0, " + number_text(-9.81 * value) + ", 0]");
          }};
}

// Applies a tolerance, or a step of ten times the value. Runs of short steps are cut to 500 steps
// if nothing prescribed moves: a tenth of a second is then enough to judge them.
void apply_setting(const Method& method, Setup& setup) {
  Keys& keys = setup.keys;
  keys.set("time.method", method.key);
  if (method.by_step) {
    const double step = 10 * setup.setting;
    setup.duration = std::max(setup.duration, step);  // a step is not longer than its run
    keys.set("time.step", step);
    if (!setup.scene.has_moving_parts) setup.duration = std::min(setup.duration, 500 * step);
    if (step < 1e-5) keys.set("time.minimum_step", 1e-3 * step);
    keys.set("time.position_tolerance", std::clamp(1e-3 * step, 1e-9, 1e-5));
    keys.set("time.relative_tolerance", 1e-3);
    if (method.linear) keys.set("time.newton", "1");
  } else {
    keys.set("time.position_tolerance", setup.setting);
    keys.set("time.relative_tolerance", std::min(0.1, 10 * setup.setting));
  }
  keys.set("time.duration", setup.duration);
}

struct Plan {
  const char* name;
  const Scene& scene;
  Axis x;
  std::vector<Axis> y;  // none: a sweep over the methods
  bool with_static = false;
  double quick_end = 0;  // of a sweep: how far the quick grid goes
};

std::vector<double> decades(int first, int last, int stride = 1) {
  std::vector<double> values;
  for (int i = first; first < last ? i <= last : i >= last; i += first < last ? stride : -stride)
    values.push_back(std::stod("1e" + std::to_string(i)));
  return values;
}

std::vector<Plan> plans() {
  const std::vector<double> damped{0, 1e-6, 1e-4, 1e-2, 1, 100};
  const std::vector<double> speeds{0.1, 1, 3, 10, 30, 100};
  const std::vector<double> loads{1, 10, 100, 1e3, 1e4};
  const std::vector<double> stiff{1, 1e3, 1e6, 1e9};
  const std::vector<double> ball_speeds{0.1, 0.3, 1, 3, 10, 30};
  const std::vector<double> rates{30, 90, 360, 1080, 3600};
  return {
      {"stiffness", hang, stiffness(decades(0, 9)), {}, true, 1e6},
      {"setting", hang, setting(decades(-2, -8)), {}, true, 1e-6},
      {"mass-ratio", load, mass_ratio(decades(0, 6)), {}, false, 1e6},
      {"damping", hang, stiffness_damping(damped), {}, false, 1e-2},
      {"mass-damping", hang, mass_damping({0, 0.1, 1, 10, 100, 1e4, 1e6}), {}, false, 1e6},
      {"resolution", hang, resolution({5, 9, 17, 33, 65, 129, 257}), {}, true, 33},
      {"aspect-ratio", hang, aspect_ratio({1, 2, 5, 10, 20, 50, 100}), {}, true, 20},
      {"needles", needles, needle(decades(-1, -9)), {}, true, 1e-5},
      {"speed", impact, speed(speeds), {}, false, 3},
      {"compression", buckle, compression({1, 3, 10, 30, 100, 300, 1e3, 1e4}), {}, true, 100},
      {"inversion", invert, speed(speeds), {}, false, 100},
      {"crumpling", crumple, speed(speeds), {}, false, 30},
      {"spin", fly, spin({10, 100, 1e3, 1e4, 1e5, 1e6}), {}, false, 1e4},
      {"stiffness-setting", hang, setting(decades(-2, -8)), {stiffness(stiff)}, true},
      {"mass-ratio-stiffness", load, mass_ratio(decades(0, 6, 2)), {stiffness(stiff)}},
      {"damping-setting", hang, setting(decades(-2, -6)), {stiffness_damping(damped)}},
      {"resolution-setting", hang, setting({1e-2, 1e-4, 1e-6}), {resolution({5, 17, 65})}},
      {"speed-stiffness", impact, speed(speeds), {stiffness(stiff)}},
      {"aspect-ratio-stiffness", hang, aspect_ratio({1, 10, 30, 100}), {stiffness(stiff)}, true},
      {"needles-stiffness", needles, needle(decades(-1, -7, 2)), {stiffness(stiff)}, true},
      {"compression-resolution", buckle, compression(loads), {resolution({5, 17, 65})}, true},
      {"inversion-stiffness", invert, speed(speeds), {stiffness(stiff)}},
      {"crumpling-stiffness", crumple, speed(speeds), {stiffness(stiff)}},
      {"ball", ball, ball_speed(ball_speeds), {}, false, 1},
      {"paddle", paddle, paddle_rate(rates), {}, false, 360},
      {"pole", pole, pole_rate(rates), {}, false, 360},
      {"ball-stiffness", ball, ball_speed(ball_speeds), {stiffness(stiff)}},
      {"pole-stiffness", pole, pole_rate(rates), {stiffness(stiff)}},
  };
}

std::vector<std::string> labels_of(const Axis& axis) {
  std::vector<std::string> labels;
  for (const double value : axis.values) labels.push_back(number_text(value));
  return labels;
}

Slice slice_of(const Plan& plan, bool quick) {
  Slice slice{plan.name, plan.x.title, "", labels_of(plan.x), {}, {}, {}};
  const Axis* y_axis = plan.y.empty() ? nullptr : plan.y.data();
  if (y_axis != nullptr) {
    slice.y_title = y_axis->title;
    slice.y_labels = labels_of(*y_axis);
  }
  const std::size_t rows = y_axis == nullptr ? 1 : y_axis->values.size();
  for (const Method& method : methods) {
    const bool is_static = method.key == std::string("static");
    if ((is_static && !plan.with_static) || (quick && !method.is_quick)) continue;
    const int index = static_cast<int>(slice.methods.size());
    slice.methods.emplace_back(method.name);
    for (std::size_t y = 0; y < rows; ++y) {
      for (std::size_t x = 0; x < plan.x.values.size(); ++x) {
        Setup setup{plan.scene, plan.scene.duration, method.setting, 1, {}};
        plan.x.apply(setup, plan.x.values[x]);
        if (y_axis != nullptr) y_axis->apply(setup, y_axis->values[y]);
        apply_setting(method, setup);
        // A shorter duration does not make equilibria cheaper.
        if (is_static) setup.size *= setup.size;
        // Limits are stated for a tenth of a second.
        if (plan.scene.has_moving_parts) setup.size *= setup.duration / 0.1;
        Cell& cell = slice.cells.emplace_back();
        cell.slice = plan.name;
        cell.method = method.name;
        cell.path = std::string("bench/stability/") + plan.scene.name + ".toml";
        cell.x = static_cast<int>(x);
        cell.y = y_axis == nullptr ? index : static_cast<int>(y);
        cell.overrides = setup.keys.texts();
        cell.size = setup.size;
        cell.duration = setup.duration;
        cell.tolerance = method.by_step || is_static ? 0 : setup.setting;
        cell.has_moving_parts = plan.scene.has_moving_parts;
        cell.is_static = is_static;
      }
    }
  }
  if (y_axis == nullptr) slice.y_labels = slice.methods;
  return slice;
}

}  // namespace

std::string Cell::command() const {
  std::string text = "weft run " + path;
  for (const std::string& each : overrides) {
    const bool needs_quotes = each.find_first_of(" []") != std::string::npos;
    text += needs_quotes ? " --set '" + each + "'" : " --set " + each;
  }
  return text;
}

std::vector<std::string> Cell::physics() const {
  std::vector<std::string> keys{path};
  for (const std::string& each : overrides)
    if (!each.starts_with("time.")) keys.push_back(each);
  std::sort(keys.begin() + 1, keys.end());
  return keys;
}

std::vector<std::string> slice_names() {
  std::vector<std::string> names;
  for (const Plan& plan : plans()) names.emplace_back(plan.name);
  return names;
}

std::vector<Slice> make_slices(const std::vector<std::string>& names, bool quick) {
  std::vector<Slice> slices;
  for (Plan& plan : plans()) {
    if (!names.empty() && std::find(names.begin(), names.end(), plan.name) == names.end()) continue;
    if (quick) {
      if (!plan.y.empty()) continue;
      plan.x.values = {plan.x.values.front(), plan.quick_end};
    }
    slices.push_back(slice_of(plan, quick));
  }
  return slices;
}

std::vector<Slice> every_nth(std::vector<Slice> slices, int n) {
  int index = 0;
  for (Slice& slice : slices)
    std::erase_if(slice.cells, [&](const Cell&) { return index++ % n != 0; });
  std::erase_if(slices, [](const Slice& slice) { return slice.cells.empty(); });
  return slices;
}

}  // namespace weft::bench
