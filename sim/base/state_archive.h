// Saved states as bytes. A simulation restored from them continues with the same bits as the
// simulation that saved them.
#pragma once

#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "sim/base/vectors.h"

namespace weft::sim {

// Writes values to bytes, or reads them back in the same order. The same calls serve both
// directions. The bytes have this machine's format. Reading throws std::invalid_argument if bytes
// are missing.
class StateArchive {
 public:
  StateArchive() = default;  // makes an archive that writes
  explicit StateArchive(std::string_view bytes)
      : reads_(true), left_(bytes) {}  // makes an archive that reads, without copying the bytes

  bool reads() const { return reads_; }
  template <class... Values>
  void operator()(Values&... values) {
    (transfer(values), ...);
  }
  const std::string& bytes() const { return bytes_; }
  // Precondition: reads().
  bool is_at_end() const { return left_.empty(); }

 private:
  void transfer_bytes(void* data, std::size_t size) {
    if (size == 0) return;
    if (!reads_) {
      bytes_.append(static_cast<const char*>(data), size);
      return;
    }
    if (left_.size() < size) throw std::invalid_argument("a saved state that has been cut short");
    std::memcpy(data, left_.data(), size);
    left_.remove_prefix(size);
  }
  template <class Value>
  void transfer(Value& value) {
    static_assert(std::is_trivially_copyable_v<Value> && !std::is_pointer_v<Value>);
    transfer_bytes(&value, sizeof value);
  }
  void transfer(bool& value) {
    auto byte = static_cast<unsigned char>(value);
    transfer_bytes(&byte, 1);
    if (byte > 1) throw std::invalid_argument("a saved state with neither true nor false");
    value = byte != 0;
  }
  void transfer(Vec3& value) { transfer_bytes(value.data(), sizeof value); }
  template <class Value>
  void transfer(std::vector<Value>& values) {
    std::size_t count = values.size();
    transfer(count);
    if (reads_ && count > left_.size())
      throw std::invalid_argument("a saved state that has been cut short");
    if (reads_) values.resize(count);
    for (Value& value : values) transfer(value);
  }
  void transfer(std::string& text) {
    std::size_t count = text.size();
    transfer(count);
    if (reads_ && count > left_.size())
      throw std::invalid_argument("a saved state that has been cut short");
    if (reads_) text.resize(count);
    transfer_bytes(text.data(), count);
  }
  template <class Value>
  void transfer(std::optional<Value>& value) {
    bool is_there = value.has_value();
    transfer(is_there);
    if (!is_there) return value.reset();
    if (reads_) value.emplace();
    transfer(*value);
  }

  bool reads_ = false;
  std::string bytes_;
  std::string_view left_;
};

}  // namespace weft::sim
