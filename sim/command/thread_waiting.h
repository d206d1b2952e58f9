// How long threads that wait for each other keep their processors.
#pragma once

namespace weft::sim {

// Lets threads that wait for each other give their processors away after some 20 microseconds. By
// default, those of libgomp keep them for milliseconds. Where other processes want the processors,
// the thread that is waited for then often has none, and a run takes up to twenty times as long
// (docs/decisions/0025). libgomp reads the length from the environment before main(). This function
// therefore starts the program again with the same arguments, in the same process, with
// GOMP_SPINCOUNT set. It does nothing if the environment already says how to wait. Precondition:
// nothing has been read or written yet.
void shorten_waiting(char** arguments);

}  // namespace weft::sim
