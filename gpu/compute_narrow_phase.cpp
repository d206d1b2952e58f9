#include "gpu/compute_narrow_phase.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <iterator>

#include "gpu/compute_shaders.h"
#include "gpu/gl_objects.h"
#include "gpu/narrow_phase_shaders.h"

namespace weft::gpu {
namespace {

static_assert(sizeof(ContactRow) == 24 && sizeof(ContactCandidate) == 24);
static_assert(sizeof(ContactTerm) == 16 && sizeof(shaders::Group) == 80);
static_assert(sizeof(ContactPush) == 18 * sizeof(double));
static_assert(sizeof(ContactSliding) == 48 * sizeof(double));
static_assert(sizeof(Vec3) == 3 * sizeof(double));

constexpr std::uint32_t none = 0xFFFFFFFF;

shaders::Group on_device(const ContactGroup& group) {
  namespace flags = shaders::group_flags;
  shaders::Group entry{
      group.thickness, group.thickness + group.range, group.range, group.damping_time,
      group.friction,  group.friction_speed,          {},          group.limit};
  std::copy_n(group.spin.data(), 3, entry.spin);
  entry.flags = (group.edges ? flags::edges : 0) | (group.samples ? flags::samples : 0) |
                (group.obstacle ? flags::obstacle : 0);
  return entry;
}

// The lengths of the lists of contributions and of terms, and the first candidate that touches.
using NarrowPhaseLists = std::array<shaders::List, 3>;

}  // namespace

struct ComputeNarrowPhase::Implementation {
  GlContext& context;
  const GlFunctions& gl = context.functions();
  // Mesa's software rasterisers round like the CPU.
  bool rounds_like_the_cpu = context.backend() != GlBackend::hardware;
  GLint group_limit = 0;
  GlBuffer candidates{gl}, rows{gl}, groups{gl}, points{gl}, lists{gl}, terms{gl};
  GlBuffer contributions{gl}, pushes{gl}, slidings{gl};
  ComputeProgram find_terms{gl, shaders::find_terms(rounds_like_the_cpu)};
  ComputeProgram apply_law{gl, shaders::apply_law(rounds_like_the_cpu)};
  std::size_t row_count = 0;
  // Numbers of items for which the lists have memory.
  std::size_t contribution_capacity = 0, term_capacity = 0;
  int reruns = 0;
  // The result of the latest evaluation.
  GlReadback copied_terms{gl}, copied_pushes{gl}, copied_slidings{gl};
  ContactResult result;
  std::vector<std::uint32_t> order, next_of_row;

  explicit Implementation(GlContext& gl_context) : context(gl_context) {
    gl.GetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 0, &group_limit);
  }
  void upload(std::span<const ContactGroup> of_rows, std::span<const Vec3> positions,
              std::span<const Vec3> velocities);
  void reserve(std::size_t contribution_count, std::size_t term_count, bool with_friction);
  void dispatch(std::size_t items);
  NarrowPhaseLists find();
  void apply(std::size_t count, std::size_t point_count);
  void copy_results(std::size_t count, bool with_friction);
  void sort_by_row();
};

void ComputeNarrowPhase::Implementation::upload(std::span<const ContactGroup> of_rows,
                                                std::span<const Vec3> positions,
                                                std::span<const Vec3> velocities) {
  std::vector<shaders::Group> table;
  std::ranges::transform(of_rows, std::back_inserter(table), on_device);
  groups.reserve(table.size() * sizeof(shaders::Group), "groups of candidates");
  groups.write(std::span<const shaders::Group>(table));
  points.reserve(2 * positions.size_bytes(), "positions and velocities");
  points.write(positions);
  points.write(velocities, positions.size_bytes());
}

void ComputeNarrowPhase::Implementation::reserve(std::size_t contribution_count,
                                                 std::size_t term_count, bool with_friction) {
  // A list that gets no memory keeps its capacity.
  const std::size_t contribution_room =
      grown_capacity(gl, contribution_capacity, contribution_count, sizeof(shaders::Contribution));
  contributions.reserve(contribution_room * sizeof(shaders::Contribution),
                        "features around samples");
  contribution_capacity = contribution_room;
  const std::size_t term_room = grown_capacity(
      gl, term_capacity, term_count, with_friction ? sizeof(ContactSliding) : sizeof(ContactPush));
  terms.reserve(term_room * sizeof(ContactTerm), "terms of contact");
  pushes.reserve(term_room * sizeof(ContactPush), "pushes of contact");
  if (with_friction) slidings.reserve(term_room * sizeof(ContactSliding), "friction of contact");
  term_capacity = term_room;
}

