#include "sim/view/trajectory_info.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <sstream>

#include "sim/case/case_text.h"
#include "sim/trajectory/file_lock.h"
#include "sim/trajectory/json_text.h"
#include "sim/trajectory/trajectory.h"
#include "sim/view/crossings.h"
#include "sim/view/field_values.h"
#include "sim/view/recorded_surface.h"

namespace weft::sim {
namespace {

bool all_finite(std::span<const Vec3> positions) {
  return std::ranges::all_of(positions, [](const Vec3& p) { return p.allFinite(); });
}

std::optional<SurfaceDeviation> find_deviation(const TrajectoryReader& reader, int index) {
  const TrajectoryBody& body = reader.bodies()[index];
  const RecordedSurface surface(body);
  if (!surface.is_curved()) return std::nullopt;
  SurfaceDeviation deviation;
  for (int frame = 0; frame < (body.moves ? reader.frames() : 1); ++frame) {
    const std::vector<Vec3> image = reader.positions(index, frame);
    const double now = all_finite(image) ? surface.deviation(image) : 0;
    if (now <= deviation.largest) continue;
    deviation.largest = now;
    deviation.time = body.moves ? reader.time(frame) : 0;
  }
  return deviation;
}

BodySummary summarise_body(const TrajectoryReader& reader, int index) {
  const TrajectoryBody& body = reader.bodies()[index];
  BodySummary summary;
  summary.name = body.name;
  summary.patches = static_cast<int>(body.atlas.patches().size());
  summary.rows = body.atlas.patches().front().rows;
  summary.cols = body.atlas.patches().front().cols;
  summary.particles = body.atlas.particle_count();
  summary.triangles = 2 * body.atlas.quad_count();
  summary.moves = body.moves;
  summary.is_obstacle = body.is_obstacle;
  summary.thickness = body.thickness;
  if (body.is_of_spheres()) {
    const auto [least, largest] = std::ranges::minmax(body.radii);
    summary.least_radius = least;
    summary.largest_radius = largest;
  }
  summary.part_rows = body.part_rows;
  summary.part_cols = body.part_cols;
  if (body.moves && reader.frames() == 0) return summary;
  const std::vector<Vec3> positions = reader.positions(index, std::max(0, reader.frames() - 1));
  summary.is_finite = all_finite(positions);
  summary.deviation = find_deviation(reader, index);
  summary.has_bounds = summary.is_finite;
  if (!summary.is_finite) return summary;
  summary.lower = summary.upper = positions.front();
  for (const Vec3& position : positions) {
    summary.lower = summary.lower.cwiseMin(position);
    summary.upper = summary.upper.cwiseMax(position);
  }
  return summary;
}

SeriesSummary summarise_series(const TrajectoryReader& reader,
                               const TrajectoryWriter::Series& series) {
  SeriesSummary summary;
  summary.name = series.name;
  summary.units = series.units;
  std::vector<double> values = reader.series_values(series.name);
  if (values.empty()) return summary;
  summary.last = values.back();
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return summary;
  const auto [minimum, maximum] = std::ranges::minmax(values);
  summary.has_extremes = true;
  summary.minimum = minimum;
  summary.maximum = maximum;
  return summary;
}

void summarise_end(const TrajectoryReader& reader, bool is_written, TrajectorySummary& summary) {
  if (const std::optional<RunEnd> end = reader.end()) {
    summary.status = end->status;
    summary.reason = end->reason;
    summary.bill = end->bill;
  } else if (is_written) {
    summary.status = "running";
  } else {
    summary.status = reader.says_its_end() ? "killed" : "unknown";
  }
}

std::string describe_end(const TrajectorySummary& summary) {
  if (summary.status == "running") return "running: a process is writing the file";
  if (summary.status == "killed") return "killed: the process that wrote the file did not end it";
  if (summary.status == "unknown") return "unknown: the file is of an earlier version of Weft";
  return printable(summary.status + (summary.reason.empty() ? "" : ": " + summary.reason));
}

std::string deviation_text(const BodySummary& body, const std::string& time_units) {
  const auto& [largest, time] = *body.deviation;
  const double covered = 0.5 * body.thickness;
  std::string text = "          its surface is within " + rounded_text(largest) +
                     " m of the triangles that contact keeps apart (at " + rounded_text(time) +
                     after_number(time_units) + "); ";
  if (largest <= covered)
    return text + "half its thickness, " + rounded_text(covered) + " m, covers that\n";
  return text + "half its thickness covers " + rounded_text(covered) +
         " m of that: a finer image or a larger thickness would cover all\n";
}

std::string size_of(const BodySummary& body) {
  std::string text = std::to_string(body.rows) + " x " + std::to_string(body.cols);
  if (body.patches > 1) text = std::to_string(body.patches) + " x " + text;
  return text;
}

// Returns the radii of a group of particles as text: "0.02 m", or "0.01 to 0.02 m".
std::string radius_text(const BodySummary& body) {
  std::string text = rounded_text(body.least_radius);
  if (body.largest_radius > body.least_radius) text += " to " + rounded_text(body.largest_radius);
  return text + " m";
}

// Returns a text about recorded rows or columns, such as "3 rows from 2 to 8".
std::string range_text(const std::vector<int>& indices, const char* axis) {
  return std::to_string(indices.size()) + " " + axis + " from " + std::to_string(indices.front()) +
         " to " + std::to_string(indices.back());
}

std::array<double, 3> to_array(const bsi::Vec3& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

std::string to_text(const bsi::Vec3& vector) {
  std::ostringstream text;
  text.precision(4);
  text << '(' << vector.x() << ", " << vector.y() << ", " << vector.z() << ')';
  return text.str();
}

std::string to_text(const CrossingPlace& place) {
  return printable(place.body) + " patch " + std::to_string(place.texel.patch) + " row " +
         std::to_string(place.texel.row) + " col " + std::to_string(place.texel.col);
}

// Returns an extreme as text: value, unit and time and, for a field, body and texel: "0.25 m/s at
// 0.5 s, sheet patch 0 row 1 col 2".
std::string to_text(const FieldExtreme& extreme, const std::string& units,
                    const std::string& time_units) {
  std::string text = rounded_text(extreme.value) + after_number(units) + " at " +
                     rounded_text(extreme.time) + after_number(time_units);
  if (extreme.body.empty()) return text;
  return text + ", " + to_text(CrossingPlace{extreme.body, extreme.texel});
}

// Returns one or two lines about the extremes of a field or a record. The first line starts with
// `heading`.
std::string extremes_text(const std::string& heading, const auto& summary,
                          const std::string& time_units) {
  if (!summary.has_extremes) return heading + "no finite value\n";
  return heading + (summary.magnitude ? "magnitude " : "") +
         to_text(summary.minimum, summary.units, time_units) + "\n          to " +
         to_text(summary.maximum, summary.units, time_units) + '\n';
}

std::string to_text(const FieldSummary& field, const std::string& time_units) {
  std::string text = extremes_text("field     " + printable(field.name) + ": ", field, time_units);
  if (field.not_finite == 0) return text;
  return text + "          values that are not finite: " + std::to_string(field.not_finite) + '\n';
}

std::string to_text(const RecordSummary& record, const std::string& time_units) {
  return extremes_text("record    " + printable(record.path) + ": ", record, time_units);
}

std::vector<bsi::Mesh> build_meshes(const std::string& path,
                                    const std::vector<TrajectoryBody>& bodies,
                                    const std::vector<RecordedSurface>& surfaces) {
  std::vector<bsi::Mesh> meshes;
  meshes.reserve(bodies.size());
  for (const TrajectoryBody& body : bodies) {
    try {
      meshes.push_back(surfaces[meshes.size()].mesh());
    } catch (const std::invalid_argument& error) {
      throw FileError(path + ": body " + body.name + ": " + error.what());
    }
  }
  return meshes;
}

nlohmann::ordered_json to_object(const CrossingPlace& place) {
  return {{"body", place.body},
          {"patch", place.texel.patch},
          {"row", place.texel.row},
          {"col", place.texel.col}};
}

nlohmann::ordered_json to_object(const FieldExtreme& extreme) {
  nlohmann::ordered_json object = {
      {"value", extreme.value}, {"frame", extreme.frame}, {"time_s", extreme.time}};
  if (!extreme.body.empty()) object.update(to_object(CrossingPlace{extreme.body, extreme.texel}));
  return object;
}

void add_extremes(const auto& summary, nlohmann::ordered_json& object) {
  object["units"] = summary.units;
  object["magnitude"] = summary.magnitude;
  object["minimum"] = summary.has_extremes ? to_object(summary.minimum) : nullptr;
  object["maximum"] = summary.has_extremes ? to_object(summary.maximum) : nullptr;
}

nlohmann::ordered_json to_object(const FieldSummary& field) {
  nlohmann::ordered_json object = {{"name", field.name}, {"not_finite", field.not_finite}};
  add_extremes(field, object);
  return object;
}

nlohmann::ordered_json to_object(const RecordSummary& record) {
  nlohmann::ordered_json object = {{"path", record.path}};
  add_extremes(record, object);
  return object;
}

// True for the series of smallest gaps, in which NaN means that no pair is in reach.
bool is_gap(const SeriesSummary& series) { return series.name == "smallest_gap"; }

std::string last_of(const SeriesSummary& series) {
  if (is_gap(series) && std::isnan(series.last)) return "nothing in reach";
  std::ostringstream text;
  text << series.last;
  return text.str();
}

// Throws FileError if a position does not allow an exact decision about crossings. The message
// names the frame, the body and the texel.
void require_judgeable(const std::string& path, const TrajectoryBody& body, int frame,
                       std::span<const Vec3> positions) {
  // The exact determinants are valid for magnitudes in the range of float32.
  constexpr double least = std::numeric_limits<float>::denorm_min();
  constexpr double most = std::numeric_limits<float>::max();
  const auto is_exact = [](double x) {
    return x == 0 || (std::abs(x) >= least && std::abs(x) <= most);
  };
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3& p = positions[i];
    if (is_exact(p.x()) && is_exact(p.y()) && is_exact(p.z())) continue;
    const bsi::TexelAddress at = body.atlas.particle_address(static_cast<int>(i));
    throw FileError(path + ": crossings cannot be counted: frame " + std::to_string(frame) +
                    ", body " + in_quotes(body.name) + ", patch " + std::to_string(at.patch) +
                    " row " + std::to_string(at.row) + " col " + std::to_string(at.col) +
                    " has a position that is " +
                    (p.allFinite() ? "beyond the range of float32" : "not finite"));
  }
}

}  // namespace

TrajectorySummary summarise_trajectory(const std::string& path) {
  // The lock is tested before the file is read. In the opposite order, a run that ended in between
  // would seem to have been killed.
  const bool is_written = is_locked(path);
  const TrajectoryReader reader(path);
  TrajectorySummary summary;
  summary.path = path;
  summary.title = reader.title();
  summary.time_units = reader.time_units();
  summary.weft_version = reader.weft_version();
  summary.frames = reader.frames();
  summarise_end(reader, is_written, summary);
  if (summary.frames > 0) {
    summary.first_time = reader.time(0);
    summary.last_time = reader.time(summary.frames - 1);
  }
  for (int b = 0; b < static_cast<int>(reader.bodies().size()); ++b) {
    summary.bodies.push_back(summarise_body(reader, b));
    if (reader.bodies()[b].moves && summary.frames > 0 && !reader.velocities(b, 0).empty()) {
      summary.has_velocity = true;
    }
  }
  summary.fields = field_extremes(reader);
  summary.records = record_extremes(reader);
  for (const auto& series : reader.series()) {
    summary.series.push_back(summarise_series(reader, series));
  }
  return summary;
}

std::string to_text(const TrajectorySummary& summary) {
  std::ostringstream text;
  text << printable(summary.path) << ": Weft trajectory, format " << summary.format_version
       << ", written by Weft " << printable(summary.weft_version) << '\n';
  if (!summary.title.empty()) text << "title     " << printable(summary.title) << '\n';
  text << "run       " << describe_end(summary) << '\n';
  if (summary.bill.total.wall > 0) {
    text << "cost      " << summary.bill.total.wall << " s, " << summary.bill.total.cpu
         << " s of CPU\n";
  }
  text << "frames    " << summary.frames;
  if (summary.frames > 0)
    text << ", " << summary.first_time << " to " << summary.last_time
         << after_number(summary.time_units);
  text << (summary.has_velocity ? ", with velocities\n" : "\n");
  for (const BodySummary& body : summary.bodies) {
    if (body.largest_radius > 0) {
      text << "particles " << printable(body.name) << ": " << body.particles << " of radius "
           << radius_text(body);
    } else {
      text << (body.is_obstacle ? "obstacle  " : "body      ") << printable(body.name) << ": "
           << size_of(body) << ", " << body.particles << " particles, " << body.triangles
           << " triangles";
    }
    if (body.thickness > 0) text << ", " << body.thickness << " m thick";
    if (!body.moves) text << ", fixed";
    text << '\n';
    if (!body.part_rows.empty()) {
      text << "          part: " << range_text(body.part_rows, "rows") << ", "
           << range_text(body.part_cols, "columns") << '\n';
    }
    if (body.deviation) text << deviation_text(body, summary.time_units);
    if (!body.is_finite) text << "          not finite at the last frame\n";
    if (body.has_bounds) {
      text << "          from " << to_text(body.lower) << " to " << to_text(body.upper) << " m\n";
    }
  }
  for (const FieldSummary& field : summary.fields) text << to_text(field, summary.time_units);
  for (const RecordSummary& record : summary.records) text << to_text(record, summary.time_units);
  for (const SeriesSummary& series : summary.series) {
    text << "series    " << printable(series.name) << ": ";
    if (series.has_extremes) {
      text << "last " << last_of(series) << ", " << series.minimum << " to " << series.maximum;
      if (!series.units.empty()) text << ' ' << printable(series.units);
    } else if (summary.frames == 0) {
      text << "no frame";
    } else {
      text << (is_gap(series) ? "nothing was in reach" : "not finite in any frame");
    }
    text << '\n';
  }
  return text.str();
}

std::string to_json(const TrajectorySummary& summary) {
  nlohmann::ordered_json object = {{"path", summary.path},
                                   {"format", "weft-trajectory"},
                                   {"version", summary.format_version},
                                   {"weft_version", summary.weft_version},
                                   {"title", summary.title},
                                   {"status", summary.status},
                                   {"reason", summary.reason},
                                   {"frames", summary.frames},
                                   {"time_units", summary.time_units},
                                   {"first_time_s", summary.first_time},
                                   {"last_time_s", summary.last_time},
                                   {"velocity", summary.has_velocity},
                                   {"bodies", nlohmann::ordered_json::array()},
                                   {"fields", nlohmann::ordered_json::array()},
                                   {"records", nlohmann::ordered_json::array()},
                                   {"series", nlohmann::ordered_json::array()}};
  for (const BillPart& part : bill_parts) {
    if (!(summary.bill.total.wall > 0)) break;
    const Cost& cost = summary.bill.*part.cost;
    object[std::string(part.prefix) + "wall_s"] = cost.wall;
    object[std::string(part.prefix) + "cpu_s"] = cost.cpu;
  }
  for (const BodySummary& body : summary.bodies) {
    nlohmann::ordered_json entry = {
        {"name", body.name},   {"patches", body.patches},      {"rows", body.rows},
        {"cols", body.cols},   {"particles", body.particles},  {"triangles", body.triangles},
        {"moves", body.moves}, {"obstacle", body.is_obstacle}, {"thickness_m", body.thickness}};
    if (body.largest_radius > 0) {
      entry["least_radius_m"] = body.least_radius;
      entry["largest_radius_m"] = body.largest_radius;
    }
    if (!body.part_rows.empty()) {
      entry["part_rows"] = body.part_rows;
      entry["part_cols"] = body.part_cols;
    }
    if (body.deviation) {
      entry["surface_deviation_m"] = body.deviation->largest;
      entry["surface_deviation_time_s"] = body.deviation->time;
    }
    if (body.has_bounds) {
      entry["lower_m"] = to_array(body.lower);
      entry["upper_m"] = to_array(body.upper);
    }
    object["bodies"].push_back(std::move(entry));
  }
  for (const FieldSummary& field : summary.fields) object["fields"].push_back(to_object(field));
  for (const RecordSummary& record : summary.records)
    object["records"].push_back(to_object(record));
  for (const SeriesSummary& series : summary.series) {
    nlohmann::ordered_json entry = {
        {"name", series.name}, {"units", series.units}, {"last", series.last}};
    entry["minimum"] = series.has_extremes ? nlohmann::ordered_json(series.minimum) : nullptr;
    entry["maximum"] = series.has_extremes ? nlohmann::ordered_json(series.maximum) : nullptr;
    object["series"].push_back(std::move(entry));
  }
  return json_text(object);
}

std::vector<FrameCrossings> count_crossings(const std::string& path) {
  const TrajectoryReader reader(path);
  const std::vector<TrajectoryBody>& bodies = reader.bodies();
  if (reader.frames() == 0) throw FileError(path + ": has no complete frame to judge");
  const bool has_body = std::ranges::any_of(bodies, [](const TrajectoryBody& body) {
    return !body.is_obstacle && !body.is_of_spheres();
  });
  if (!has_body) throw FileError(path + ": has no body to judge, only obstacles or particles");
  const auto part = std::ranges::find_if(bodies, &TrajectoryBody::is_part);
  if (part != bodies.end()) {
    throw FileError(path + ": crossings cannot be counted: only a part of body " +
                    in_quotes(part->name) + " is recorded");
  }
  const std::vector<RecordedSurface> recorded(bodies.begin(), bodies.end());
  const std::vector<bsi::Mesh> meshes = build_meshes(path, bodies, recorded);
  const auto place = [&](int body, int triangle) {
    return CrossingPlace{bodies[body].name, recorded[body].atlas().quad_address(triangle / 2)};
  };
  std::set<std::array<int, 4>> sewn;
  for (const auto& [body, particle, other_body, other_particle] : reader.sewn()) {
    sewn.insert({body, particle, other_body, other_particle});
    sewn.insert({other_body, other_particle, body, particle});
  }
  // Triangles with particles that are sewn together touch.
  const auto are_sewn = [&](const Crossing& crossing) {
    for (const int a : meshes[crossing.surface_a].triangles[crossing.triangle_a]) {
      for (const int b : meshes[crossing.surface_b].triangles[crossing.triangle_b]) {
        if (sewn.contains({crossing.surface_a, a, crossing.surface_b, b})) return true;
      }
    }
    return false;
  };
  std::vector<FrameCrossings> result;
  std::vector<std::vector<Vec3>> positions(bodies.size());
  for (int f = 0; f < reader.frames(); ++f) {
    std::vector<CrossingSurface> surfaces;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (f == 0 || bodies[b].moves) {
        positions[b] = reader.positions(static_cast<int>(b), f);
        require_judgeable(path, bodies[b], f, positions[b]);
        positions[b] = recorded[b].points(std::move(positions[b]));
      }
      surfaces.push_back({positions[b], meshes[b].triangles, !bodies[b].is_obstacle});
    }
    std::vector<Crossing> crossings = find_crossings(surfaces);
    std::erase_if(crossings, [&](const Crossing& crossing) {
      return bodies[crossing.surface_a].is_obstacle && bodies[crossing.surface_b].is_obstacle;
    });
    if (!sewn.empty()) std::erase_if(crossings, are_sewn);
    FrameCrossings& frame = result.emplace_back();
    frame.frame = f;
    frame.time = reader.time(f);
    frame.count = static_cast<int>(crossings.size());
    if (crossings.empty()) continue;
    frame.a = place(crossings.front().surface_a, crossings.front().triangle_a);
    frame.b = place(crossings.front().surface_b, crossings.front().triangle_b);
  }
  return result;
}

std::string to_text(const std::vector<FrameCrossings>& frames) {
  std::ostringstream text;
  long total = 0;
  for (const FrameCrossings& frame : frames) {
    total += frame.count;
    if (frame.count == 0) continue;
    text << "frame " << frame.frame << " (" << frame.time
         << " s): " << counted(frame.count, "crossing", "crossings") << ", the first between "
         << to_text(frame.a) << " and " << to_text(frame.b) << '\n';
  }
  text << counted(total, "crossing", "crossings") << " in "
       << counted(std::ssize(frames), "frame", "frames") << '\n';
  return text.str();
}

std::string to_json(const std::vector<FrameCrossings>& frames) {
  nlohmann::ordered_json object = {{"crossings", 0}, {"frames", nlohmann::ordered_json::array()}};
  long total = 0;
  for (const FrameCrossings& frame : frames) {
    nlohmann::ordered_json entry = {
        {"frame", frame.frame}, {"time_s", frame.time}, {"count", frame.count}};
    if (frame.count > 0) entry["first"] = {to_object(frame.a), to_object(frame.b)};
    total += frame.count;
    object["frames"].push_back(std::move(entry));
  }
  object["crossings"] = total;
  return json_text(object);
}

}  // namespace weft::sim
