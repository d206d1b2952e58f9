# Eigen aligns its types for the vector instructions it may use. Libraries built with -march=native
# and a program built without it would disagree on their layout, so those who link Weft from outside
# are told the alignment it was built with.
include(CheckCXXSourceCompiles)
set(CMAKE_REQUIRED_LIBRARIES Eigen3::Eigen)
if(WEFT_NATIVE)
  set(CMAKE_REQUIRED_FLAGS -march=native)
endif()
set(weft_eigen_alignment 16)
foreach(bytes 32 64)
  check_cxx_source_compiles("
    #include <Eigen/Core>
    static_assert(EIGEN_MAX_ALIGN_BYTES >= ${bytes});
    int main() {}" WEFT_EIGEN_ALIGNS_TO_${bytes})
  if(WEFT_EIGEN_ALIGNS_TO_${bytes})
    set(weft_eigen_alignment ${bytes})
  endif()
endforeach()
unset(CMAKE_REQUIRED_LIBRARIES)
unset(CMAKE_REQUIRED_FLAGS)
set(weft_outside_definitions
  EIGEN_MAX_ALIGN_BYTES=${weft_eigen_alignment} EIGEN_MAX_STATIC_ALIGN_BYTES=${weft_eigen_alignment})
