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

// A dataset of a channel, as a field of a body or as a record of the run.
struct ChannelPlace {
  const Channel* channel;
  const ChannelDataset* dataset;
  std::string path;  // path of a record, such as "reactions/cloth/pin_1/force"; empty for a field
};

// Returns the fields that a trajectory holds for a body, besides the positions. A simulated body
// has every field of surfaces that `output` requests, and a group of spheres the velocity and the
// angular velocity. An obstacle or a body held as a whole has at most the velocity. A body that
// does not move has no fields.
std::vector<ChannelPlace> channel_fields(const SceneBody& body, const OutputCase& output);

// The fields and records of a run, and their values at the time of the last compute(). Channels
// that the case does not record are not computed. Sleeping bodies count as simulated.
class RecordedChannels {
 public:
  // The simulation must outlive this object.
  explicit RecordedChannels(const Simulation& simulation);

  std::vector<ChannelPlace> fields(const SceneBody& body) const {
    return channel_fields(body, scene_.source.output);
  }
  // Returns the datasets of all records, in the order of record_values().
  const std::vector<ChannelPlace>& records() const { return records_; }

  // Computes all values in the state `y` at `time` (s), a time within the last step. `position` (m)
  // and `velocity` (m/s) have one entry per particle, including particles of obstacles. Their
  // arrays must remain valid until the values have been read. Evaluates the forces once if a
  // channel needs them.
  void compute(double time, std::span<const double> y, std::span<const Vec3> position,
               std::span<const Vec3> velocity);
  // Returns the values of fields(), by body in the order of the case and by field. A field has
  // ChannelDataset::components numbers per particle.
  const std::vector<std::vector<std::span<const double>>>& field_values() const {
    return field_values_;
  }
  // Returns the values of all records, one record after the other.
  std::span<const double> record_values() const { return record_values_; }

 private:
  // A support: a pin, a tie, an obstacle, or a body that is held as a whole.
  struct Support {
    int body = -1;  // index into Scene::bodies; -1 for a tie
    int pin = -1;   // index of the pin in its body; -1 if the support is no pin
    int tie = -1;   // Tie::number; -1 if the support is no tie
    Wrench wrench;
  };
  // The tensors of a simulated body.
  struct Surface {
    std::optional<SurfaceTensors> tensors;
    std::vector<ClampedBy> clamped;  // clamped edges with which `tensors` was made
    PrincipalValues strain, stress, curvature, moment, crease;
  };

  bool has(ChannelId id) const { return records_channel_[static_cast<std::size_t>(id)] != 0; }
  void list_supports();
  void list_records();
  void add_record(const Channel& channel, const std::string& path);
  std::string home_of(const Support& support) const;
  void place_surface(int body, double time, std::span<const double> y,
                     std::span<const Vec3> position, std::span<const Vec3> velocity);
  void find_surfaces(double time, std::span<const double> y, std::span<const Vec3> position,
                     std::span<const Vec3> velocity);
  void find_supports(std::span<const Vec3> position);
  void find_turning(double time, std::span<const Vec3> velocity);
  std::span<const double> values_of(int body, const ChannelPlace& place,
                                    std::span<const Vec3> velocity) const;
  void add_energies(double time, std::span<const Vec3> position, std::span<const Vec3> velocity);
  void add_largest_stretch(std::span<const Vec3> position);

  const Simulation& simulation_;
  const Scene& scene_;
  std::vector<char> records_channel_;  // by ChannelId: nonzero if the case records the channel
  std::vector<ChannelPlace> records_;
  std::vector<Support> supports_;
  bool bends_ = false;             // true if the case records curvature or moment
  std::vector<Surface> surfaces_;  // by dynamic body; empty if no channel needs them
  SpringNetwork springs_;          // empty unless energies are recorded
  ForceParts forces_;
  std::vector<Vec3>
      turning_;  // rad/s, by dynamic particle; empty unless angular velocities are recorded
  std::vector<std::vector<std::span<const double>>> field_values_;
  std::vector<double> record_values_;
};

}  // namespace weft::sim
