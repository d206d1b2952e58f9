// An HDF5 file driver whose files stay readable if the process that writes them dies. Private to
// sim/.
//
// HDF5 alone does not promise this. Between two flushes it may write some of its metadata and not
// the rest. A file of the 1.10 format carries a mark "open for writing" that makes readers refuse
// it. Single-writer mode (SWMR) keeps that mark and forbids new objects.
//
// This driver keeps every metadata write in memory until HDF5 flushes the file. Raw data goes to
// disk at once, since nothing on disk points to it yet. A flush writes the metadata in an order in
// which each prefix is a consistent file:
//   1. metadata at addresses never written before;
//   2. the superblock, whose end-of-file covers that metadata;
//   3. changed metadata, in place;
//   4. one chosen object, the commit mark.
// The driver has no lock method, so HDF5 sets no mark and readers may open the file while it is
// written.
//
// The driver relies on three properties of how Weft uses HDF5. Nothing is ever deleted, so no
// address is used twice. No two pieces of metadata that change in place must agree with each other:
// chunk indices are extensible arrays, and growing groups keep their links in the object header.
// The file space is paged, so a piece smaller than a page (4 KiB) never crosses a page border, and
// a signal does not tear its write. Only chunk indices of more than about 8000 frames have larger
// pieces. The driver guards against the death of the process, not of the machine: it does not
// fsync.
#pragma once

#include <hdf5.h>

#include <string>

namespace weft::sim {

// Page size of files made with set_commit_allocation() (bytes).
inline constexpr hsize_t commit_page_size = 4096;

// Sets this driver in a file access property list, and the newest file format that HDF5 1.10 reads.
// Returns a negative value on failure, like HDF5's own functions.
herr_t set_commit_driver(hid_t file_access);
// Sets the paged allocation that the driver needs, in a file creation property list. Returns a
// negative value on failure.
herr_t set_commit_allocation(hid_t file_creation);
// Makes the open dataset `object` the commit mark of the open `file`. Returns a negative value on
// failure, also if the dataset's header has more than one piece.
herr_t set_commit_mark(hid_t file, hid_t object);
// Returns the descriptor of the open file, or -1 if the file is closed.
int commit_descriptor(hid_t file);
// Returns the reason why a write to disk failed; empty if none failed. After a failure nothing more
// is written, so the committed frames stay readable. HDF5's functions still report success then:
// call this after each flush.
std::string commit_failure(hid_t file);

}  // namespace weft::sim
