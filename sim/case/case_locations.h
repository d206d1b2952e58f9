// Maps the keys and values of a case to their places in its text.
#pragma once

#include <map>
#include <string>

#include "sim/case/case.h"

namespace weft::sim {

// Places of keys and values, by path (case_schema.h). The reader adds them. Checks that compare
// values use them in their messages.
class Locations {
 public:
  // `file` is the case file. A path without any place is reported as its first character.
  explicit Locations(std::string file) : file_(std::move(file)) {}

  void add(const std::string& path, const SourceLocation& key, const SourceLocation& value) {
    places_.insert_or_assign(path, Place{key, value});
  }
  // True if the text or an override gives this path a value.
  bool given(const std::string& path) const { return places_.contains(path); }
  // Return the place of the key or of the value. The place of a table is its header. Without a
  // place of its own, a path has the place of the nearest table around it.
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
