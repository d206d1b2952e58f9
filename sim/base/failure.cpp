#include "sim/base/failure.h"

namespace weft::sim {

const char* kind_name(Failure::Kind kind) {
  using Kind = Failure::Kind;
  switch (kind) {
    case Kind::error_tolerance:
      return "error_tolerance";
    case Kind::newton:
      return "newton";
    case Kind::surfaces:
      return "surfaces";
    case Kind::not_finite:
      return "not_finite";
    case Kind::unstable:
      return "unstable";
    case Kind::too_many_cuts:
      return "too_many_cuts";
    case Kind::strain_limit:
      return "strain_limit";
    case Kind::prescribed_motion:
      return "prescribed_motion";
    case Kind::energy:
      return "energy";
    case Kind::cpu_limit:
      return "cpu_limit";
    case Kind::interrupted:
      return "interrupted";
    case Kind::solver:
      return "solver";
  }
  return "";
}

}  // namespace weft::sim
