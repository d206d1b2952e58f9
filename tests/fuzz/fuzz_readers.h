// Gives the readers of Weft input of any kind. A fuzzer mutates the input (fuzz_entry.cpp), and a
// test replays the committed corpora (tests/sim/fuzz_corpus_test.cpp).
//
// Each function returns for any input. It aborts, or a sanitizer does, if a reader fails in another
// way than by an error for the user, or breaks a promise that the function checks.
#pragma once

#include <string_view>

namespace weft::sim {

// Reads a case. The input may have sections (input_files.h): `overrides` holds texts for --set,
// line by line, and others are files that the case may include. A case that is accepted must be
// read again from its resolved text, and resolve to the same text.
void fuzz_case(std::string_view input);

// Reads a sweep, and plans its runs if they are at most 64. The sections of the input are the files
// that the sweep may name, such as `case.toml`.
void fuzz_sweep(std::string_view input);

// Reads a dataset as a shape. The first line of the input is the path of the dataset. The lines
// after it describe the file (described_hdf5.h), or are its bytes if they start as HDF5 files do.
// HDF5 itself may crash on bytes, so they are read by a process of their own, as in Weft.
void fuzz_shape(std::string_view input);

// Reads a trajectory, which the input describes or holds as fuzz_shape() has it. Lines that start
// with `do` name what is done with it:
//   do info | crossings | resume | copy
//   do outputs NAME = EXPRESSION
//   do render [colour=FIELD] [lod=PIXELS] [level=LEVEL] [spheres=LEVEL]
//   do restart TIME
//   do checkpoint HEXADECIMAL     reads the bytes as those of a checkpoint
void fuzz_trajectory(std::string_view input);

}  // namespace weft::sim
