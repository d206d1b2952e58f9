// Computes the channels that a case records (sim/case/channels.h) from the states of a simulation.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/case/channels.h"
#include "sim/channels/surface_tensors.h"
#include "sim/forces/springs.h"
#include "sim/motion/dynamics.h"
#include "sim/simulation/simulation.h"

namespace weft::sim {

// A dataset of a channel and its place in a trajectory.
struct ChannelPlace {
  const Channel* channel;
  const ChannelDataset* dataset;
  std::string path;  // only of records: "reactions/cloth/pin_1/force"
};

// Returns the fields that the trajectory holds for a body, besides the positions. Simulated bodies
// have all fields. Obstacles and bodies held as a whole have only the velocity, and only if they
// move.
std::vector<ChannelPlace> channel_fields(const SceneBody& body, const OutputCase& output);

// The fields and records of a run, and their values in the frame of the last compute(). Channels
// that the case does not record cost nothing. Sleeping bodies count as simulated.
class RecordedChannels {
 public:
  // The simulation must outlive this object.
  explicit RecordedChannels(const Simulation& simulation);

  std::vector<ChannelPlace> fields(const SceneBody& body) const {
    return channel_fields(body, scene_.source.output);
  }
  // The datasets of records, in the order of record_values().
  const std::vector<ChannelPlace>& records() const { return records_; }

  // Computes the values of the state `y` at `time` (s), within the last step. `position` (m) and
  // `velocity` (m/s) are those of all particles, obstacles included. They must live until the
  // values have been read. Evaluates the forces once if a channel needs them.
  void compute(double time, std::span<const double> y, std::span<const Vec3> position,
               std::span<const Vec3> velocity);
  // Values of fields(), by body in the order of the case and by field, with `components` numbers
  // per particle.
  const std::vector<std::vector<std::span<const double>>>& field_values() const {
    return field_values_;
  }
  // Values of all records, one record after the other.
  std::span<const double> record_values() const { return record_values_; }

 private:
  // A support: a pin, a body or obstacle that is prescribed as a whole, or a tie.
  struct Support {
    int body = -1;  // index into Scene::bodies; -1: a tie
    int pin = -1;   // -1: not a pin
    int tie = -1;   // number of the tie; -1: not a tie
    Wrench wrench;
  };
  // The tensors of a simulated body.
  struct Surface {
    std::optional<SurfaceTensors> tensors;
    std::vector<ClampedBy> clamped;  // clamped edges that the tensors include
    PrincipalValues strain, stress, curvature, moment;
  };

  bool has(ChannelId id) const { return records_channel_[static_cast<std::size_t>(id)] != 0; }
  void list_supports();
  void list_records();
  void add_record(const Channel& channel, const std::string& path);
  std::string home_of(const Support& support) const;
  void place_surface(int body, double time, std::span<const Vec3> position,
                     std::span<const Vec3> velocity);
  void find_surfaces(double time, std::span<const Vec3> position, std::span<const Vec3> velocity);
  void find_supports(std::span<const Vec3> position);
  std::span<const double> values_of(int body, const ChannelPlace& place,
                                    std::span<const Vec3> velocity) const;
  void add_energies(double time, std::span<const Vec3> position, std::span<const Vec3> velocity);
  void add_largest_stretch(std::span<const Vec3> position);

  const Simulation& simulation_;
  const Scene& scene_;
  std::vector<char> records_channel_;  // by ChannelId: true if the case records the channel
  std::vector<ChannelPlace> records_;
  std::vector<Support> supports_;
  bool bends_ = false;             // the case records curvature or moment
  std::vector<Surface> surfaces_;  // by dynamic body; empty if no channel needs them
  SpringNetwork springs_;          // empty unless energies are recorded
  ForceParts forces_;
  std::vector<std::vector<std::span<const double>>> field_values_;
  std::vector<double> record_values_;
};

}  // namespace weft::sim
