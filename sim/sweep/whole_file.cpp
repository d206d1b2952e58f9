#include "sim/sweep/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "sim/base/file_error.h"

namespace weft::sim {

namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const char* what, int error) {
  throw FileError(path.string() + ": " + what + ": " + std::strerror(error));
}

class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags)
      : number_(open(path.c_str(), flags | O_CLOEXEC, 0644)) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

// Writes all bytes. Returns false if the system cannot.
bool write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = write(file, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

}  // namespace

std::string process_name() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  return std::string(host.data()) + '_' + std::to_string(getpid());
}

void write_whole_file(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::path aside = path;
  aside += '.' + process_name() + ".tmp";
  {
    const Descriptor file(aside, O_WRONLY | O_CREAT | O_TRUNC);
    if (file.number() < 0) fail(path, "cannot be written", errno);
    if (!write_all(file.number(), text) || fdatasync(file.number()) != 0) {
      const int error = errno;
      unlink(aside.c_str());
      fail(path, "cannot be written", error);
    }
  }
  if (std::rename(aside.c_str(), path.c_str()) != 0) {
    const int error = errno;
    unlink(aside.c_str());
    fail(path, "cannot be written", error);
  }
}

void write_file(const std::filesystem::path& path, const std::string& text) {
  const Descriptor file(path, O_WRONLY | O_CREAT | O_TRUNC);
  if (file.number() < 0 || !write_all(file.number(), text)) fail(path, "cannot be written", errno);
}

void flush_file(const std::filesystem::path& path) {
  const Descriptor file(path, O_RDONLY);
  if (file.number() < 0 || fdatasync(file.number()) != 0) fail(path, "cannot be written", errno);
}

std::optional<std::string> read_whole_file(const std::filesystem::path& path) {
  const Descriptor file(path, O_RDONLY | O_NONBLOCK);  // which does not wait for a writer of a pipe
  if (file.number() < 0) {
    if (errno == ENOENT || errno == ENOTDIR) return std::nullopt;
    fail(path, "cannot be read", errno);
  }
  struct stat status {};
  if (fstat(file.number(), &status) == 0 && !S_ISREG(status.st_mode))
    throw FileError(path.string() + ": is not a regular file");
  std::string text;
  std::array<char, 65536> part{};
  while (true) {
    const ssize_t count = read(file.number(), part.data(), part.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(path, "cannot be read", errno);
    if (count == 0) return text;
    text.append(part.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace weft::sim
