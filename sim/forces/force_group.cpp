#include "sim/forces/force_group.h"

#include <algorithm>

namespace weft::sim {

namespace {

class ForceGroup final : public Force {
 public:
  explicit ForceGroup(std::vector<std::unique_ptr<Force>> members) : members_(std::move(members)) {}

  std::string_view name() const override { return members_.front()->name(); }
  bool is_membrane() const override { return members_.front()->is_membrane(); }
  bool has_damping() const override { return any_of(&Force::has_damping); }
  bool varies() const override { return any_of(&Force::varies); }
  void set_time(const Instant& now) override {
    for (const auto& each : members_) {
      if (each->varies()) each->set_time(now);
    }
  }
  double evaluation_work() const override {
    double most = 0;
    for (const auto& each : members_) most = std::max(most, each->evaluation_work());
    return most;
  }
  double energy(const Kinematics& state, int threads) override {
    double sum = 0;
    for (const auto& each : members_) sum += each->energy(state, threads);
    return sum;
  }
  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    for (const auto& each : members_) each->add_forces(state, force, threads);
  }
  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    for (const auto& each : members_) each->add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override {
    for (const auto& each : members_) each->attach(pattern);
  }
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) override {
    for (const auto& each : members_) each->add_derivatives(state, into, definiteness, threads);
  }

 private:
  bool any_of(bool (Force::*property)() const) const {
    return std::ranges::any_of(members_,
                               [&](const auto& each) { return (each.get()->*property)(); });
  }

  std::vector<std::unique_ptr<Force>> members_;
};

}  // namespace

std::unique_ptr<Force> grouped(std::vector<std::unique_ptr<Force>> members) {
  std::erase(members, nullptr);
  if (members.empty()) return nullptr;
  if (members.size() == 1) return std::move(members.front());
  return std::make_unique<ForceGroup>(std::move(members));
}

}  // namespace weft::sim
