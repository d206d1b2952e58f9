// Numbers of a trajectory for expressions: series, quantities of frames, and numbers of the run.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/probes/recorded_quantity.h"
#include "sim/trajectory/trajectory.h"
#include "sim/view/recorded_surface.h"

namespace weft::sim {

// The instants at which values were recorded.
enum class Instants { frames, steps };

// A number of the whole run. The times are those of the bill, NaN unless the run has ended.
enum class RunNumber { cpu_time, wall_time, duration, frames };

// Reads the numbers that expressions ask for. Keeps the series that were read, and of each body and
// field the last frame.
class RecordedValues {
 public:
  // The reader must outlive this object.
  explicit RecordedValues(const TrajectoryReader& reader);

  // Return the number of instants and their times (s). The time of a step is its end.
  int count(Instants instants);
  double time(Instants instants, int index);
  // Returns a value of a series of frames or steps; `number` is its index in the contents.
  double series(Instants instants, int number, int index);
  // Returns a quantity in a frame. NaN if it is the shadow or the area of a surface that is not
  // finite. Throws FileError.
  double quantity(const RecordedQuantity& quantity, int frame);
  // Returns a number of the run; its duration is the time of the last frame (s).
  double number(RunNumber number) const;
  const TrajectoryContents& contents() const { return contents_; }

 private:
  // Values of one frame.
  template <class Value>
  struct Frame {
    int frame = -1;
    std::vector<Value> values;
  };
  struct Surface {
    RecordedSurface surface;
    std::vector<std::array<int, 3>> triangles;
  };

  const std::vector<double>& list(const std::string& path, const auto& read);
  const std::vector<Vec3>& positions(int body, int frame);
  const std::vector<double>& field(int body, const std::string& name, int frame);
  const Surface& surface(int body);
  Vec3 vector(const RecordedQuantity& quantity, int frame);
  Vec3 shadow(int body, int frame, RecordedQuantity::Part axis);
  double extreme(const RecordedQuantity& quantity, int frame);
  double area(int body, int frame);

  const TrajectoryReader& reader_;
  TrajectoryContents contents_;
  std::map<std::string, std::vector<double>> lists_;  // series and records, by path
  std::map<int, Frame<Vec3>> positions_;              // by body
  std::map<int, std::vector<Vec3>> first_positions_;  // by body
  std::map<std::pair<int, std::string>, Frame<double>> fields_;
  std::map<int, Surface> surfaces_;
};

}  // namespace weft::sim
