// Fingerprints of data: 64-bit FNV-1a hashes, which tell changed data from unchanged data. They are
// no protection against data made to deceive. Source: G. Fowler, L. C. Noll, K.-P. Vo, D. Eastlake,
// The FNV Non-Cryptographic Hash Algorithm (RFC 9923).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace weft::sim {

class Fingerprint {
 public:
  void add(std::string_view bytes) {
    for (const char byte : bytes) {
      value_ ^= static_cast<unsigned char>(byte);
      value_ *= 0x100000001b3U;
    }
  }
  // Adds the bytes of a list of numbers or vectors.
  void add_list(const auto& list) {
    add({reinterpret_cast<const char*>(list.data()), list.size() * sizeof(*list.data())});
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

}  // namespace weft::sim
