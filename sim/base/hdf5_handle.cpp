#include "sim/base/hdf5_handle.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "sim/base/file_error.h"
#include "sim/base/file_status.h"

namespace weft::sim::hdf5 {
namespace {

// Keeps HDF5 from closing its library at exit. HDF5 1.10 never frees some memory of chunks with a
// wrong checksum, and closing would print "infinite loop closing library" on stderr. No data is
// lost, because every Handle closes its object.
[[maybe_unused]] const herr_t no_closing_at_exit = H5dont_atexit();

// Upper bound of the compression ratio of a chunk. zlib reaches 1032.
constexpr double most_compression = 2000;

herr_t keep_innermost(unsigned position, const H5E_error2_t* error, void* text) {
  if (position == 0 && error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
  return 0;
}

herr_t append_name(hid_t, const char* name, const H5L_info_t*, void* names) {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}

// Fails, so that HDF5 does not follow a link to another file.
herr_t refuse_link(const char*, const char*, const char*, const char*, unsigned*, hid_t, void*) {
  return -1;
}

Handle within_file(hid_t kind) {
  Handle properties(H5Pcreate(kind));
  H5Pset_elink_cb(properties.get(), refuse_link, nullptr);
  return properties;
}

// Returns the number of entries of a chunk; 0 for other layouts.
double size_of_chunk(hid_t properties, H5D_layout_t layout) {
  if (layout != H5D_CHUNKED) return 0;
  std::array<hsize_t, H5S_MAX_RANK> size{};
  const int rank = H5Pget_chunk(properties, static_cast<int>(size.size()), size.data());
  double entries = 1;
  for (int axis = 0; axis < rank; ++axis) entries *= static_cast<double>(size[axis]);
  return entries;
}

// Returns a whole number as text.
std::string rounded(double number) {
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), "%.0f", number);
  return text.data();
}

Handle string_type() {
  Handle type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

}  // namespace

QuietErrors::QuietErrors() {
  H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

QuietErrors::~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }

std::string error_text() {
  std::string text;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &text);
  return text.empty() ? "HDF5 gave no reason" : text;
}

hid_t own_datasets() {
  static const Handle properties = within_file(H5P_DATASET_ACCESS);
  return properties.get();
}

hid_t own_groups() {
  static const Handle properties = within_file(H5P_GROUP_ACCESS);
  return properties.get();
}

Handle make_space(const std::vector<hsize_t>& dimensions, const std::vector<hsize_t>& maximum) {
  return Handle(H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(),
                                 maximum.empty() ? nullptr : maximum.data()));
}

// Largest number of texels of an image. It fits an int, while a file may claim any size.
constexpr hsize_t largest_texel_count = 1 << 30;

bool is_image(const std::vector<hsize_t>& shape) {
  if (shape.size() < 3 || shape.size() > 4 || shape.back() != 3) return false;
  hsize_t count = 1;
  for (std::size_t i = 0; i + 1 < shape.size(); ++i) {
    if (shape[i] == 0 || shape[i] > largest_texel_count) return false;
    count *= shape[i];
    if (count > largest_texel_count) return false;
  }
  return true;
}

hsize_t count_of(const std::vector<hsize_t>& shape) {
  hsize_t count = 1;
  for (const hsize_t size : shape) count *= size;
  return count;
}

bool holds_numbers(hid_t dataset) {
  const Handle type(H5Dget_type(dataset));
  const H5T_class_t kind = H5Tget_class(type.get());
  return kind == H5T_FLOAT || kind == H5T_INTEGER;
}

void Access::fail(const std::string& action) const {
  throw FileError(path_ + ": cannot " + action + ": " + error_text());
}

void Access::reject(const std::string& reason) const { throw FileError(path_ + ": " + reason); }

void Access::write_attribute(hid_t object, const std::string& name,
                             const std::string& value) const {
  const std::string action = "write attribute " + name;
  const Handle type = string_type();
  const Handle space(H5Screate(H5S_SCALAR));
  const Handle attribute = handle(
      H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), action);
  const char* text = value.c_str();
  check(H5Awrite(attribute.get(), type.get(), &text), action);
}

void Access::write_attribute(hid_t object, const std::string& name, double value) const {
  const std::string action = "write attribute " + name;
  const Handle space(H5Screate(H5S_SCALAR));
  const Handle attribute = handle(
      H5Acreate2(object, name.c_str(), H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT),
      action);
  check(H5Awrite(attribute.get(), H5T_NATIVE_DOUBLE, &value), action);
}

void Access::write_attribute(hid_t object, const std::string& name,
                             const std::vector<int>& values) const {
  const std::string action = "write attribute " + name;
  const Handle space = values.size() == 1 ? Handle(H5Screate(H5S_SCALAR))
                                          : make_space({static_cast<hsize_t>(values.size())});
  const Handle attribute =
      handle(H5Acreate2(object, name.c_str(), H5T_STD_I32LE, space.get(), H5P_DEFAULT, H5P_DEFAULT),
             action);
  check(H5Awrite(attribute.get(), H5T_NATIVE_INT, values.data()), action);
}

std::string Access::read_string(hid_t object, const std::string& name) const {
  const std::string action = "read attribute " + name;
  const Handle attribute = handle(H5Aopen(object, name.c_str(), H5P_DEFAULT), action);
  const Handle stored(H5Aget_type(attribute.get()));
  const Handle space(H5Aget_space(attribute.get()));
  if (H5Tis_variable_str(stored.get()) <= 0 || H5Sget_simple_extent_npoints(space.get()) != 1) {
    reject("attribute " + name + " is not a string");
  }
  char* text = nullptr;
  check(H5Aread(attribute.get(), string_type().get(), &text), action);
  std::string value = text == nullptr ? "" : text;
  H5free_memory(text);
  return value;
}

