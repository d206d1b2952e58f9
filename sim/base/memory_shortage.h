// Lists that would take more memory than a case allows. Private to sim/.
#pragma once

#include <new>
#include <string>
#include <utility>

namespace weft::sim {

// Thrown instead of std::bad_alloc, of which it is a kind, while there is memory left to say why.
class MemoryShortage : public std::bad_alloc {
 public:
  // `body_a` and `body_b` are the bodies of the scene that the lists belong to.
  MemoryShortage(std::string what, int body_a, int body_b)
      : body_a(body_a), body_b(body_b), what_(std::move(what)) {}
  const char* what() const noexcept override { return what_.c_str(); }

  int body_a, body_b;

 private:
  std::string what_;
};

}  // namespace weft::sim
