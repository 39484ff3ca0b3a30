# What `cmake --install` gives a host beside the command and the OpenImageIO module: the public headers, all rooms
# as one archive, and cohort.pc, which says how to link them and where the module lies.
get_property(rooms GLOBAL PROPERTY COHORT_ROOMS)
list(APPEND rooms cohort_shim_osd cohort_shim_oiio cohort_shim_ocio)
set(archive ${CMAKE_BINARY_DIR}/lib/libcohort.a)
set(merge "CREATE ${archive}\n")
foreach(room IN LISTS rooms)
  string(APPEND merge "ADDLIB $<TARGET_FILE:${room}>\n")
endforeach()
file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/lib/libcohort.mri CONTENT "${merge}SAVE\nEND\n")
add_custom_command(OUTPUT ${archive}
  COMMAND sh -c "'${CMAKE_AR}' -M < '${CMAKE_BINARY_DIR}/lib/libcohort.mri'"
  DEPENDS ${rooms} ${CMAKE_BINARY_DIR}/lib/libcohort.mri VERBATIM)
add_custom_target(cohort_archive ALL DEPENDS ${archive})

configure_file(${CMAKE_CURRENT_LIST_DIR}/cohort.pc.in ${CMAKE_BINARY_DIR}/lib/cohort.pc @ONLY)
install(FILES ${archive} DESTINATION lib)
install(FILES ${CMAKE_BINARY_DIR}/lib/cohort.pc DESTINATION lib/pkgconfig)
foreach(top renderer usda_loader delegate)
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/${top}/include/cohort DESTINATION include)
endforeach()