double Access::read_double(hid_t object, const std::string& name) const {
  const std::string action = "read attribute " + name;
  const Handle attribute = handle(H5Aopen(object, name.c_str(), H5P_DEFAULT), action);
  const Handle space(H5Aget_space(attribute.get()));
  if (H5Sget_simple_extent_npoints(space.get()) != 1) reject("attribute " + name + " is a list");
  double value = 0;
  check(H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, &value), action);
  return value;
}

std::vector<int> Access::read_integers(hid_t object, const std::string& name) const {
  const std::string action = "read attribute " + name;
  const Handle attribute = handle(H5Aopen(object, name.c_str(), H5P_DEFAULT), action);
  const Handle space(H5Aget_space(attribute.get()));
  const hssize_t count = check(H5Sget_simple_extent_npoints(space.get()), action);
  std::error_code unknown;
  if (static_cast<double>(count) * sizeof(int) >
      static_cast<double>(std::filesystem::file_size(path_, unknown))) {
    reject("attribute " + name + " claims more than the file holds");
  }
  std::vector<int> values(static_cast<std::size_t>(count));
  if (count > 0) check(H5Aread(attribute.get(), H5T_NATIVE_INT, values.data()), action);
  return values;
}

Handle Access::open_for_reading() const {
  const auto status = status_of(path_);
  if (!std::filesystem::exists(status)) reject("no such file");
  if (std::filesystem::is_directory(status)) reject("is a directory");
  // Opening a pipe would wait for its writer, and opening a device would read it.
  if (!std::filesystem::is_regular_file(status)) reject("is not a regular file");
  if (::access(path_.c_str(), R_OK) != 0)
    reject(std::string("cannot be read: ") + std::strerror(errno));
  const Handle file_access(H5Pcreate(H5P_FILE_ACCESS));
#if H5_VERSION_GE(1, 10, 7)
  H5Pset_file_locking(file_access.get(), false, true);
#endif
  // HDF5 reads the file's size before its content, so a file that grows in between looks truncated.
  // A failed opening is repeated if the file's size has changed meanwhile.
  std::error_code error;
  for (;;) {
    const auto size = std::filesystem::file_size(path_, error);
    const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDONLY, file_access.get());
    if (file >= 0) return Handle(file);
    if (std::filesystem::file_size(path_, error) == size) {
      fail("open as an HDF5 file");
    }
  }
}

Handle Access::open_dataset(hid_t parent, const std::string& name) const {
  return handle(H5Dopen2(parent, name.c_str(), own_datasets()), "open dataset " + name);
}

Handle Access::open_group(hid_t parent, const std::string& name) const {
  return handle(H5Gopen2(parent, name.c_str(), own_groups()), "open group " + name);
}

std::vector<hsize_t> Access::dimensions(hid_t dataset) const {
  const Handle space = handle(H5Dget_space(dataset), "read a shape");
  const int rank = check(H5Sget_simple_extent_ndims(space.get()), "read a shape");
  std::vector<hsize_t> result(static_cast<std::size_t>(rank));
  check(H5Sget_simple_extent_dims(space.get(), result.data(), nullptr), "read a shape");
  return result;
}

void Access::require_stored(hid_t dataset, const std::string& name, double entries) const {
  const std::string action = "look into dataset " + name;
  const Handle properties = handle(H5Dget_create_plist(dataset), action);
  const H5D_layout_t layout = check(H5Pget_layout(properties.get()), action);
  if (layout == H5D_VIRTUAL || H5Pget_external_count(properties.get()) > 0) {
    reject("dataset " + name + " takes its numbers from elsewhere (" +
           (layout == H5D_VIRTUAL ? "virtual" : "external") +
           " storage); expected one that stores them itself");
  }
  const Handle type = handle(H5Dget_type(dataset), action);
  const double needed = entries * static_cast<double>(H5Tget_size(type.get()));
  const auto stored = static_cast<double>(H5Dget_storage_size(dataset));
  const bool compressed = layout == H5D_CHUNKED && H5Pget_nfilters(properties.get()) > 0;
  std::error_code unknown;
  if (stored > static_cast<double>(std::filesystem::file_size(path_, unknown))) {
    reject("dataset " + name + " claims to store more than the file holds");
  }
  // HDF5 reads whole chunks into memory.
  const double chunk = entries > 0 ? size_of_chunk(properties.get(), layout) : 0;
  const double least = std::max(needed, chunk * static_cast<double>(H5Tget_size(type.get())));
  if (stored * (compressed ? most_compression : 1) >= least) return;
  reject("dataset " + name + " claims " + rounded(least) + " bytes and stores " + rounded(stored));
}

std::vector<std::string> Access::members(hid_t group) const {
  std::vector<std::string> names;
  hsize_t position = 0;
  const std::string action = "list a group";
  const Handle properties = handle(H5Gget_create_plist(group), action);
  unsigned order = 0;
  check(H5Pget_link_creation_order(properties.get(), &order), action);
  const H5_index_t index =
      (order & H5P_CRT_ORDER_TRACKED) != 0 ? H5_INDEX_CRT_ORDER : H5_INDEX_NAME;
  check(H5Literate(group, index, H5_ITER_INC, &position, append_name, &names), action);
  return names;
}

}  // namespace weft::sim::hdf5
