#include "sim/trajectory/frame_recorder.h"

#include <filesystem>
#include <limits>

#include "sim/base/stopwatch.h"
#include "sim/integrator/integrator.h"

namespace weft::sim {

namespace {

using Series = TrajectoryWriter::Series;

// Usual wall time between commits (s). A killed run loses the frames since its last commit.
constexpr double commit_interval = 0.25;

// A series about a counter or a phase time, with one value per frame.
struct StatisticColumn {
  const char* name;
  const char* units;
  double (*value)(const Statistics&, const IntegratorCounts&);
};

template <class Integer>
double number(Integer value) {
  return static_cast<double>(value);
}

constexpr StatisticColumn statistic_columns[] = {
    {"steps", "1", [](const Statistics&, const IntegratorCounts& c) { return number(c.steps); }},
    {"vetoed_steps", "1",
     [](const Statistics&, const IntegratorCounts& c) { return number(c.vetoed_steps); }},
    {"newton_iterations", "1",
     [](const Statistics&, const IntegratorCounts& c) { return number(c.newton_iterations); }},
    {"linear_iterations", "1",
     [](const Statistics&, const IntegratorCounts& c) { return number(c.linear_iterations); }},
    {"rebuilds", "1",
     [](const Statistics& s, const IntegratorCounts&) { return number(s.counters.rebuilds); }},
    {"bound_tests", "1",
     [](const Statistics& s, const IntegratorCounts&) { return number(s.counters.bound_tests); }},
    {"candidate_pairs", "1",
     [](const Statistics& s, const IntegratorCounts&) {
       return number(s.counters.candidate_pairs);
     }},
    {"narrow_phase_calls", "1",
     [](const Statistics& s, const IntegratorCounts&) {
       return number(s.counters.narrow_phase_calls);
     }},
    {"ccd_calls", "1",
     [](const Statistics& s, const IntegratorCounts&) { return number(s.counters.ccd_calls); }},
    {"force_evaluations", "1",
     [](const Statistics& s, const IntegratorCounts&) {
       return number(s.counters.force_evaluations);
     }},
    {"matrix_assemblies", "1",
     [](const Statistics& s, const IntegratorCounts&) {
       return number(s.counters.matrix_assemblies);
     }},
    {"wall_rebuild", "s",
     [](const Statistics& s, const IntegratorCounts&) { return s.phases.rebuild; }},
    {"wall_traverse", "s",
     [](const Statistics& s, const IntegratorCounts&) { return s.phases.traverse; }},
    {"wall_narrow_phase", "s",
     [](const Statistics& s, const IntegratorCounts&) { return s.phases.narrow_phase; }},
    {"wall_forces", "s",
     [](const Statistics& s, const IntegratorCounts&) { return s.phases.forces; }},
    {"wall_linear_solve", "s",
     [](const Statistics& s, const IntegratorCounts&) { return s.phases.linear_solve; }},
    {"wall_energies", "s",
     [](const Statistics& s, const IntegratorCounts&) { return s.phases.energies; }},
    {"wall_record", "s",
     [](const Statistics& s, const IntegratorCounts&) { return s.phases.record; }},
};

std::vector<TrajectoryRecord> trajectory_records(const RecordedChannels& channels) {
  std::vector<TrajectoryRecord> records;
  for (const auto& [channel, dataset, path] : channels.records())
    records.push_back({path, dataset->units, channel->name, dataset->components});
  return records;
}

// Returns the series of energies. append_energies() and named() give their values in this order.
std::vector<Series> energy_series(const Dynamics& dynamics) {
  std::vector<Series> series{
      {"energy_kinetic", "J"}, {"energy_gravitational", "J"}, {"energy_contact", "J"}};
  for (const std::string& name : dynamics.force_names()) series.push_back({"energy_" + name, "J"});
  series.push_back({"energy_total", "J"});
  if (dynamics.has_creases()) series.push_back({"dissipated_by_creases", "J"});
  return series;
}

std::vector<Series> step_series(const Dynamics& dynamics) {
  std::vector<Series> series{{"time", "s"},
                             {"step_size", "s"},
                             {"order", "1"},
                             {"newton_iterations", "1"},
                             {"linear_iterations", "1"},
                             {"vetoes", "1"},
                             {"contact_pairs", "1"},
                             {"smallest_gap", "m"}};
  if (!dynamics.scene().source.output.step_energies) return series;
  const std::vector<Series> energies = energy_series(dynamics);
  series.insert(series.end(), energies.begin(), energies.end());
  return series;
}

// Returns the energies (J), each with the name of its series.
std::vector<std::pair<std::string, double>> named(const Energies& energies) {
  std::vector<std::pair<std::string, double>> values{
      {"energy_kinetic", energies.kinetic},
      {"energy_gravitational", energies.gravitational},
      {"energy_contact", energies.contact}};
  for (const auto& [name, value] : energies.elastic) values.emplace_back("energy_" + name, value);
  values.emplace_back("energy_total", energies.total());
  if (energies.dissipated) values.emplace_back("dissipated_by_creases", *energies.dissipated);
  return values;
}

void append_energies(const Energies& energies, std::vector<double>& values) {
  values.insert(values.end(), {energies.kinetic, energies.gravitational, energies.contact});
  for (const auto& [name, value] : energies.elastic) values.push_back(value);
  values.push_back(energies.total());
  if (energies.dissipated) values.push_back(*energies.dissipated);
}

double or_nan(std::optional<double> gap) {
  return gap.value_or(std::numeric_limits<double>::quiet_NaN());
}

// Returns the series of frames. FrameRecorder::frame_values() gives their values in this order.
std::vector<Series> frame_series(const Simulation& simulation, const std::vector<Series>& more) {
  std::vector<Series> series = energy_series(simulation.dynamics());
  series.push_back({"smallest_gap", "m"});
  series.push_back({"largest_stretch", "1"});
  series.push_back({"sleeping_bodies", "1"});
  if (simulation.integrator().path_point()) {
    series.push_back({"load_factor", "1"});
    series.push_back({"negative_directions", "1"});
  }
  for (const StatisticColumn& column : statistic_columns)
    series.push_back({column.name, column.units});
  series.insert(series.end(), more.begin(), more.end());
  return series;
}

// Returns the folder of a case, relative to the folder of a trajectory. Both may then be moved
// together. Returns an empty text if a folder cannot be accessed.
std::string folder_from(const std::string& trajectory, const std::string& case_path) {
  namespace fs = std::filesystem;
  std::error_code error, unknown;
  const fs::path from = fs::absolute(trajectory, unknown).parent_path();
  const fs::path of_case = fs::absolute(case_path, unknown).parent_path();
  if (from.empty() || of_case.empty()) return "";
  // Symbolic links are resolved first, because a link and ".." do not cancel each other.
  const fs::path folder = fs::proximate(of_case, from, error);
  return error ? "" : folder.string();
}

}  // namespace

TrajectoryContents recorded_contents(const Simulation& simulation,
                                     const std::vector<Series>& more) {
  const RecordedChannels channels(simulation);
  const RecordedImages images(simulation.scene(), channels);
  return {images.bodies(), trajectory_records(channels), frame_series(simulation, more),
          step_series(simulation.dynamics())};
}

FrameRecorder::FrameRecorder(const Simulation& simulation, const std::string& path, bool force,
                             Cost& cost, const std::vector<Series>& more)
    : path_(path),
      scene_(simulation.scene()),
      simulation_(simulation),
      dynamics_(simulation.dynamics()),
      cost_(cost),
      channels_(simulation),
      images_(scene_, channels_),
      layout_(make_layout(more)),
      writer_(path, layout_.bodies, layout_.series,
              {.title = scene_.source.title,
               .case_text = scene_.source.resolved_text,
               .compute = simulation.compute(),
               .case_folder = folder_from(path, scene_.source.path),
               .force = force,
               .step_series = layout_.step_series,
               .records = layout_.records,
               .sewn = images_.sewn(),
               .precision = scene_.source.output.precision,
               .compression = scene_.source.output.compression,
               .compression_error = scene_.source.output.compression_error,
               .publish_later = true,
               .commit_interval = commit_interval},
              images_.positions(scene_.initial_position)) {}

TrajectoryLayout FrameRecorder::make_layout(const std::vector<Series>& more) const {
  return {images_.bodies(), frame_series(simulation_, more), step_series(dynamics_),
          trajectory_records(channels_)};
}

void FrameRecorder::copy_earlier(int frames) {
  const CostTimer cost(cost_);
  copy_frames(path_, frames, layout_, writer_);
}

void FrameRecorder::publish() { writer_.publish(); }

void FrameRecorder::transfer(StateArchive& archive) {
  archive(last_counts_, step_rows_);
  std::size_t count = energies_.size();
  archive(count);
  energies_.resize(count);
  for (auto& [name, energy] : energies_) archive(name, energy);
}

std::vector<double> FrameRecorder::frame_values(const StateSummary& summary, double largest_stretch,
                                                const IntegratorCounts& counts) const {
  std::vector<double> values;
  append_energies(summary.energies, values);
  values.push_back(or_nan(summary.smallest_gap));
  values.push_back(largest_stretch);
  values.push_back(summary.sleeping_bodies);
  if (const auto point = simulation_.integrator().path_point()) {
    values.push_back(point->load_factor);
    values.push_back(point->negative_directions);
  }
  for (const StatisticColumn& column : statistic_columns) {
    values.push_back(column.value(dynamics_.statistics(), counts));
  }
  return values;
}

void FrameRecorder::add_step(const Simulation& simulation) {
  const Integrator& integrator = simulation.integrator();
  const IntegratorCounts counts = integrator.counts();
  step_rows_.insert(step_rows_.end(),
                    {integrator.time(), integrator.last_step(), number(integrator.last_order()),
                     number(counts.newton_iterations - last_counts_.newton_iterations),
                     number(counts.linear_iterations - last_counts_.linear_iterations),
                     number(counts.vetoed_steps - last_counts_.vetoed_steps),
                     number(simulation.contact_pairs()), or_nan(simulation.smallest_gap())});
  if (scene_.source.output.step_energies) append_energies(simulation.energies(), step_rows_);
  last_counts_ = counts;
}

void FrameRecorder::commit_before_pause(double pause) {
  if (!writer_.is_due(pause)) return;
  commit();
}

void FrameRecorder::commit() {
  const CostTimer cost(cost_);
  const PhaseTimer timer(dynamics_.statistics().phases.record);
  writer_.commit();
}

void FrameRecorder::finish(const RunEnd& end) {
  const CostTimer cost(cost_);
  const PhaseTimer timer(dynamics_.statistics().phases.record);
  writer_.finish(end);
}

double FrameRecorder::add_frame(double time, std::span<const double> y,
                                const IntegratorCounts& counts, std::span<const double> more) {
  const StateSummary summary = simulation_.summary_of(time, y);
  const CostTimer cost(cost_);
  const PhaseTimer timer(dynamics_.statistics().phases.record);
  dynamics_.expand_all(time, y, position_, velocity_);
  const double largest_stretch = dynamics_.largest_stretch(position_);
  channels_.compute(time, y, position_, velocity_);
  energies_ = named(summary.energies);
  std::vector<double> values = frame_values(summary, largest_stretch, counts);
  values.insert(values.end(), more.begin(), more.end());
  writer_.write_frame(time, images_.positions(position_),
                      {images_.fields(), channels_.record_values()}, values, step_rows_);
  step_rows_.clear();
  return largest_stretch;
}

}  // namespace weft::sim
