# Two helpers, so that a stage's CMakeLists.txt is a list of its sources.

# Strict warnings for our own code; third-party headers are SYSTEM and exempt.
add_library(angio_warnings INTERFACE)
set(shadow -Wshadow)
if(ANGIO_UNITY)  # a constant within a function may be called as one of a source beside it
  set(shadow -Wshadow=local)
endif()
target_compile_options(angio_warnings INTERFACE
  $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wconversion ${shadow} -Wnon-virtual-dtor -Woverloaded-virtual>)
# GCC 12 warns of overlapping copies inside its own std::string (GCC bug 105651).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(angio_warnings INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Wno-restrict>)
endif()
if(ANGIO_WARNINGS_AS_ERRORS)
  target_compile_options(angio_warnings INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Werror>)
endif()
if(ANGIO_CHECKS)
  target_compile_definitions(angio_warnings INTERFACE ANGIO_CHECKS)
endif()

# How a quick build (ANGIO_QUICK_BUILD) optimises what nothing waits for, or all tests do.
function(angio_optimize_quick_build name options)
  if(ANGIO_QUICK_BUILD)
    target_compile_options(${name} PRIVATE "$<$<COMPILE_LANGUAGE:CXX>:${options}>")
  endif()
endfunction()
if(ANGIO_QUICK_BUILD)  # its kernels are compiled, to see that they can be; where they run, there is a GPU to build for
  add_compile_options("$<$<COMPILE_LANG_AND_ID:CUDA,NVIDIA>:SHELL:-Xcicc -O1 -Xptxas -O1>")
endif()

# angio_add_library(NAME SOURCES ... [PUBLIC ...] [PRIVATE ...] [LIGHT|HEAVY])
# Makes the static library angio_NAME and its alias angio::NAME. LIGHT: it does no heavy work. HEAVY: tests wait for it.
function(angio_add_library name)
  cmake_parse_arguments(ARG "LIGHT;HEAVY" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(angio_${name} STATIC ${ARG_SOURCES})
  add_library(angio::${name} ALIAS angio_${name})
  target_compile_features(angio_${name} PUBLIC cxx_std_20)
  target_include_directories(angio_${name} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(angio_${name} PUBLIC ${ARG_PUBLIC} PRIVATE angio_warnings ${ARG_PRIVATE})
  # Ten sources at a time: their headers cost more than they do.
  set_target_properties(angio_${name} PROPERTIES UNITY_BUILD ${ANGIO_UNITY} UNITY_BUILD_BATCH_SIZE 10)
  if(ARG_LIGHT)
    angio_optimize_quick_build(angio_${name} -O1)
  elseif(ARG_HEAVY)
    angio_optimize_quick_build(angio_${name} -O3)
  endif()
endfunction()

add_custom_target(all_tests)  # what ctest starts, and with it the program

# angio_add_test(NAME SOURCES ... LINK ... [LABEL unit|gpu|pipeline] [TIMEOUT seconds] [EACH])
# One GoogleTest program, and one test of CTest, so that 2,000 cases do not load the libraries 2,000 times.
# EACH: a test of CTest a case, where a second one in the same process does not work.
# CTest starts those with the longest time limit first.
function(angio_add_test name)
  cmake_parse_arguments(ARG "EACH" "LABEL;TIMEOUT" "SOURCES;LINK" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 600)
  endif()
  set(properties LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT} COST ${ARG_TIMEOUT})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE angio::testing ${ARG_LINK} angio_warnings GTest::gtest_main GTest::gmock)
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${ANGIO_UNITY} UNITY_BUILD_BATCH_SIZE 8)
  add_dependencies(all_tests ${name})
  if(ARG_LABEL STREQUAL "pipeline")  # the work is done by the program that they start
    angio_optimize_quick_build(${name} "-O0;-g0")
  else()
    angio_optimize_quick_build(${name} "-O1;-g0")
  endif()
  if(ARG_EACH)
    gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES ${properties})
  else()
    add_test(NAME ${name} COMMAND ${name})
    set_tests_properties(${name} PROPERTIES ${properties})
  endif()
endfunction()
