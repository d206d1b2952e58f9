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

// Returns the absolute path of a file that a case names, without ".." where it is the same file.
std::string place_of(const Case& source, const std::string& path) {
  const fs::path place = fs::absolute(fs::path(source.path).parent_path() / path);
  // Behind a link, "folder/.." is another folder than the one that holds the link.
  std::error_code absent;
  const fs::path normal = place.lexically_normal();
  const bool differs = fs::exists(place, absent) && !fs::equivalent(place, normal, absent);
  return differs ? place.string() : normal.string();
}

std::string digest_of_bytes(const std::string& path) {
  // Opening a pipe would wait for its writer.
  if (fs::exists(path) && !fs::is_regular_file(path))
    throw FileError(path + ": is not a regular file");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  Digest digest;
  std::array<char, 65536> part{};
  while (file) {
    file.read(part.data(), part.size());
    digest.add({part.data(), static_cast<std::size_t>(file.gcount())});
  }
  if (!file.eof()) throw FileError(path + ": cannot be read: " + std::strerror(errno));
  return digest.text();
}

bool is_same(const timespec& a, const timespec& b) {
  return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec;
}

// True if a file with these two states has not been written between them.
bool is_same_file(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino && a.st_size == b.st_size &&
         is_same(a.st_mtim, b.st_mtim) && is_same(a.st_ctim, b.st_ctim);
}

// Returns the absolute paths of the files that a case names, the run from which it starts last.
std::vector<std::string> file_paths(const Case& source) {
  Case copy = source;
  std::vector<std::string> paths;
  for_each_input_file(copy,
                      [&](const std::string& path) { paths.push_back(place_of(source, path)); });
  return paths;
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
  const std::vector<std::string> files = file_paths(source);
  for (const std::string& path : files) inputs += "file " + digest_of_file(path) + '\n';
  if (source.restart) {
    const std::string checkpoint = checkpoint_path(files.back());
    if (fs::exists(checkpoint)) {
      inputs += "checkpoint " + digest_of_file(checkpoint) + '\n';
    } else {
      digests_.emplace(checkpoint, "");
    }
  }
  return sha256(inputs);
}

const std::string& RunHasher::digest_of_file(const std::string& path) {
  const auto known = digests_.find(path);
  if (known != digests_.end()) return known->second;
  return digests_.emplace(path, digest_of_bytes(path)).first->second;
}

std::vector<std::string> input_paths(const Case& source) {
  std::vector<std::string> paths = file_paths(source);
  if (source.restart) paths.push_back(checkpoint_path(paths.back()));
  return paths;
}

InputCheck::Finding InputCheck::look_at(const std::vector<std::string>& paths) {
  Finding found;
  for (const std::string& path : paths) {
    Finding next = look_at_file(path);
    if (next.state == State::changed) return next;
    if (found.state == State::as_planned) found = std::move(next);
  }
  return found;
}

InputCheck::Finding InputCheck::look_at_file(const std::string& path) {
  const auto planned = planned_.find(path);
  if (planned == planned_.end()) return {};
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) {
    if (planned->second.empty() && errno == ENOENT) return {};
    return {State::unreadable, path + ": cannot be read: " + std::strerror(errno)};
  }
  try {
    if (digest_of(path, status) == planned->second) return {};
  } catch (const FileError& error) {
    return {State::unreadable, error.what()};
  }
  return {State::changed, path + " has changed since the sweep was planned; call weft sweep again"};
}

const std::string& InputCheck::digest_of(const std::string& path, const struct stat& status) {
  const auto known = known_.find(path);
  if (known != known_.end() && is_same_file(known->second.status, status))
    return known->second.digest;
  return known_.insert_or_assign(path, Known{status, digest_of_bytes(path)}).first->second.digest;
}

std::string portable_case_text(const Case& source) {
  Case copy = source;
  bool has_files = false;
  for_each_input_file(copy, [&](std::string& path) {
    has_files = true;
    path = place_of(source, path);
  });
  return has_files ? case_text(copy) : source.resolved_text;
}

}  // namespace weft::sim
