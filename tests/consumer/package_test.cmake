# Installs what is built, and builds and runs a program that finds it there.
# cmake -D build=… -D source=… -D work=… -D flags=… -P package_test.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nexit code ${code}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${work})
run(${CMAKE_COMMAND} --install ${build} --prefix ${work}/prefix)
run(${CMAKE_COMMAND} -G Ninja -S ${source} -B ${work}/build -D CMAKE_BUILD_TYPE=Debug
  -D CMAKE_PREFIX_PATH=${work}/prefix -D CMAKE_CXX_FLAGS=${flags})
run(${CMAKE_COMMAND} --build ${work}/build)

# All vertices lie within 0.4 m of the centre, half the diagonal of their box is 0.57 m. A sphere of
# the pyramid holds the boxes of leaf blocks too, which are 0.16 m long here.
run(${work}/build/radius)
if(output LESS 0.4 OR output GREATER 0.48)
  message(FATAL_ERROR "the torus of radius 0.4 m has a bounding sphere of ${output}")
endif()

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
