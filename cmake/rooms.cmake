# cohort_room(NAME SOURCES ... [DEPENDS ...]): one room as a static library that sees the headers of
# its own top-level folder and of everything it depends on.
function(cohort_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;DEPENDS;INCLUDES" ${ARGN})
  add_library(${name} STATIC ${ROOM_SOURCES})
  set_property(GLOBAL APPEND PROPERTY COHORT_ROOMS ${name}) # cmake/install.cmake
  target_include_directories(${name} PUBLIC ${ROOM_INCLUDES})
  target_link_libraries(${name} PUBLIC ${ROOM_DEPENDS} PRIVATE cohort_flags OpenMP::OpenMP_C m)
endfunction()

# cohort_kernels(OUT NAME SOURCE [OPTIONS ...]): SOURCE compiled once per instruction set, as NAME_kernel_ISA; the
# objects go to OUT. They see the headers of ${renderer_includes}. Which one runs is chosen at run time, so nothing
# else may be compiled with these options.
function(cohort_kernels out name source)
  set(isas scalar)
  set(scalar_options)
  set(sse42_options -msse4.2 -mpopcnt)
  set(avx2_options -mavx2 -mfma -mpopcnt -mbmi -mbmi2)
  set(avx512_options ${avx2_options} -mavx512f -mavx512vl -mavx512dq -mavx512bw)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    list(APPEND isas sse42 avx2 avx512)
  endif()
  set(objects)
  set(number 0) # of simd/lane.h
  foreach(isa IN LISTS isas)
    set(kernel ${name}_kernel_${isa})
    add_library(${kernel} OBJECT ${source})
    target_include_directories(${kernel} PRIVATE ${renderer_includes})
    target_compile_definitions(${kernel} PRIVATE CO_LANE_ISA=${number})
    target_compile_options(${kernel} PRIVATE -O3 ${ARGN} ${${isa}_options})
    target_link_libraries(${kernel} PRIVATE cohort_flags)
    list(APPEND objects $<TARGET_OBJECTS:${kernel}>)
    math(EXPR number "${number} + 1")
  endforeach()
  set(${out} ${objects} PARENT_SCOPE)
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

# cohort_kernel_symbols(TEST NAME): the kernels NAME hold functions of their own and no data, and call nothing: what
# was compiled with one's options cannot end up in another, and libm, which differs by machine, stays out.
function(cohort_kernel_symbols test name)
  if(COHORT_SANITIZE) # sanitizers add data of their own
    return()
  endif()
  set(objects)
  foreach(isa scalar sse42 avx2 avx512)
    if(TARGET ${name}_kernel_${isa})
      list(APPEND objects $<TARGET_OBJECTS:${name}_kernel_${isa}>)
    endif()
  endforeach()
  add_test(NAME ${test} COMMAND_EXPAND_LISTS
    COMMAND sh ${CMAKE_SOURCE_DIR}/tests/accel/kernel_symbols.sh ${CMAKE_NM} ${objects})
endfunction()
