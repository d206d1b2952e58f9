#include "sim/case/static_checks.h"

#include "sim/case/case_error.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_text.h"
#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

class StaticChecker {
 public:
  StaticChecker(const Case& target, const Locations& locations)
      : case_(target), locations_(locations) {}

  void check() const {
    if (!traits_of(case_.time.method).finds_equilibria()) return refuse_table();
    if (case_.equilibria.loading == Loading::in_time) return;
    Case copy = case_;  // describe() needs a case that it could change
    refuse_varying(describe(copy), "");
    if (case_.equilibria.loading != Loading::arc_length) return;
    refuse_motions();
    refuse_closing_seams();
    require_load();
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& message,
                         const std::string& hint) const {
    throw CaseError(locations_.value(path), message, hint);
  }

  // Refuses keys of [static] if the method does not find equilibria.
  void refuse_table() const {
    Case copy = case_;
    for (const std::string& key : describe(copy.equilibria).keys()) {
      const std::string path = join_path("static", key);
      if (!locations_.given(path)) continue;
      fail(path,
           in_quotes(key) +
               " does not go with time.method = " + in_quotes(traits_of(case_.time.method).name),
           "expected time.method = \"static\", or no [static]");
    }
  }

  // Refuses values that vary in time, because proportional and arc-length loading do not follow
  // them.
  void refuse_varying(const Table& table, const std::string& path) const {
    for (const Field& field : table.fields) {
      const std::string place = join_path(path, field.key);
      if (const auto* member = std::get_if<TableMember>(&field.member)) {
        if (member->present()) refuse_varying(member->open(), place);
      } else if (const auto* list = std::get_if<TableList>(&field.member)) {
        for (std::size_t i = 0; i < list->size(); ++i) {
          const Table entry = list->at(i);
          refuse_varying(entry, list->named ? join_path(place, *entry.name) : join_path(place, i));
        }
      } else if (varies(field)) {
        refuse_in_loading(place, in_quotes(field.key) + " varies in time", "a constant");
      }
    }
  }
  [[noreturn]] void refuse_in_loading(const std::string& place, const std::string& what,
                                      const std::string& instead) const {
    const bool is_path = case_.equilibria.loading == Loading::arc_length;
    fail(place,
         what + ", which static.loading = " + (is_path ? "\"arc_length\"" : "\"proportional\"") +
             " does not follow",
         "expected " + instead +
             ", static.loading = \"in_time\", or a method that follows the motion in time");
  }

  void refuse_motions() const {
    for (std::size_t i = 0; i < case_.body.size(); ++i) {
      for (std::size_t j = 0; j < case_.body[i].pin.size(); ++j) {
        if (!case_.body[i].pin[j].motion) continue;
        const std::string pin = join_path(join_path(join_path("body", i), "pin"), j);
        refuse_in_loading(join_path(pin, "motion"), "the pin moves in time", "a pin at rest");
      }
    }
    for (std::size_t i = 0; i < case_.obstacle.size(); ++i) {
      if (!case_.obstacle[i].motion) continue;
      refuse_in_loading(join_path(join_path("obstacle", i), "motion"), "the obstacle moves in time",
                        "an obstacle at rest");
    }
  }

  void refuse_closing_seams() const {
    for (std::size_t i = 0; i < case_.seam.size(); ++i) {
      if (case_.seam[i].closing_time == 0) continue;
      refuse_in_loading(join_path(join_path("seam", i), "closing_time"), "the seam closes in time",
                        "edges that meet at the start");
    }
  }

  void require_load() const {
    if (case_.equilibria.scale_gravity && !case_.world.gravity.is_zero()) return;
    if (!case_.load.empty()) return;
    fail("static.loading", "\"arc_length\" without a load to scale",
         "expected a [[load]], or static.scale_gravity = true with gravity");
  }

  const Case& case_;
  const Locations& locations_;
};

}  // namespace

void check_static(const Case& target, const Locations& locations) {
  StaticChecker(target, locations).check();
}

}  // namespace weft::sim
