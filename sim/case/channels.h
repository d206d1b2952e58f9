// The channels: quantities that a case may record besides the positions, with their datasets in a
// trajectory.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace weft::sim {

struct Case;
struct OutputCase;

enum class ChannelId {
  velocity,
  angular_velocity,
  membrane_strain,
  membrane_stress,
  bending_curvature,
  bending_moment,
  crease_curvature,
  contact_force,
  friction_force,
  reactions,
  body_energy,
  largest_stretch_place
};

// One dataset of a channel.
struct ChannelDataset {
  const char* name;
  const char* units;
  int components = 1;  // 1: a number, 3: a vector
};

struct Channel {
  // The objects for which a channel has values: the texels of bodies and the particles of groups,
  // the supports (pins, ties, obstacles and held bodies), the simulated bodies, or the run as a
  // whole.
  enum class Home { texels, supports, bodies, run };
  const char* name;
  ChannelId id;
  Home home;
  std::span<const ChannelDataset> datasets;
};

// Returns all channels, in a fixed order.
std::span<const Channel> all_channels();
std::vector<std::string> channel_names();

// True if the case records the channel. `output.velocity` requests the channel "velocity".
bool records(const OutputCase& output, ChannelId id);
// Returns the channels that the case records, in the order of all_channels().
std::vector<const Channel*> recorded_channels(const OutputCase& output);

// Returns the reason to refuse a channel: the case cannot compute it, or its values would be
// missing or zero everywhere. `hint` then receives the expected alternatives. Returns an empty text
// for a channel that the case may record.
std::string reason_against(const Channel& channel, const Case& source, std::string& hint);

}  // namespace weft::sim
