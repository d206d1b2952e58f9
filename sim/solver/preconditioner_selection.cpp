#include "sim/solver/preconditioner_selection.h"

namespace weft::sim {

namespace {

// Product of gamma and the highest frequency above which multigrid is faster than block-Jacobi
// (docs/decisions/0016).
constexpr double multigrid_break_even = 20;

// Number of iterations of block-Jacobi that cost as much as a solve with multigrid and new coarse
// matrices (docs/decisions/0079).
constexpr int most_block_jacobi_iterations = 60;

// Number of assemblies whose K rebuilds the coarse matrices after these have worn out within a
// solve. The assembly of that solve is the first of them.
constexpr int assemblies_to_rebuild = 10;

// Writes or reads the creases of a linearisation.
void transfer_creases(StateArchive& archive, CreaseHistory::Creases& creases) {
  std::size_t count = creases.size();
  archive(count);
  if (archive.reads()) creases.resize(count);
  for (materials::Crease& each : creases) archive(each.angles, each.curvature);
}

}  // namespace

PreconditionerSelection::PreconditionerSelection(Dynamics& dynamics, VelocityMatrix& matrix)
    : dynamics_(dynamics),
      matrix_(matrix),
      frequency_(dynamics),
      for_block_jacobi_(most_block_jacobi_iterations, dynamics.scene().source.time.preconditioner ==
                                                          PreconditionerChoice::automatic) {}

std::int64_t PreconditionerSelection::assembly() const {
  return dynamics_.statistics().counters.matrix_assemblies;
}

bool PreconditionerSelection::wants_multigrid() {
  switch (dynamics_.scene().source.time.preconditioner) {
    case PreconditionerChoice::block_jacobi:
      return false;
    case PreconditionerChoice::multigrid:
      return true;
    case PreconditionerChoice::automatic:
      break;
  }
  return matrix_.gamma() * highest_frequency() > multigrid_break_even ||
         for_block_jacobi_.take_hard_system(matrix_.gamma());
}

void PreconditionerSelection::make_multigrid() {
  if (multigrid_ == nullptr)
    multigrid_ = std::make_unique<Multigrid>(dynamics_.scene(), matrix_.pattern());
}

bool PreconditionerSelection::must_rebuild() const {
  return !is_set_up_ || age_.is_worn_out() ||
         (matrix_.has_contact() && !multigrid_->has_contact()) ||
         (assembly() != set_up_assembly_ && assembly() < rebuilt_until_);
}

void PreconditionerSelection::prepare() {
  set_ups_ = 0;
  may_leave_block_jacobi_ = true;
  if (wants_multigrid()) {
    make_multigrid();
    if (must_rebuild() ? rebuild_coarse_matrices() : multigrid_->update(matrix_)) {
      chosen_ = multigrid_.get();
      return;
    }
  }
  use_block_jacobi();
}

bool PreconditionerSelection::rebuild_coarse_matrices() {
  ++set_ups_;
  age_.reset();
  set_up_assembly_ = assembly();
  set_up_place_ = dynamics_.linearisation();
  set_up_gamma_ = matrix_.gamma();
  is_set_up_ = multigrid_->set_up(matrix_);
  return is_set_up_;
}

void PreconditionerSelection::use_block_jacobi() {
  chosen_ = &block_jacobi_;
  static_cast<void>(block_jacobi_.update(matrix_));  // block-Jacobi never fails
}

void PreconditionerSelection::give_up_multigrid() {
  may_leave_block_jacobi_ = false;
  is_set_up_ = false;
  use_block_jacobi();
}

bool PreconditionerSelection::rebuild_if_worn_out(int iterations, double residual) {
  if (!is_multigrid() && may_leave_block_jacobi_ && for_block_jacobi_.would_be_hard(iterations)) {
    may_leave_block_jacobi_ = false;
    for_block_jacobi_.record(matrix_.gamma(), iterations);
    make_multigrid();
    if (!rebuild_coarse_matrices()) return false;
    chosen_ = multigrid_.get();
    age_.start(iterations, residual);
    return true;
  }
  if (!is_multigrid() || !age_.is_worn_out_by(iterations, residual)) return false;
  age_.start(iterations, residual);
  rebuilt_until_ = assembly() + assemblies_to_rebuild;
  if (!rebuild_coarse_matrices()) use_block_jacobi();
  return true;
}

void PreconditionerSelection::finish_solve(int iterations, double residual) {
  if (is_multigrid()) {
    age_.finish(iterations, residual);
  } else {
    for_block_jacobi_.record(matrix_.gamma(), iterations);
  }
}

void PreconditionerSelection::transfer(StateArchive& archive) {
  Linearisation& place = set_up_place_;
  bool is_made = multigrid_ != nullptr;
  archive(is_made, is_set_up_, set_up_assembly_, rebuilt_until_, set_up_gamma_, place.time,
          place.step_start, place.state, place.definiteness, place.gamma, place.load,
          place.hardness);
  transfer_creases(archive, place.creases);
  sim::transfer(archive, place.anchors, dynamics_.scene());
  age_.transfer(archive);
  for_block_jacobi_.transfer(archive);
  frequency_.transfer(archive);
  if (!is_made) return;
  make_multigrid();
  multigrid_->transfer_patterns(archive);
  if (!is_set_up_) return;
  bool with_contact = multigrid_->has_contact();
  archive(with_contact);
  if (with_contact) is_set_up_ = multigrid_->transfer_finest(archive, matrix_);
  if (with_contact || !archive.reads()) return;
  dynamics_.assemble_again(place);
  matrix_.form(set_up_gamma_);
  is_set_up_ = multigrid_->set_up(matrix_);
  dynamics_.set_hardness(1);
}

}  // namespace weft::sim
