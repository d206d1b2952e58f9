// The entry point of libFuzzer. WEFT_FUZZ_READER is the function that gets the input.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/fuzz_readers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  weft::sim::WEFT_FUZZ_READER({reinterpret_cast<const char*>(data), size});
  return 0;
}
