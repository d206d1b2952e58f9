#include "sim/view/output_description.h"

#include <cmath>
#include <ostream>

#include "sim/case/case_text.h"
#include "sim/case/frame_times.h"
#include "sim/case/memory_estimate.h"
#include "sim/channels/recorded_channels.h"
#include "sim/scene/recorded_bodies.h"

namespace weft::sim {

namespace {

// Page size of a trajectory file, and size of the view of one image (bytes). An image of at least a
// page starts on a new page.
constexpr double page = 4096, view_bytes = 1024;

double on_disk(double image) {
  return (image < page ? image : std::ceil(image / page) * page) + view_bytes;
}

// Returns the size on disk (bytes) of a body's images in one frame.
double bytes_per_frame(const OutputCase& output, const SceneBody& body, int texels) {
  const double number = output.precision == Precision::float64 ? 8 : 4;
  double bytes = on_disk(3 * number * texels);
  for (const ChannelPlace& field : channel_fields(body, output))
    bytes += on_disk(4.0 * field.dataset->components * texels);
  return bytes;
}

int texels_of(const Scene& scene, const RecordedBody& recorded) {
  return (recorded.part ? recorded.part->atlas : scene.bodies[recorded.body].atlas).texel_count();
}

void describe_recorded_bodies(const Scene& scene, std::ostream& out) {
  const OutputCase& output = scene.source.output;
  if (!output.bodies.empty()) out << ", of " << quoted_list(output.bodies) << " only";
  for (const RecordedBody& recorded : recorded_bodies(scene)) {
    if (!recorded.part) continue;
    out << ", of " << in_quotes(scene.bodies[recorded.body].name) << ' '
        << recorded.part->rows.size() << " x " << recorded.part->cols.size() << " vertices";
  }
}

void describe_channels(const OutputCase& output, std::ostream& out) {
  std::vector<std::string> names;
  for (const Channel* channel : recorded_channels(output)) names.emplace_back(channel->name);
  if (names.empty()) {
    out << "  skipped channels beside the positions: output.channels lists none\n";
  } else {
    out << "  channels " << quoted_list(names) << '\n';
  }
}

}  // namespace

double image_bytes(const Scene& scene) {
  const double frames = FrameTimes(scene.source).count();
  double bytes = 0;
  for (const RecordedBody& recorded : recorded_bodies(scene)) {
    const SceneBody& body = scene.bodies[recorded.body];
    const int texels = texels_of(scene, recorded);
    bytes += (body.moves ? frames : 1) * bytes_per_frame(scene.source.output, body, texels);
  }
  return bytes;
}

void describe_output(const Scene& scene, std::ostream& out) {
  const OutputCase& output = scene.source.output;
  const double frames = FrameTimes(scene.source).count();
  out << "file      images of about " << memory_text(image_bytes(scene));
  if (output.compression == Compression::lossless) out << " before compression without loss";
  if (output.compression == Compression::bounded)
    out << " before compression within " << number_text(output.compression_error) << " m";
  out << ": " << rounded_text(frames) << (frames == 1 ? " frame" : " frames");
  describe_recorded_bodies(scene, out);
  if (output.precision == Precision::float64) out << ", positions in float64";
  out << '\n';
  if (const std::string notice = rounding_notice(scene); !notice.empty())
    out << "  " << notice << '\n';
  describe_channels(output, out);
}

}  // namespace weft::sim
