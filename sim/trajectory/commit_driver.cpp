#include "sim/trajectory/commit_driver.h"

#include <fcntl.h>
#include <unistd.h>
#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <new>
#include <string>
#include <unordered_set>
#include <vector>

namespace weft::sim {
namespace {

constexpr haddr_t superblock_address = 0;

struct CommitFile : H5FD_t {
  int descriptor = -1;
  haddr_t end_of_allocation = 0;
  haddr_t size = 0;  // size of the file on disk (bytes)
  haddr_t commit_mark = HADDR_UNDEF;
  std::string failure;  // reason of the first failed write; later writes are not made
  std::map<haddr_t, std::vector<unsigned char>> pending;  // metadata by address, without overlaps
  std::unordered_set<haddr_t> written;                    // addresses of metadata on disk
};

CommitFile& as_commit_file(H5FD_t* file) { return *static_cast<CommitFile*>(file); }
const CommitFile& as_commit_file(const H5FD_t* file) {
  return *static_cast<const CommitFile*>(file);
}

herr_t report(const char* function, int error) {
  H5Epush2(H5E_DEFAULT, __FILE__, function, 0, H5E_ERR_CLS, H5E_VFL, H5E_WRITEERROR, "%s",
           std::strerror(error));
  return -1;
}

// Records a failed write. The error is not passed on to HDF5, which would keep objects open that
// could never be closed.
void remember_failure(CommitFile& file, int error) { file.failure = std::strerror(error); }

void write_to_disk(CommitFile& file, haddr_t address, const unsigned char* bytes,
                   std::size_t count) {
  if (!file.failure.empty()) return;
  while (count > 0) {
    const ssize_t done = pwrite(file.descriptor, bytes, count, static_cast<off_t>(address));
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) {
      remember_failure(file, done < 0 ? errno : ENOSPC);
      return;
    }
    address += static_cast<haddr_t>(done);
    bytes += done;
    count -= static_cast<std::size_t>(done);
    file.size = std::max(file.size, address);
  }
}

void resize_on_disk(CommitFile& file, haddr_t size) {
  if (!file.failure.empty()) return;
  if (ftruncate(file.descriptor, static_cast<off_t>(size)) != 0) {
    remember_failure(file, errno);
    return;
  }
  file.size = size;
}

// Removes the pending bytes in [address, address + size), which newer bytes will replace.
void forget_pending(CommitFile& file, haddr_t address, std::size_t size) {
  const haddr_t end = address + size;
  auto entry = file.pending.upper_bound(address);
  if (entry != file.pending.begin()) --entry;
  while (entry != file.pending.end() && entry->first < end) {
    const haddr_t start = entry->first;
    const haddr_t stop = start + entry->second.size();
    if (stop <= address) {
      ++entry;
      continue;
    }
    const std::vector<unsigned char> old = std::move(entry->second);
    entry = file.pending.erase(entry);
    const auto offset = [&](haddr_t at) { return old.begin() + static_cast<long>(at - start); };
    if (start < address) file.pending[start].assign(old.begin(), offset(address));
    if (stop > end) file.pending[end].assign(offset(end), old.end());
  }
}

// Writes the pending metadata in the order that commit_driver.h promises. After a failed write, all
// later writes are skipped, which preserves the order.
void commit(CommitFile& file) {
  const auto write_where = [&](auto&& condition) {
    for (const auto& [address, bytes] : file.pending) {
      if (condition(address)) write_to_disk(file, address, bytes.data(), bytes.size());
    }
  };
  const auto is_special = [&](haddr_t address) {
    return address == superblock_address || address == file.commit_mark;
  };
  const auto is_new = [&](haddr_t address) { return !file.written.contains(address); };

  write_where([&](haddr_t address) { return !is_special(address) && is_new(address); });
  // The file must grow before its superblock is written, because readers refuse a file that is
  // shorter than its superblock says.
  if (file.size < file.end_of_allocation) resize_on_disk(file, file.end_of_allocation);
  write_where([](haddr_t address) { return address == superblock_address; });
  write_where([&](haddr_t address) { return !is_special(address) && !is_new(address); });
  write_where([&](haddr_t address) { return address == file.commit_mark; });
  for (const auto& [address, bytes] : file.pending) file.written.insert(address);
  file.pending.clear();
}

H5FD_t* open_file(const char* name, unsigned flags, hid_t, haddr_t) {
  // This driver only creates files. Readers use HDF5's own driver.
  if ((flags & H5F_ACC_CREAT) == 0) {
    report(__func__, ENOTSUP);
    return nullptr;
  }
  const int descriptor = open(name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    report(__func__, errno);
    return nullptr;
  }
  auto* file = new (std::nothrow) CommitFile();
  if (file == nullptr) {
    ::close(descriptor);
    report(__func__, ENOMEM);
    return nullptr;
  }
  file->descriptor = descriptor;
  return file;
}

herr_t close_file(H5FD_t* base) {
  CommitFile& file = as_commit_file(base);
  commit(file);
  if (file.size > file.end_of_allocation) resize_on_disk(file, file.end_of_allocation);
  ::close(file.descriptor);
  delete &file;
  return 0;
}

herr_t query_features(const H5FD_t*, unsigned long* flags) {
  // The flags that let HDF5 merge pieces of metadata are left out, since the driver needs each
  // piece separately.
  *flags = H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t end_of_allocation(const H5FD_t* base, H5FD_mem_t) {
  return as_commit_file(base).end_of_allocation;
}

herr_t set_end_of_allocation(H5FD_t* base, H5FD_mem_t, haddr_t address) {
  as_commit_file(base).end_of_allocation = address;
  return 0;
}

haddr_t end_of_file(const H5FD_t* base, H5FD_mem_t) { return as_commit_file(base).size; }

herr_t file_handle(H5FD_t* base, hid_t, void** handle) {
  *handle = base;
  return 0;
}

herr_t read_bytes(H5FD_t* base, H5FD_mem_t, hid_t, haddr_t address, std::size_t size,
                  void* buffer) {
  CommitFile& file = as_commit_file(base);
  auto* bytes = static_cast<unsigned char*>(buffer);
  std::size_t done = 0;
  while (done < size) {
    const ssize_t count =
        pread(file.descriptor, bytes + done, size - done, static_cast<off_t>(address + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return report(__func__, errno);
    if (count == 0) break;  // bytes beyond the end of the file count as zero
    done += static_cast<std::size_t>(count);
  }
  std::fill(bytes + done, bytes + size, static_cast<unsigned char>(0));
  auto entry = file.pending.upper_bound(address);
  if (entry != file.pending.begin()) --entry;
  for (; entry != file.pending.end() && entry->first < address + size; ++entry) {
    const haddr_t start = std::max(entry->first, address);
    const haddr_t stop = std::min<haddr_t>(entry->first + entry->second.size(), address + size);
    if (start >= stop) continue;
    std::memcpy(bytes + (start - address), entry->second.data() + (start - entry->first),
                stop - start);
  }
  return 0;
}

// Stores a write of HDF5. The function is noexcept because an exception for lack of memory must not
// unwind through HDF5.
herr_t write_bytes(H5FD_t* base, H5FD_mem_t type, hid_t, haddr_t address, std::size_t size,
                   const void* buffer) noexcept {
  CommitFile& file = as_commit_file(base);
  const auto* bytes = static_cast<const unsigned char*>(buffer);
  if (type == H5FD_MEM_DRAW) {
    write_to_disk(file, address, bytes, size);
  } else {
    forget_pending(file, address, size);
    file.pending[address].assign(bytes, bytes + size);
  }
  return 0;
}

herr_t flush_file(H5FD_t* base, hid_t, hbool_t) {
  commit(as_commit_file(base));
  return 0;
}

// Does nothing: commit() grows the file, and close_file() shrinks it after the last commit.
herr_t truncate_file(H5FD_t*, hid_t, hbool_t) { return 0; }

H5FD_class_t make_driver_class() {
  H5FD_class_t driver{};
#if H5_VERSION_GE(1, 13, 2)
  driver.version = H5FD_CLASS_VERSION;
  driver.value = static_cast<H5FD_class_value_t>(600);  // outside the range that HDF5 reserves
#endif
  driver.name = "weft_commit";
  driver.maxaddr = (static_cast<haddr_t>(1) << 62) - 1;
  driver.fc_degree = H5F_CLOSE_STRONG;
  driver.open = open_file;
  driver.close = close_file;
  driver.query = query_features;
  driver.get_eoa = end_of_allocation;
  driver.set_eoa = set_end_of_allocation;
  driver.get_eof = end_of_file;
  driver.get_handle = file_handle;
  driver.read = read_bytes;
  driver.write = write_bytes;
  driver.flush = flush_file;
  driver.truncate = truncate_file;
  return driver;
}

hid_t driver_identifier() {
  static const H5FD_class_t driver_class = make_driver_class();
  static const hid_t identifier = H5FDregister(&driver_class);
  return identifier;
}

}  // namespace

herr_t set_commit_driver(hid_t file_access) {
  const hid_t driver = driver_identifier();
  if (driver < 0 || H5Pset_driver(file_access, driver, nullptr) < 0) return -1;
  return H5Pset_libver_bounds(file_access, H5F_LIBVER_V110, H5F_LIBVER_V110);
}

herr_t set_commit_allocation(hid_t file_creation) {
  if (H5Pset_file_space_strategy(file_creation, H5F_FSPACE_STRATEGY_PAGE, false, 1) < 0) return -1;
  return H5Pset_file_space_page_size(file_creation, commit_page_size);
}

herr_t set_commit_mark(hid_t file, hid_t object) {
  void* handle = nullptr;
  H5O_info_t information;
  if (H5Fget_vfd_handle(file, H5P_DEFAULT, &handle) < 0) return -1;
  if (H5Oget_info(object, &information) < 0 || information.hdr.nchunks != 1) return -1;
  static_cast<CommitFile*>(handle)->commit_mark = information.addr;
  return 0;
}

int commit_descriptor(hid_t file) {
  void* handle = nullptr;
  if (H5Fget_vfd_handle(file, H5P_DEFAULT, &handle) < 0) return -1;
  return static_cast<const CommitFile*>(handle)->descriptor;
}

std::string commit_failure(hid_t file) {
  void* handle = nullptr;
  if (H5Fget_vfd_handle(file, H5P_DEFAULT, &handle) < 0) return "the file is closed";
  return static_cast<const CommitFile*>(handle)->failure;
}

}  // namespace weft::sim
