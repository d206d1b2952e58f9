// C++ additions to the HDF5 C API: handles that close themselves, checked return codes, and error
// texts. Private to sim/.
#pragma once

#include <hdf5.h>

#include <string>
#include <utility>
#include <vector>

namespace weft::sim::hdf5 {

// An open HDF5 object of any type, closed on destruction. Errors of closing are not reported, so
// data that matters must be flushed before.
class Handle {
 public:
  Handle() = default;
  explicit Handle(hid_t id) : id_(id) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() { close(); }

  void close() {
    if (id_ >= 0) H5Idec_ref(id_);
    id_ = H5I_INVALID_HID;
  }
  hid_t get() const { return id_; }

 private:
  hid_t id_ = H5I_INVALID_HID;
};

// Keeps HDF5 from printing its error stack on stderr while this object lives. Exceptions carry the
// text instead.
class QuietErrors {
 public:
  QuietErrors();
  ~QuietErrors();
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

// Operations on one file. Every operation throws FileError if HDF5 fails. The text names the path,
// the action and the message of HDF5.
class Access {
 public:
  explicit Access(std::string path) : path_(std::move(path)) {}
  const std::string& path() const { return path_; }

  // Returns `result`, or throws if it is negative, which is how HDF5 reports failure.
  template <typename Result>
  Result check(Result result, const std::string& action) const {
    if (result < 0) fail(action);
    return result;
  }
  Handle handle(hid_t id, const std::string& action) const { return Handle(check(id, action)); }
  [[noreturn]] void fail(const std::string& action) const;
  // Throws FileError with the path and a reason, for content that HDF5 can read but Weft does not
  // accept.
  [[noreturn]] void reject(const std::string& reason) const;

  // Write or read an attribute of an open object. Strings are UTF-8 and have variable length.
  void write_attribute(hid_t object, const std::string& name, const std::string& value) const;
  void write_attribute(hid_t object, const std::string& name, double value) const;
  void write_attribute(hid_t object, const std::string& name, const std::vector<int>& values) const;
  std::string read_string(hid_t object, const std::string& name) const;
  double read_double(hid_t object, const std::string& name) const;
  std::vector<int> read_integers(hid_t object, const std::string& name) const;

  // Opens the file read-only and without HDF5's locks, which some network file systems refuse.
  // Rejects anything but a regular file that this process may read.
  Handle open_for_reading() const;
  // Open an object by its path below `parent`. They do not follow links to other files, which may
  // be pipes or devices.
  Handle open_dataset(hid_t parent, const std::string& name) const;
  Handle open_group(hid_t parent, const std::string& name) const;
  std::vector<hsize_t> dimensions(hid_t dataset) const;
  // Rejects a dataset that stores fewer bytes than `entries` numbers need, or more bytes than the
  // file has. Call it before allocating memory: a file of a few bytes can claim any shape.
  // Compressed data may need up to two thousand times the bytes stored, and a chunk may too.
  // Virtual and external datasets are rejected: they take their numbers from other datasets or
  // files, whose bytes this check cannot count.
  void require_stored(hid_t dataset, const std::string& name, double entries) const;
  // Returns the names of a group's members in order of creation or, if the group does not record
  // that order, sorted by name.
  std::vector<std::string> members(hid_t group) const;

 private:
  std::string path_;
};

// Returns a simple data space of these dimensions. Datasets can grow up to `maximum`. If `maximum`
// is empty, they cannot grow.
Handle make_space(const std::vector<hsize_t>& dimensions, const std::vector<hsize_t>& maximum = {});

// Access properties with which HDF5 opens no object through a link to another file.
hid_t own_datasets();
hid_t own_groups();

// Returns true if the shape is that of an image of positions: [rows, cols, 3] or [patches, rows,
// cols, 3]. The number of texels must be positive and at most 2^30.
bool is_image(const std::vector<hsize_t>& shape);
// Returns the number of values of a dataset of this shape: the product of the sizes.
hsize_t count_of(const std::vector<hsize_t>& shape);
bool holds_numbers(hid_t dataset);

// Returns the innermost message of HDF5's error stack, which names the cause.
std::string error_text();

}  // namespace weft::sim::hdf5
