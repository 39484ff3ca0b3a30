# cohort_room(NAME SOURCES ... [DEPENDS ...]): one room as a static library that sees the headers of
# its own top-level folder and of everything it depends on.
function(cohort_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;DEPENDS;INCLUDES" ${ARGN})
  add_library(${name} STATIC ${ROOM_SOURCES})
  target_include_directories(${name} PUBLIC ${ROOM_INCLUDES})
  target_link_libraries(${name} PUBLIC ${ROOM_DEPENDS} PRIVATE cohort_flags OpenMP::OpenMP_C m)
endfunction()

# cohort_test(NAME SOURCE DEPENDS ...): one cmocka program, registered with ctest under its name.
function(cohort_test name source)
  add_executable(${name} ${source})
  target_link_libraries(${name} PRIVATE ${ARGN} cohort_flags OpenMP::OpenMP_C cmocka m)
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  target_compile_definitions(${name} PRIVATE
    COHORT_SHARED_DIR="${COHORT_SHARED}" COHORT_TEST_DATA_DIR="${CMAKE_SOURCE_DIR}/tests/data")
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT 300)
endfunction()
