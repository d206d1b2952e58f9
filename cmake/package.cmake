# The package that find_package(weft) finds after `cmake --install`.
include(CMakePackageConfigHelpers)
set(weft_package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/weft)

# weft_rooms are the rooms that are built, weft_ROOM_rooms those that ROOM uses, and weft_ROOM_packages the packages
# that whoever links ROOM must have. HDF5 and SUNDIALS are named by path in weft_sim.cmake: our headers do not
# include theirs.
set(weft_rooms bsi materials)
set(weft_bsi_packages "Eigen3 3.4 NO_MODULE" "OpenMP COMPONENTS CXX")
set(weft_materials_packages "Eigen3 3.4 NO_MODULE")
if(WEFT_GPU)
  list(APPEND weft_rooms gpu)
  set(weft_gpu_rooms bsi)
  set(weft_gpu_packages PNG)
endif()
if(WEFT_SIM)
  set(weft_sim_rooms ${weft_rooms})
  list(APPEND weft_rooms sim)
  set(weft_sim_packages "tomlplusplus 3.3" "muparser 2.3")
endif()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/weftConfig.cmake.in
  ${PROJECT_BINARY_DIR}/weftConfig.cmake INSTALL_DESTINATION ${weft_package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/weftConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/weftConfig.cmake ${PROJECT_BINARY_DIR}/weftConfigVersion.cmake
  DESTINATION ${weft_package_folder})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
foreach(room IN LISTS weft_rooms)
  install(EXPORT weft_${room} NAMESPACE weft:: DESTINATION ${weft_package_folder})
endforeach()
