// Reads images of positions from HDF5 files, for shapes.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <span>

#include "sim/base/file_error.h"
#include "sim/base/hdf5_handle.h"
#include "sim/base/reading_process.h"
#include "sim/case/case_text.h"
#include "sim/case/memory_estimate.h"
#include "sim/scene/texel_file.h"

namespace weft::sim {
namespace {

using hdf5::Access;
using hdf5::Handle;

// A pipe whose ends are each closed exactly once.
class Pipe {
 public:
  Pipe() {
    if (pipe2(ends_.data(), O_CLOEXEC) != 0) {
      throw FileError(std::string("cannot make a pipe: ") + std::strerror(errno));
    }
  }
  ~Pipe() {
    for (int end : {0, 1}) close_end(end);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  int reading() const { return ends_[0]; }
  int writing() const { return ends_[1]; }
  void close_writing() { close_end(1); }

 private:
  void close_end(int end) {
    if (ends_[end] >= 0) close(ends_[end]);
    ends_[end] = -1;
  }
  std::array<int, 2> ends_{-1, -1};
};

// Writes `size` bytes. Returns false if an error occurs.
bool send(int pipe, const void* data, std::size_t size) {
  const auto* bytes = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t count = write(pipe, bytes, size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

// Reads `size` bytes. Returns false if fewer arrive.
bool receive(int pipe, void* data, std::size_t size) {
  auto* bytes = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t count = read(pipe, bytes, size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

// The first bytes in the pipe: the size of the image, and the length of the error message that
// follows. A length of zero means that there was no error.
struct Header {
  std::int64_t patches = 0, rows = 0, cols = 0;
  std::int64_t message = 0;
};

herr_t append_image(hid_t file, const char* name, const H5O_info_t* info, void* names) {
  if (info->type != H5O_TYPE_DATASET) return 0;
  const Handle dataset(H5Dopen2(file, name, H5P_DEFAULT));
  const Handle space(H5Dget_space(dataset.get()));
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0) return 0;
  std::vector<hsize_t> shape(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space.get(), shape.data(), nullptr);
  if (hdf5::is_image(shape))
    static_cast<std::vector<std::string>*>(names)->push_back('/' + std::string(name));
  return 0;
}

// The shape of the dataset that is read: that of an image of positions, or a list [n, 3].
enum class FileShape { image, list };

constexpr hsize_t most_points = hsize_t{1} << 30;

bool is_list(const std::vector<hsize_t>& shape) { return shape.size() == 2 && shape[1] == 3; }

// Returns the message for a missing dataset. For an image, the message suggests the image of the
// file with the nearest name, or lists all images.
std::string describe_missing(hid_t file, const std::string& dataset, FileShape kind) {
  if (kind == FileShape::list) return "has no dataset " + in_quotes(dataset);
  std::vector<std::string> images;
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, append_image, &images, H5O_INFO_BASIC);
  const std::string message = "has no dataset " + in_quotes(dataset);
  if (images.empty()) return message + ", nor any image of [rows, cols, 3] numbers";
  return message + "; " + name_hint(dataset, images);
}

// True if the first axis of a dataset counts the frames of a run.
bool has_frames(hid_t file, hid_t dataset) {
  if (H5Aexists(file, "weft_version") <= 0) return false;
  const Handle space(H5Dget_space(dataset));
  std::vector<hsize_t> most(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space.get())));
  H5Sget_simple_extent_dims(space.get(), nullptr, most.data());
  return most.front() == H5S_UNLIMITED;
}

TexelFile read_here(const std::string& path, const std::string& dataset, FileShape kind,
                    double most_bytes) {
  const hdf5::QuietErrors quiet;
  const Access access(path);
  const Handle file = access.open_for_reading();
  const Handle source(H5Dopen2(file.get(), dataset.c_str(), hdf5::own_datasets()));
  if (source.get() < 0) access.reject(describe_missing(file.get(), dataset, kind));
  const std::vector<hsize_t> shape = access.dimensions(source.get());
  const bool has_shape = kind == FileShape::list ? is_list(shape) : hdf5::is_image(shape);
  if (!has_shape || !hdf5::holds_numbers(source.get())) {
    access.reject(
        "dataset " + dataset + " must be numbers shaped " +
        (kind == FileShape::list ? "[n, 3]" : "[rows, cols, 3] or [patches, rows, cols, 3]"));
  }
  if (kind == FileShape::list && (shape[0] == 0 || shape[0] > most_points)) {
    access.reject("dataset " + dataset + " holds " + std::to_string(shape[0]) +
                  " points; expected 1 to " + std::to_string(most_points));
  }
  if (shape.size() == 4 && shape[0] > 1 && has_frames(file.get(), source.get())) {
    access.reject(
        "dataset " + dataset + " has the " + std::to_string(shape[0]) +
        " frames of a run; expected a run with one frame (output.frame_times), or a start "
        "from a frame (--restart-from)");
  }
  const hsize_t count = hdf5::count_of(shape);
  access.require_stored(source.get(), dataset, static_cast<double>(count));
  const double needed = static_cast<double>(count) * sizeof(double);
  if (needed > most_bytes) {
    access.reject("dataset " + dataset + " takes " + memory_text(needed) +
                  " of memory, more than the limit of " + memory_text(most_bytes));
  }
  TexelFile result;
  result.texels.resize(count / 3);
  static_assert(sizeof(Vec3) == 3 * sizeof(double), "texels are read as numbers");
  access.check(
      H5Dread(source.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, result.texels.data()),
      "read dataset " + dataset);
  // is_image() and most_points bound the product of these sizes.
  result.patches = shape.size() == 4 ? static_cast<int>(shape[0]) : 1;
  result.rows = kind == FileShape::list ? 1 : static_cast<int>(shape[shape.size() - 3]);
  result.cols = static_cast<int>(shape[shape.size() - 2]);
  return result;
}

int send_texels(int pipe, const std::string& path, const std::string& dataset, FileShape kind,
                double most_bytes) {
  TexelFile file;
  std::string message;
  try {
    file = read_here(path, dataset, kind, most_bytes);
  } catch (const FileError& error) {
    message = error.what();
  } catch (const std::bad_alloc&) {
    message = path + ": dataset " + dataset + " needs more memory than there is";
  }
  const Header header{file.patches, file.rows, file.cols,
                      static_cast<std::int64_t>(message.size())};
  send(pipe, &header, sizeof header);
  send(pipe, message.data(), message.size());
  send(pipe, file.texels.data(), file.texels.size() * sizeof(Vec3));
  return 0;
}

TexelFile read_in_process(const std::string& path, const std::string& dataset, FileShape kind,
                          double most_bytes) {
  TexelFile result;
  std::string message;
  bool whole = false;
  Pipe pipe;
  const auto work = [&] { return send_texels(pipe.writing(), path, dataset, kind, most_bytes); };
  const auto meanwhile = [&] {
    pipe.close_writing();
    Header header;
    if (!receive(pipe.reading(), &header, sizeof header)) return;
    message.resize(static_cast<std::size_t>(header.message));
    result.patches = static_cast<int>(header.patches);
    result.rows = static_cast<int>(header.rows);
    result.cols = static_cast<int>(header.cols);
    result.texels.resize(static_cast<std::size_t>(header.patches * header.rows * header.cols));
    whole = receive(pipe.reading(), message.data(), message.size()) &&
            receive(pipe.reading(), result.texels.data(), result.texels.size() * sizeof(Vec3));
  };
  const ProcessEnd end = run_in_process(work, meanwhile, reading_cpu_limit);
  if (end.signal != 0) throw FileError(describe_crash(path, end.signal));
  if (!message.empty()) throw FileError(message);
  if (!whole) throw FileError(path + ": cannot be read: the process that reads it ended");
  return result;
}

}  // namespace

TexelFile read_texels_unguarded(const std::string& path, const std::string& dataset,
                                double most_bytes) {
  return read_here(path, dataset, FileShape::image, most_bytes);
}

TexelFile read_texels(const std::string& path, const std::string& dataset, double most_bytes) {
  return read_in_process(path, dataset, FileShape::image, most_bytes);
}

TexelFile read_points(const std::string& path, const std::string& dataset, double most_bytes) {
  return read_in_process(path, dataset, FileShape::list, most_bytes);
}

}  // namespace weft::sim
