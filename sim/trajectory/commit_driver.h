// An HDF5 file driver whose files stay readable if the process that writes them dies. Private to
// sim/.
//
// HDF5 alone does not promise that. Between two flushes it may write some of its metadata and not
// the rest. A file of the 1.10 format carries a mark "open for writing" that makes readers refuse
// it. Single-writer mode (SWMR) keeps that mark and forbids new objects. This driver
//  - keeps every metadata write in memory until HDF5 flushes the file; raw data goes to disk at
//  once,
//    since nothing on disk points to it yet;
//  - then writes in an order in which each prefix is a consistent file: first metadata at addresses
//    never written before, then the superblock (whose end-of-file covers them), then changed
//    metadata in place, and last one chosen object, the commit mark;
//  - has no lock method, so HDF5 sets no mark and readers may open the file while it is written.
// It relies on three properties of how Weft uses HDF5. Nothing is ever deleted, so no address is
// used twice. No two pieces of metadata that are changed in place must agree with each other: chunk
// indices are extensible arrays, and growing groups keep their links in the object header. The file
// space is paged, so a piece smaller than a page (4 KiB) never crosses a page border, and a signal
// does not tear its write; only chunk indices of more than ~8000 frames have larger pieces. The
// driver guards against the death of the process, not of the machine: it does not fsync.
#pragma once

#include <hdf5.h>

#include <string>

namespace weft::sim {

// Page size of files made with set_commit_allocation, bytes.
inline constexpr hsize_t commit_page_size = 4096;

// Sets the driver in a file access property list, with the newest file format that HDF5 1.10 reads.
// Returns a negative value on failure, like HDF5's own functions.
herr_t set_commit_driver(hid_t file_access);
// Sets the paged allocation the driver relies on in a file creation property list.
herr_t set_commit_allocation(hid_t file_creation);
// Makes the open dataset `object` the commit mark of the open `file`. Returns a negative value on
// failure: the dataset's header must be a single piece.
herr_t set_commit_mark(hid_t file, hid_t object);
// The descriptor of the open file; -1 if it is closed.
int commit_descriptor(hid_t file);
// The reason why a write to disk failed, or empty. After a failure nothing more is written, so the
// file stays as last committed. HDF5's functions still succeed then: callers must ask here after
// each flush.
std::string commit_failure(hid_t file);

}  // namespace weft::sim
