# Installs what is built, and builds and runs programs that find it there.
# cmake -D build=… -D source=… -D work=… -D flags=… -D sim=… -P package_test.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nexit code ${code}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(configure ${CMAKE_COMMAND} -G Ninja -S ${source} -D CMAKE_BUILD_TYPE=None
  -D CMAKE_PREFIX_PATH=${work}/prefix -D CMAKE_CXX_FLAGS=${flags})
file(REMOVE_RECURSE ${work})
run(${CMAKE_COMMAND} --install ${build} --prefix ${work}/prefix)

# Of bsi/, the headers in its root are installed, and no kernel (docs/decisions/0037-public-headers.md).
file(GLOB public RELATIVE ${source}/../../bsi ${source}/../../bsi/*.h)
file(GLOB installed RELATIVE ${work}/prefix/include/weft/bsi ${work}/prefix/include/weft/bsi/*.h)
file(GLOB_RECURSE private ${work}/prefix/include/weft/*/kernels/*.h)
if(NOT public STREQUAL installed OR NOT public MATCHES "pyramid.h" OR private)
  message(FATAL_ERROR "bsi/ has the headers ${public} in its root; installed: ${installed}; kernels: ${private}")
endif()

# bsi/ alone is found, linked and run on a machine without the packages of the other rooms.
set(without "")
foreach(package SUNDIALS HDF5 OpenGL PNG PkgConfig tomlplusplus muparser nlohmann_json CLI11 GTest)
  list(APPEND without -D CMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
endforeach()
run(${configure} -B ${work}/bsi -D components=bsi ${without})
run(${CMAKE_COMMAND} --build ${work}/bsi)

# All vertices lie within 0.4 m of the centre, half the diagonal of their box is 0.57 m. A sphere of
# the pyramid holds the boxes of leaf blocks too, which are 0.16 m long here.
run(${work}/bsi/radius)
if(output LESS 0.4 OR output GREATER 0.48)
  message(FATAL_ERROR "the torus of radius 0.4 m has a bounding sphere of ${output}")
endif()

# The layers of the spiral in self_contact.cpp are 1 mm apart; its chords, of 1/32 turn, come nearer by
# 1 - cos(pi / 32) = 0.5 %. Brute force over all pairs of triangles without a common vertex, in a program that does
# not use Weft, found 5632 pairs within 1.1 mm, the nearest 0.994415 mm apart.
run(${work}/bsi/self_contact 0.0009)
if(NOT output MATCHES "^[0-9]+ candidates, 0 hits\n$")
  message(FATAL_ERROR "no layer is within 0.9 mm of another:\n${output}")
endif()
run(${work}/bsi/self_contact 0.0011)
if(NOT output MATCHES "\n[0-9]+ candidates, 5632 hits\n$")
  message(FATAL_ERROR "5632 pairs of triangles are within 1.1 mm:\n${output}")
endif()
string(REGEX MATCHALL " 0\\.00[0-9]*\n" distances "${output}")
list(SORT distances)
list(GET distances 0 nearest)
if(NOT nearest MATCHES "0\\.000994415")
  message(FATAL_ERROR "the nearest pair is 0.000994415 m apart, not ${nearest}")
endif()

# A component that does not exist, or whose packages are missing, is named.
function(refuse components reason)
  execute_process(COMMAND ${configure} -B ${work}/refused --fresh -D components=${components} ${without}
    RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")
  if(code EQUAL 0 OR NOT output MATCHES "${reason}")
    message(FATAL_ERROR "components ${components} should be refused: \"${reason}\"\n${output}")
  endif()
endfunction()
refuse(silk "Weft has no component 'silk' here; there are: bsi, materials")
if(NOT sim)
  file(REMOVE_RECURSE ${work})
  return()
endif()
refuse(sim "weft::sim needs tomlplusplus 3.3, which was not found")

run(${configure} -B ${work}/build)
run(${CMAKE_COMMAND} --build ${work}/build)
file(WRITE ${work}/case.toml [=[
time.duration = 0.05
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [5, 5] }
]=])
run(${work}/build/simulate ${work}/case.toml ${work}/case.h5)
run(${work}/prefix/bin/weft info ${work}/case.h5)
if(NOT output MATCHES "frames +4,")
  message(FATAL_ERROR "three frames were to follow the first one:\n${output}")
endif()
file(REMOVE_RECURSE ${work})
