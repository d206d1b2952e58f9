// Maps the keys and values of a case to their places in its text.
#pragma once

#include <map>
#include <string>

#include "sim/case/case.h"

namespace weft::sim {

// Places of keys and values in the text of a case, by path (see join_path() in case_schema.h).
class Locations {
 public:
  // `file` is the path of the case file. Its first character is the place of every path for which
  // neither the path nor a table or array around it has been added.
  explicit Locations(std::string file) : file_(std::move(file)) {}

  void add(const std::string& path, const SourceLocation& key, const SourceLocation& value) {
    places_.insert_or_assign(path, Place{key, value});
  }
  // True if the place of this path has been added: the text, an override or a preset gives it a
  // value.
  bool given(const std::string& path) const { return places_.contains(path); }
  // Return the place of the key or of the value at a path. The place of a table is its header. A
  // path that has not been added has the place of the nearest table or array around it.
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
