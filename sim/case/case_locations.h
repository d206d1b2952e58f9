// The places in the text of a case from which its keys and values came.
#pragma once

#include <map>
#include <string>

#include "sim/case/case.h"

namespace weft::sim {

// Places by path (case_schema.h), which the reader fills in, for messages of the rules that compare
// values.
class Locations {
 public:
  // A place that is nowhere in the text is reported as the first character of `file`.
  explicit Locations(std::string file) : file_(std::move(file)) {}

  void add(const std::string& path, const SourceLocation& key, const SourceLocation& value) {
    places_.insert_or_assign(path, Place{key, value});
  }
  // True if the case gives this path, rather than leaving it to a default.
  bool given(const std::string& path) const { return places_.contains(path); }
  // Return the place of the key or of the value (for a table: its header). Where there is none,
  // they return those of the nearest table around it.
  SourceLocation key(const std::string& path) const;
  SourceLocation value(const std::string& path) const;

 private:
  struct Place {
    SourceLocation key;
    SourceLocation value;
  };
  const Place* nearest(std::string path) const;

  std::string file_;
  std::map<std::string, Place> places_;
};

}  // namespace weft::sim