void ComputeNarrowPhase::Implementation::dispatch(std::size_t items) {
  const std::size_t work_groups = (items + shaders::group_size - 1) / shaders::group_size;
  gl.DispatchCompute(static_cast<GLuint>(std::min<std::size_t>(work_groups, group_limit)), 1, 1);
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

// Decides what is in reach. Returns the numbers of items, including those beyond the capacities.
NarrowPhaseLists ComputeNarrowPhase::Implementation::find() {
  NarrowPhaseLists filled{};
  filled[2].length = none;
  lists.write(std::span<const shaders::List>(filled));
  candidates.bind(0);
  rows.bind(1);
  groups.bind(2);
  points.bind(3);
  lists.bind(4);
  terms.bind(5);
  contributions.bind(6);
  find_terms.use();
  find_terms.set("row_count", static_cast<GLuint>(row_count));
  find_terms.set("term_capacity", static_cast<GLuint>(term_capacity));
  find_terms.set("contribution_capacity", static_cast<GLuint>(contribution_capacity));
  dispatch(row_count);
  lists.read(std::span<shaders::List>(filled));
  check_gl(gl, "find the terms of contact");
  return filled;
}

void ComputeNarrowPhase::Implementation::apply(std::size_t count, std::size_t point_count) {
  pushes.bind(6);
  slidings.bind(7);
  apply_law.use();
  apply_law.set("term_capacity", static_cast<GLuint>(term_capacity));
  apply_law.set("point_count", static_cast<GLuint>(point_count));
  dispatch(count);
}

void ComputeNarrowPhase::Implementation::copy_results(std::size_t count, bool with_friction) {
  result.terms = copied_terms.copy<ContactTerm>(terms, count, "terms of contact");
  result.pushes = copied_pushes.copy<ContactPush>(pushes, count, "pushes of contact");
  result.slidings = copied_slidings.copy<ContactSliding>(slidings, with_friction ? count : 0,
                                                         "friction of contact");
  gl.Finish();
  check_gl(gl, "apply the law of contact");
}

// Finds the order. The terms of a row lie one after another, in their final order.
void ComputeNarrowPhase::Implementation::sort_by_row() {
  std::vector<std::uint32_t>& next = next_of_row;
  next.assign(row_count + 1, 0);
  for (const ContactTerm& term : result.terms) ++next[term.row + 1];
  for (std::size_t row = 0; row < row_count; ++row) next[row + 1] += next[row];
  order.resize(result.terms.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[next[result.terms[i].row]++] = i;
  result.order = order;
}

ComputeNarrowPhase::ComputeNarrowPhase(GlContext& context) {
  context.make_current();
  implementation_ = std::make_unique<Implementation>(context);
}

ComputeNarrowPhase::~ComputeNarrowPhase() { implementation_->context.make_current(); }

void ComputeNarrowPhase::set_candidates(std::span<const ContactRow> rows,
                                        std::span<const ContactCandidate> candidates) {
  Implementation& device = *implementation_;
  device.context.make_current();
  assert(rows.empty() || rows.front().first == 0);
  device.row_count = rows.size();
  device.candidates.reserve(candidates.size_bytes(), "candidates of contact");
  device.candidates.write(candidates);
  // The row after the last one ends it.
  const ContactRow end{.first = static_cast<std::uint32_t>(candidates.size())};
  device.rows.reserve(rows.size_bytes() + sizeof(ContactRow), "rows of candidates");
  device.rows.write(rows);
  device.rows.write(std::span(&end, 1), rows.size_bytes());
}

ContactResult ComputeNarrowPhase::evaluate(std::span<const ContactGroup> groups,
                                           std::span<const Vec3> positions,
                                           std::span<const Vec3> velocities) {
  assert(positions.size() == velocities.size());
  Implementation& device = *implementation_;
  device.context.make_current();
  device.upload(groups, positions, velocities);
  device.lists.reserve(sizeof(NarrowPhaseLists), "lengths of lists");
  const bool with_friction =
      std::ranges::any_of(groups, [](const ContactGroup& group) { return group.friction > 0; });
  constexpr std::size_t first_capacity = 1024;
  device.reserve(first_capacity, first_capacity, with_friction);
  NarrowPhaseLists filled = device.find();
  // Samples without room for their contributions count no terms, so that a second repetition may be
  // needed.
  while (filled[0].length > device.contribution_capacity ||
         filled[1].length > device.term_capacity) {
    ++device.reruns;
    device.reserve(filled[0].length, filled[1].length, with_friction);
    filled = device.find();
  }
  const std::size_t count = filled[1].length;
  if (count > 0) device.apply(count, positions.size());
  device.copy_results(count, with_friction);
  device.sort_by_row();
  device.result.touching = std::nullopt;
  if (filled[2].length != none) device.result.touching = filled[2].length;
  return device.result;
}

int ComputeNarrowPhase::reruns() const { return implementation_->reruns; }

}  // namespace weft::gpu
