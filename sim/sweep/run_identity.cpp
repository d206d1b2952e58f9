#include "sim/sweep/run_identity.h"

#include <openssl/evp.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>

#include "sim/base/file_error.h"
#include "sim/case/case_writer.h"
#include "sim/run/input_files.h"
#include "sim/run/numerics_version.h"
#include "sim/run/run_checkpoint.h"

namespace weft::sim {

namespace {

namespace fs = std::filesystem;

// A SHA-256 that takes its bytes in parts.
class Digest {
 public:
  Digest() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    check(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
  }
  void add(std::string_view bytes) {
    check(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) == 1);
  }
  std::string text() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
    unsigned size = 0;
    check(EVP_DigestFinal_ex(context_.get(), bytes.data(), &size) == 1);
    constexpr const char* digits = "0123456789abcdef";
    std::string text;
    for (unsigned i = 0; i < size; ++i) {
      text += digits[bytes[i] / 16];
      text += digits[bytes[i] % 16];
    }
    return text;
  }

 private:
  static void check(bool success) {
    if (!success) throw std::runtime_error("OpenSSL cannot compute a SHA-256");
  }
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

fs::path place_of(const Case& source, const std::string& path) {
  return fs::path(source.path).parent_path() / path;
}

}  // namespace

std::string sha256(std::string_view bytes) {
  Digest digest;
  digest.add(bytes);
  return digest.text();
}

std::string RunHasher::hash(const Case& source, bool estimates_error) {
  Case copy = source;
  copy.outputs.clear();
  copy.compute.threads.reset();
  copy.compute.backend = ComputeBackend::automatic;
  // Writing a case takes as long as reading it, so it is not written again if nothing was left out.
  const bool is_whole = source.outputs.empty() && !source.compute.threads &&
                        source.compute.backend == ComputeBackend::automatic;
  std::string inputs = "weft numerics " + std::to_string(numerics_version) + '\n' +
                       (is_whole ? source.resolved_text : case_text(copy));
  if (estimates_error) inputs += "error estimate\n";
  for_each_input_file(copy, [&](std::string& path) {
    inputs += "file " + digest_of_file(place_of(source, path).string()) + '\n';
  });
  if (copy.restart) {
    const std::string checkpoint = checkpoint_path(place_of(source, copy.restart->path).string());
    if (fs::exists(checkpoint)) inputs += "checkpoint " + digest_of_file(checkpoint) + '\n';
  }
  return sha256(inputs);
}

const std::string& RunHasher::digest_of_file(const std::string& path) {
  const auto known = digests_.find(path);
  if (known != digests_.end()) return known->second;
  // Opening a pipe would wait for its writer.
  if (fs::exists(path) && !fs::is_regular_file(path))
    throw FileError(path + ": is not a regular file");
  std::ifstream file(path, std::ios::binary);
  Digest digest;
  std::array<char, 65536> part{};
  while (file) {
    file.read(part.data(), part.size());
    digest.add({part.data(), static_cast<std::size_t>(file.gcount())});
  }
  if (!file.eof()) throw FileError(path + ": cannot be read: " + std::strerror(errno));
  return digests_.emplace(path, digest.text()).first->second;
}

std::string portable_case_text(const Case& source) {
  Case copy = source;
  bool has_files = false;
  for_each_input_file(copy, [&](std::string& path) {
    has_files = true;
    path = fs::absolute(place_of(source, path)).lexically_normal().string();
  });
  return has_files ? case_text(copy) : source.resolved_text;
}

}  // namespace weft::sim
