// Cases that must be refused, with their messages.
#pragma once

#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <vector>

#include "sim/case/case_reader.h"

namespace weft::sim {

struct BadCase {
  std::string name;
  std::string text;
  std::string what;  // the whole message: place, reason and hint
  std::vector<std::string> overrides = {};
};

inline std::ostream& operator<<(std::ostream& stream, const BadCase& bad) {
  return stream << bad.name;
}

inline std::string bad_case_name(const testing::TestParamInfo<BadCase>& info) {
  return info.param.name;
}

inline void expect_refused(const BadCase& bad) {
  try {
    parse_case(bad.text, "case.toml", bad.overrides);
    FAIL() << "accepted:\n" << bad.text;
  } catch (const CaseError& error) {
    EXPECT_EQ(error.what(), bad.what);
  }
}

// A valid body: 5 rows and 9 columns of vertices.
inline const std::string sheet = R"([[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [5, 9] }
)";

}  // namespace weft::sim
