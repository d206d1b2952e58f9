// The places of a case's keys and values in its text.
#pragma once

#include <map>
#include <string>

#include "sim/case/case.h"

namespace weft::sim {

// Places of keys and values by path (case_schema.h). The reader fills them in; the rules that
// compare values need them for their messages.
class Locations {
 public:
  // A path without any place is reported as the first character of `file`.
  explicit Locations(std::string file) : file_(std::move(file)) {}

  void add(const std::string& path, const SourceLocation& key, const SourceLocation& value) {
    places_.insert_or_assign(path, Place{key, value});
  }
  // True if the text or an override gives this path a value.
  bool given(const std::string& path) const { return places_.contains(path); }
  // Return the place of the key or of the value; the value of a table is its header. For a path
  // without a place they return the place of the nearest table around it.
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
