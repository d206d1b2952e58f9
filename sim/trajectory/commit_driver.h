// An HDF5 file driver whose files stay readable if the process that writes them dies. Private to
// sim/.
//
// HDF5 alone does not promise this. Between two flushes it may write some of its metadata and not
// the rest. Files of the 1.10 format also carry a mark "open for writing" while they are written,
// and readers refuse a file with this mark. Single-writer mode (SWMR) keeps the mark and forbids
// new objects.
//
// This driver keeps every metadata write in memory until HDF5 flushes the file. It writes raw data
// to disk at once: nothing on disk points to a new chunk yet, and a list's last chunk is rewritten
// with its old entries unchanged. A flush writes the metadata in the following order. After each of
// these writes, the file on disk is consistent:
//   1. metadata at addresses never written before;
//   2. the superblock, whose end-of-file covers that metadata;
//   3. changed metadata, in place;
//   4. the header of one chosen dataset, the commit mark.
// The driver has no lock method, so HDF5 sets no mark and readers may open the file while it is
// written.
//
// The driver relies on three properties of how Weft uses HDF5:
// - Nothing is ever deleted, so no address is used twice.
// - Pieces of metadata that change in place need not agree with each other: chunk indices are
//   extensible arrays, and growing groups keep their links in the object header.
// - The file space is paged, so a piece of metadata smaller than a page (4 KiB) crosses no border
//   between pages, and a signal does not tear its write. Only chunk indices of more than about 8000
//   frames have larger pieces.
//
// The driver guards against the death of the process, not of the machine: it does not call fsync().
#pragma once

#include <hdf5.h>

#include <string>

namespace weft::sim {

// Page size (bytes) of files that are created with set_commit_allocation().
inline constexpr hsize_t commit_page_size = 4096;

// Sets this driver and the file format of HDF5 1.10 in a file access property list. Returns a
// negative value on failure, like HDF5's own functions.
herr_t set_commit_driver(hid_t file_access);
// Sets the paged allocation of file space, which the driver needs, in a file creation property
// list. Returns a negative value on failure.
herr_t set_commit_allocation(hid_t file_creation);
// Makes the open dataset `object` the commit mark of the open file. Returns a negative value on
// failure, also if the dataset's header has more than one piece.
herr_t set_commit_mark(hid_t file, hid_t object);
// Returns the file descriptor of the open file, or -1 if the file is closed.
int commit_descriptor(hid_t file);
// Returns the reason why a write to disk failed, or an empty text if no write has failed. After a
// failure nothing more is written, so the committed frames stay readable. Because HDF5's functions
// still report success then, call this function after each flush.
std::string commit_failure(hid_t file);

}  // namespace weft::sim
