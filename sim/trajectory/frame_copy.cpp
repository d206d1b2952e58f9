#include "sim/trajectory/frame_copy.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "sim/base/reading_process.h"

namespace weft::sim {

namespace {

// The lists of a trajectory: one value, or one vector, per frame or step.
struct CopiedLists {
  std::vector<std::vector<double>> series, steps, records;
  std::vector<std::int64_t> steps_before;  // number of steps before each frame
};

bool has_same_bodies(const TrajectoryReader& from, const TrajectoryLayout& layout) {
  return std::ranges::equal(
      from.bodies(), layout.bodies, [](const TrajectoryBody& a, const TrajectoryBody& b) {
        return a.name == b.name && a.moves == b.moves && a.fields == b.fields &&
               a.radii == b.radii && a.atlas.texel_count() == b.atlas.texel_count() &&
               a.atlas.particle_count() == b.atlas.particle_count();
      });
}

// Returns the numbers of steps before the frames. Throws FileError if they do not grow.
std::vector<std::int64_t> counts_of_steps(const std::string& path,
                                          const std::vector<double>& series) {
  constexpr double most = 1e15;  // which a double counts exactly
  std::vector<std::int64_t> counts;
  for (const double steps : series) {
    const bool is_count = steps >= 0 && steps <= most && steps == std::floor(steps);
    if (!is_count || (!counts.empty() && static_cast<std::int64_t>(steps) < counts.back()))
      throw FileError(path + ": series/steps does not count the steps before each frame");
    counts.push_back(static_cast<std::int64_t>(steps));
  }
  return counts;
}

CopiedLists read_lists(const std::string& path, const TrajectoryReader& from, int frames,
                       const TrajectoryLayout& layout) {
  CopiedLists lists;
  for (const auto& series : layout.series) lists.series.push_back(from.series_values(series.name));
  for (const TrajectoryRecord& record : layout.records)
    lists.records.push_back(from.record_values(record.path));
  lists.steps_before = counts_of_steps(path, from.series_values("steps"));
  const std::int64_t all = frames == 0 ? 0 : lists.steps_before[frames - 1];
  for (const auto& series : layout.step_series)
    lists.steps.push_back(from.step_values(series.name, all));
  return lists;
}

// Appends the values of one frame to `values`. The list has `width` numbers per frame.
void append_frame(const std::vector<double>& list, int frame, int width,
                  std::vector<double>& values) {
  const auto first = list.begin() + std::ptrdiff_t{frame} * width;
  values.insert(values.end(), first, first + width);
}

// Positions and fields of one frame, and views of them.
class CopiedImages {
 public:
  CopiedImages(const TrajectoryReader& from, int frame) {
    const auto count = static_cast<int>(from.bodies().size());
    positions_.resize(count);
    fields_.resize(count);
    field_views_.resize(count);
    for (int b = 0; b < count; ++b) {
      const TrajectoryBody& body = from.bodies()[b];
      if (!body.moves) continue;
      positions_[b] = from.positions(b, frame);
      for (const TrajectoryField& field : body.fields)
        fields_[b].push_back(from.field_values(b, field.name, frame));
      field_views_[b].assign(fields_[b].begin(), fields_[b].end());
    }
    position_views_.assign(positions_.begin(), positions_.end());
  }
  const std::vector<std::span<const Vec3>>& positions() const { return position_views_; }
  const std::vector<std::vector<std::span<const double>>>& fields() const { return field_views_; }

 private:
  std::vector<std::vector<Vec3>> positions_;
  std::vector<std::vector<std::vector<double>>> fields_;
  std::vector<std::span<const Vec3>> position_views_;
  std::vector<std::vector<std::span<const double>>> field_views_;
};

}  // namespace

void require_readable(const std::string& path, int frames) {
  const auto read = [&] {
    try {
      const TrajectoryReader reader(path);
      for (const auto& series : reader.series()) reader.series_values(series.name);
      for (int frame = 0; frame < std::min(frames, reader.frames()); ++frame)
        CopiedImages(reader, frame);
    } catch (const FileError&) {
      return 1;
    }
    return 0;
  };
  // Slowest reading that is allowed (bytes/s): a tenth of the usual rate for compressed data.
  constexpr double slowest_reading = 5e6;
  std::error_code unknown;
  const auto size = std::filesystem::file_size(path, unknown);
  const double limit =
      reading_cpu_limit + (unknown ? 0 : static_cast<double>(size) / slowest_reading);
  const ProcessEnd end = run_in_process(read, {}, limit);
  if (end.signal != 0) throw FileError(describe_crash(path, end.signal));
}

void copy_frames(const std::string& path, int frames, const TrajectoryLayout& layout,
                 TrajectoryWriter& to) {
  const TrajectoryReader from(path);
  if (!has_same_bodies(from, layout))
    throw FileError(path + ": cannot be continued: it has other bodies or fields than this case");
  if (frames > from.frames())
    throw FileError(path + ": cannot be continued: it lacks frames that its checkpoint counts");
  const CopiedLists lists = read_lists(path, from, frames, layout);
  std::int64_t step = 0;
  for (int frame = 0; frame < frames; ++frame) {
    std::vector<double> series, records, step_rows;
    for (const auto& list : lists.series) append_frame(list, frame, 1, series);
    for (std::size_t r = 0; r < lists.records.size(); ++r)
      append_frame(lists.records[r], frame, layout.records[r].components, records);
    for (; step < lists.steps_before[frame]; ++step) {
      for (const auto& column : lists.steps) step_rows.push_back(column.at(step));
    }
    const CopiedImages images(from, frame);
    to.write_frame(from.time(frame), images.positions(), {images.fields(), records}, series,
                   step_rows);
  }
}

}  // namespace weft::sim
