// An HDF5 file driver for files that must be readable whenever the process that writes them dies.
// Private to sim/.
//
// HDF5 alone does not promise that: between two flushes it may write some of its metadata and not
// the rest, a file of the 1.10 format carries a mark "open for writing" that makes readers refuse
// it, and single-writer mode (SWMR) keeps that mark and forbids new objects. This driver
//  - keeps every metadata write in memory until HDF5 flushes the file (raw data goes to disk at
//    once: it lies where nothing on disk points yet);
//  - then writes in an order in which each prefix is a consistent file: first metadata at addresses
//    never written before, then the superblock (whose end-of-file covers them), then changed
//    metadata in place, and last of all one chosen object: the commit mark;
//  - has no lock method, so HDF5 sets no mark and readers may open the file while it is written.
// It relies on three properties of how Weft uses HDF5: nothing is ever deleted, so no address is
// used twice; no two pieces of metadata changed in place must agree with each other (chunk indices
// are extensible arrays, groups that grow keep their links in the object header); and the file
// space is paged, so a piece smaller than a page (4 KiB) never crosses a page border and one write
// of it is not torn by a signal. Only chunk indices of more than ~8000 frames have larger pieces.
// It guards against the death of the process, not of the machine: nothing is fsync'ed.
#pragma once

#include <hdf5.h>

#include <string>

namespace weft::sim {

// Size of a page of a file made with set_commit_allocation, bytes.
inline constexpr hsize_t commit_page_size = 4096;

// Sets the driver in a file access property list, with the newest file format that HDF5 1.10 reads.
// Negative on failure, as HDF5's own functions.
herr_t set_commit_driver(hid_t file_access);
// Sets the paged allocation the driver relies on in a file creation property list.
herr_t set_commit_allocation(hid_t file_creation);
// Makes `object` (a dataset whose header is one piece) the commit mark of `file`, both open. The
// header must not be split over several pieces: negative then.
herr_t set_commit_mark(hid_t file, hid_t object);
// The descriptor of the open file; -1 where it is closed.
int commit_descriptor(hid_t file);
// Why the disk refused to take something, or empty. After a failure nothing more is written, so the
// file stays as it was last committed; HDF5's functions go on to succeed, and whoever calls them
// must ask here after each flush.
std::string commit_failure(hid_t file);

}  // namespace weft::sim
